#include "coupling/runaway.h"

#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "core/require.h"
#include "fluid/smoke_state.h"

namespace wick::coupling {

namespace {

/// The parameter most likely at fault, why, and what to do.
struct Suspect {
  std::string pointer, why, advice;
};

[[noreturn]] void fail(const StepOutlook& o, const std::string& what, const Suspect& suspect) {
  throw Refusal(ExitCode::numerical_failure, suspect.pointer,
                what + " in frame " + std::to_string(o.frame) + " at " + number_text(o.time) +
                    " s (a runaway: " + suspect.why + ") " + suspect.advice);
}

/// Steps that were longer than the flow bears explain any speed.
bool steps_were_cut_off(const StepOutlook& o, Suspect& suspect) {
  if (o.lengthened_steps == 0) return false;
  suspect = {"/coupling/max_substeps",
             number_text(o.lengthened_steps) + " steps of this frame were longer than the flow bears, as " +
                 number_text(o.params.coupling.max_substeps) + " are allowed",
             "raise it, or take more frames a second (/fps)"};
  return true;
}

/// Tells whether a fall for the whole run, unhindered, gives half of `speed`.
bool gravity_explains(const StepOutlook& o, double speed) {
  return o.params.gravity.norm() * o.time > 0.5 * speed;
}

/// The source that gives most heat to the gas; -1 where none gives any.
int strongest_source(const WorldParams& params) {
  int strongest = -1;
  double power = 0.0;
  for (std::size_t n = 0; n < params.heat_sources.size(); ++n) {
    if (!(params.heat_sources[n].gas_power > power)) continue;
    power = params.heat_sources[n].gas_power;
    strongest = static_cast<int>(n);
  }
  return strongest;
}

Suspect suspect_of_gas(const StepOutlook& o, double speed) {
  constexpr double hot = 2e4;           // [K], hotter than any source or flame may be
  constexpr double wild_swirls = 10.0;  // [1/s], a hundred times the default
  constexpr double wide_steps = 5.0;    // cells
  const fluid::SmokeParams& smoke = *o.params.smoke;
  const double hottest =
      smoke.ambient_temperature + *std::max_element(o.gas->temperature.begin(), o.gas->temperature.end());
  const int source = strongest_source(o.params);
  if (source >= 0 && hottest > hot)
    return {"/heat_sources/" + std::to_string(source) + "/gas_power",
            "the gas is heated to " + number_text(hottest) + " K", "lower it, or widen the source"};
  if (smoke.vorticity >= wild_swirls)
    return {"/smoke/vorticity", "eddies grow " + number_text(smoke.vorticity) + " times a second", "lower it"};
  if (std::abs(smoke.buoyancy_heat) > wild_swirls)
    return {"/smoke/buoyancy_heat", "it lifts that many times what is physical", "bring it nearer to 1"};
  if (std::abs(smoke.buoyancy_smoke) > wild_swirls)
    return {"/smoke/buoyancy_smoke", "it weighs that many times what is physical", "bring it nearer to 1"};
  if (gravity_explains(o, speed))
    return {"/gravity", "it had that time to speed things up", "lower it, or shorten the run (/frames)"};
  if (smoke.cfl > wide_steps)
    return {"/smoke/cfl", "a step carries the gas over as many cells", "lower it to 2 or less"};
  return {"/coupling/max_step", "the gas gains speed from step to step, here of " + number_text(o.step) + " s",
          "shorten it"};
}

Suspect suspect_of_sheet(const StepOutlook& o, const Sheet& sheet, double speed) {
  if (sheet.driven())
    return {sheet.pointer + "/motion", "sheet \"" + sheet.name + "\" is moved so",
            "lower its amplitude, or give it more time"};
  if (gravity_explains(o, speed))
    return {"/gravity", "sheet \"" + sheet.name + "\" had that time to fall",
            "lower it, or shorten the run (/frames)"};
  return {sheet.pointer + "/material/substeps",
          "sheet \"" + sheet.name + "\" gains speed from step to step, " +
              number_text(sheet.params.material.substeps) + " of them in 1/60 s",
          "raise it, or make the sheet softer or heavier"};
}

}  // namespace

void require_no_runaway(const StepOutlook& o) {
  constexpr double fastest_sense = 1e5;  // [m/s]; ten times what a scene may ask of anything that moves
  // Within a frame the flow of a scene changes its speed by a few times, that of a runaway a few times each step.
  const double bearable = std::min<double>(o.params.coupling.max_substeps, 8.0 * std::max(o.first_wanted, 2.0));
  if (o.params.coupling.scheme == CouplingScheme::partitioned && o.wanted_steps > bearable)
    fail(o,
         "the partitioned scheme wants " + number_text(std::ceil(o.wanted_steps)) +
             " steps in a frame that began with " + number_text(std::ceil(o.first_wanted)) +
             " (or more than /coupling/max_substeps)",
         {"/coupling/scheme", "gas and sheet push each other ever harder",
          "use \"simultaneous\", a smaller /coupling/relaxation, or more steps a frame"});

  const double gas_speed = o.gas != nullptr ? fluid::fastest(o.gas->velocity) : 0.0;
  double speed = gas_speed;
  const Sheet* fastest = nullptr;
  for (const Sheet& sheet : o.sheets)
    for (const Vec3& v : sheet.state.v)
      if (v.norm() > speed) {
        speed = v.norm();
        fastest = &sheet;
      }
  if (!(speed > fastest_sense)) return;
  Suspect suspect;
  const bool told_to = fastest != nullptr && fastest->driven();
  if (told_to || !steps_were_cut_off(o, suspect))
    suspect = fastest != nullptr ? suspect_of_sheet(o, *fastest, speed) : suspect_of_gas(o, speed);
  fail(o, (fastest != nullptr ? "a sheet moves at " : "the gas moves at ") + number_text(speed) + " m/s", suspect);
}

}  // namespace wick::coupling
