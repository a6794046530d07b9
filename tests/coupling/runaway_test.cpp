/// What a runaway is blamed on: the parameter that a user would change.
#include "coupling/runaway.h"

#include <gtest/gtest.h>

#include "core/require.h"
#include "coupling/world.h"
#include "fluid/smoke_state.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// A box of gas, and in it a sheet, one of which is too fast.
class Runaway : public testing::Test {
 protected:
  Runaway() {
    params_.smoke = test::closed_box(4);
    params_.shells.push_back(test::flat_sheet(3, 0.5, 0.5));
    std::vector<std::string> warnings;
    sheets_.push_back(build_sheet(params_.shells[0], "/shells/0", params_, warnings));
    gas_ = fluid::make_smoke_state(*params_.smoke);
  }
  /// Pointer and message of the refusal; "none" where there is none.
  std::pair<std::string, std::string> refusal() {
    try {
      require_no_runaway({params_, sheets_, &gas_, 2, 0.5, 0.01, 4, 4, lengthened_});
    } catch (const Refusal& refused) {
      EXPECT_EQ(refused.code(), ExitCode::numerical_failure);
      return {refused.pointer(), refused.what()};
    }
    return {"none", ""};
  }
  void speed_up_gas() { gas_.velocity[2][20] = 2e5F; }
  void speed_up_sheet() { sheets_[0].state.v[4] = Vec3(0, 0, -3e5); }

  WorldParams params_;
  std::vector<Sheet> sheets_;
  fluid::SmokeState gas_;
  int lengthened_ = 0;
};

TEST_F(Runaway, IsNoneAtSensibleSpeeds) {
  sheets_[0].state.v[4] = Vec3(0, 0, 1e4);
  EXPECT_EQ(refusal().first, "none");
}

TEST_F(Runaway, OfStepsCutOffIsBlamedOnTheirNumber) {
  lengthened_ = 7;
  speed_up_gas();
  const auto [pointer, message] = refusal();
  EXPECT_EQ(pointer, "/coupling/max_substeps");
  EXPECT_EQ(message,
            "the gas moves at 2e+05 m/s in frame 2 at 0.5 s (a runaway: 7 steps of this frame were longer than the "
            "flow bears, as 256 are allowed) raise it, or take more frames a second (/fps)");
}

TEST_F(Runaway, OfTheGasIsBlamedOnWhatDrivesIt) {
  speed_up_gas();
  EXPECT_EQ(refusal().first, "/coupling/max_step") << "nothing is out of the ordinary";
  params_.smoke->cfl = 50;
  EXPECT_EQ(refusal().first, "/smoke/cfl");
  params_.gravity = Vec3(0, 0, -1e6);
  EXPECT_EQ(refusal().first, "/gravity");
  params_.smoke->buoyancy_smoke = -500;
  EXPECT_EQ(refusal().first, "/smoke/buoyancy_smoke");
  params_.smoke->buoyancy_heat = 500;
  EXPECT_EQ(refusal().first, "/smoke/buoyancy_heat");
  params_.smoke->vorticity = 1000;
  EXPECT_EQ(refusal().first, "/smoke/vorticity");
  params_.heat_sources = {{.gas_power = 1e3}, {.gas_power = 1e9}};
  gas_.temperature[5] = 1e6F;
  EXPECT_EQ(refusal().first, "/heat_sources/1/gas_power");
}

TEST_F(Runaway, OfASheetIsBlamedOnWhatMovesIt) {
  speed_up_sheet();
  EXPECT_EQ(refusal().first, "/shells/0/material/substeps");
  params_.gravity = Vec3(0, 0, -1e6);
  EXPECT_EQ(refusal().first, "/gravity");
  sheets_[0].params.motion.kind = MotionKind::wave;
  lengthened_ = 7;
  EXPECT_EQ(refusal().first, "/shells/0/motion") << "which is what it was told to do, in steps of any length";
}

}  // namespace
}  // namespace wick::coupling
