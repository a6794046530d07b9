#pragma once
/// What a farm or a person may ask of a running program.

namespace wick::scenes {

/// USR1: write a checkpoint and go on. TERM, INT, USR2: write one and stop after the frame; a second INT ends
/// the process at once.
void watch_signals();
/// Whether a stop has been asked for.
bool stop_requested();
/// Whether a checkpoint has been asked for since the last call.
bool take_checkpoint_request();

}  // namespace wick::scenes
