#pragma once
#include <stdexcept>
#include <string>

namespace wick {

/// What the program tells its caller (sysexits numbers, so that a farm can act on them).
enum class ExitCode : int {
  done = 0,
  tests_failed = 1,
  command_line = 64,
  scene_invalid = 65,
  input_missing = 66,
  internal_fault = 70,
  output_cannot_be_made = 73,
  input_output = 74,  ///< a write failed, a full disk included
  checkpointed = 75,  ///< stopped on request: run the same command again
  numerical_failure = 76,
  refused = 77,  ///< the scene asks for more memory or disk than there is
};

/// A clean refusal: one line for the user, and the exit code that goes with it.
/// `pointer` is the JSON pointer of the parameter at fault, empty where there is none.
class Refusal : public std::runtime_error {
 public:
  Refusal(ExitCode code, std::string pointer, const std::string& message)
      : std::runtime_error(message), code_(code), pointer_(std::move(pointer)) {}
  [[nodiscard]] ExitCode code() const { return code_; }
  [[nodiscard]] const std::string& pointer() const { return pointer_; }

 private:
  ExitCode code_;
  std::string pointer_;
};

/// Checks what a user gave; always on. The message says: problem (why) suggestion.
inline void require(bool condition, const std::string& pointer, const std::string& message,
                    ExitCode code = ExitCode::scene_invalid) {
  if (!condition) throw Refusal(code, pointer, message);
}

}  // namespace wick
