#pragma once
/// The one way a file comes into being: its bytes are complete in memory, go to a temporary file beside the
/// target, are forced to the disk, read back and compared, and only then take the target's name. A reader
/// therefore sees the old file or the new one, never a part; a full disk is an error, never a short file.
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/function_ref.h"

namespace wick::scenes {

using Bytes = std::string;

/// Writes `bytes` as `path`. Throws Refusal naming the file and its size: output_cannot_be_made where the
/// place does not allow it, else input_output; what was there before stays, and no temporary file is left.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Sets space for `bytes` bytes aside in a file; false where there is none.
bool make_reserve(const std::filesystem::path& reserve, std::size_t bytes);

/// write_file for a disk that may be full: the bytes go into the space of `reserve`, which then takes the name of
/// `path`, so that nothing new is needed up to the size of the reserve. Where the file system cannot write in place
/// the reserve is given back first.
void write_file_from(const std::filesystem::path& reserve, const std::filesystem::path& path,
                     std::string_view bytes);

/// Reads a whole file of at most `limit` bytes. Throws Refusal: input_missing where it is not there or not
/// a file, scene_invalid where it is larger.
Bytes read_file(const std::filesystem::path& path, std::uint64_t limit);

/// Makes a folder and its parents. Throws Refusal (output_cannot_be_made).
void make_folder(const std::filesystem::path& folder);

/// The temporary name that write_file uses beside `path`.
std::filesystem::path temporary_path(const std::filesystem::path& path);

/// Removes temporary files that a killed run left in `folder`, of those targets whose names are `ours`.
void remove_temporaries(const std::filesystem::path& folder, FunctionRef<bool(const std::string& name)> ours);

}  // namespace wick::scenes
