#include "coupling/idle_parameters.h"

#include <algorithm>

namespace wick::coupling {

namespace {

class Finder {
 public:
  void note(bool idle, const std::string& pointer, const char* why) {
    if (idle) found_.push_back(pointer + ": has no effect (" + why + ")");
  }
  std::vector<std::string> take() { return std::move(found_); }

 private:
  std::vector<std::string> found_;
};

void look_at_shell(Finder& finder, const ShellSection& shell, const std::string& pointer, bool delta_acts) {
  finder.note(!shell.moves && !shell.pins.empty(), pointer + "/pins", "moves is false, which holds every vertex");
  finder.note(!shell.moves && !shell.velocity.isZero(), pointer + "/velocity", "moves is false");
  finder.note(shell.material.weaken_with_delta && !delta_acts, pointer + "/material/weaken_with_delta",
              "there is no diffusion section with a delta");
  finder.note(shell.tearing && (!shell.moves || shell.motion.kind != MotionKind::none), pointer + "/tearing",
              "the sheet is held, or moved by motion");
  for (std::size_t n = 0; n < shell.pins.size(); ++n)
    finder.note(!shell.pins[n].velocity.isZero() && shell.pins[n].stop_time <= 0.0,
                pointer + "/pins/" + std::to_string(n) + "/velocity", "stop_time is 0, so the pin never moves");
}

}  // namespace

std::vector<std::string> idle_parameters(const WorldParams& p) {
  Finder finder;
  for (std::size_t n = 0; n < p.shells.size(); ++n)
    look_at_shell(finder, p.shells[n], "/shells/" + std::to_string(n), p.diffusion && p.diffusion->delta > 0.0);
  for (std::size_t n = 0; n < p.heat_sources.size(); ++n) {
    const std::string pointer = "/heat_sources/" + std::to_string(n);
    finder.note(p.heat_sources[n].stop <= p.heat_sources[n].start, pointer,
                "it stops before it starts: stop is not above start");
    finder.note(!p.smoke && p.heat_sources[n].gas_power > 0.0, pointer + "/gas_power", "there is no smoke section");
    finder.note(!p.smoke && p.heat_sources[n].gas_smoke > 0.0, pointer + "/gas_smoke", "there is no smoke section");
  }
  const double ambient = p.ambient_temperature();
  for (std::size_t n = 0; n < p.heat_sources.size(); ++n)
    finder.note(p.diffusion && p.heat_sources[n].rate > 0.0 && p.heat_sources[n].temperature <= ambient,
                "/heat_sources/" + std::to_string(n) + "/temperature",
                "it is not above the ambient temperature, and sheets are not cooled below that");
  finder.note(p.smoke && p.heat.ambient_temperature != SheetHeatParams{}.ambient_temperature,
              "/heat/ambient_temperature", "/smoke/ambient_temperature is that of the scene");
  const auto computed = [](const ShellSection& s) { return s.moves && s.motion.kind == MotionKind::none; };
  finder.note(p.diffusion && p.diffusion->model == diffusion::Model::porous &&
                  p.diffusion->porous.effective_stress > 0.0 &&
                  std::none_of(p.shells.begin(), p.shells.end(), computed),
              "/diffusion/porous/effective_stress", "no sheet is moved by the shell solver");
  const BurningParams usual;
  const bool any_free = std::any_of(p.shells.begin(), p.shells.end(), computed);
  finder.note(p.burning && !any_free && p.burning->ember_size != usual.ember_size, "/burning/ember_size",
              "no sheet is moved by the shell solver, so that nothing falls");
  finder.note(p.burning && !any_free && p.burning->ember_life != usual.ember_life, "/burning/ember_life",
              "no sheet is moved by the shell solver, so that nothing falls");
  for (std::size_t n = 0; n < p.shells.size(); ++n)
    finder.note(
        !p.burning && p.shells[n].tearing && p.shells[n].tearing->char_strength != TearingParams{}.char_strength,
        "/shells/" + std::to_string(n) + "/tearing/char_strength", "there is no burning section");
  finder.note(p.burning && p.burning->removal > 0.0 && p.burning->removal <= p.burning->ash, "/burning/removal",
              "nothing burns below /burning/ash, which is not less");
  return finder.take();
}

}  // namespace wick::coupling
