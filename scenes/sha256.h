#pragma once
/// SHA-256 [FIPS 180-4]: the checksum that every system has a tool for.
#include <string>
#include <string_view>

namespace wick::scenes {

/// 64 lower-case hexadecimal digits, as `sha256sum` prints them.
std::string sha256(std::string_view bytes);

}  // namespace wick::scenes
