#pragma once
/// What the machine has and what the process uses of it.
#include <cstdint>
#include <string>

namespace wick::scenes {

/// Bytes that this process can still take: free memory, less where a control group or a limit says so.
std::uint64_t available_memory();
/// Largest resident memory of this process so far [bytes].
std::uint64_t peak_memory();
std::string host_name();
/// Folder of the running program.
std::string program_folder();
/// 3.2 GB, 410 MB, ...
std::string bytes_text(std::uint64_t bytes);
/// 12 s, 3 min 20 s, 2 h 5 min, ...
std::string seconds_text(double seconds);

}  // namespace wick::scenes
