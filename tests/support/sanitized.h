#pragma once
/// Whether this build carries the address sanitizer.

namespace wick::test {

/// The sanitizer keeps a shadow of all memory and holds back what is freed: such a build cannot run in a bounded
/// address space, and what it resides in is no measure of the program. Tests of memory skip themselves by this.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace wick::test
