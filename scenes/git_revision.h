#pragma once
/// Which state of the source this program was built from.

namespace wick::scenes {

/// As `git describe --always --dirty` names it; "unknown" where the source was no checkout.
const char* git_revision();

}  // namespace wick::scenes
