#pragma once
/// What a farm or a person may ask of a running program.

namespace wick::scenes {

/// USR1: write a checkpoint after the substep and go on. TERM, INT, USR2: write one and stop; a second INT ends the
/// process at once.
void watch_signals();
/// Whether a stop has been asked for.
bool stop_requested();
/// Whether a checkpoint has been asked for since take_checkpoint_request() was last called.
bool checkpoint_requested();
/// The same, and answers the request.
bool take_checkpoint_request();

}  // namespace wick::scenes
