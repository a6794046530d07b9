/// Sheets that touch themselves and each other: an exact count of crossings judges.
#include "solid/sheet_contact.h"

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "tests/solid/sheet_group.h"

namespace wick::solid {
namespace {

constexpr double kFrame = 1.0 / 60.0;

/// Two sheets shot at each other, from half a thickness to 200 thicknesses a substep, at all angles: no crossing in
/// any frame, momentum to rounding, and no energy from nowhere.
TEST(SheetContact, SheetsThatMeetFastDoNotCross) {
  for (const double thicknesses : {0.5, 2.0, 5.0, 20.0, 200.0})
    for (const double angle : {0.0, 20.0, 60.0, 90.0}) {
      SCOPED_TRACE(::testing::Message() << thicknesses << " thicknesses a substep, " << angle << " degrees");
      Group group;
      ShellParams p = cotton();
      p.air_drag = 0.0;
      const double speed = thicknesses * p.thickness * p.substeps / kFrame;
      const Mat3 turn = turn_about(Vec3(1, 0.3, 0), angle);
      const Vec3 half(0.1, 0.1, 0.0);
      Sheet& lower = group.add(moved(equilateral(13, 13, 0.016), Mat3::Identity(), -half), p);
      Sheet& upper = group.add(moved(equilateral(11, 11, 0.021), turn, Vec3(0, 0, 0.13) - turn * half), p);
      for (Vec3& v : lower.state.v) v = Vec3(0, 0, 0.5 * speed);
      for (Vec3& v : upper.state.v) v = Vec3(0, 0.1 * speed, -0.5 * speed);
      ASSERT_EQ(group.crossings(), 0U);
      const Vec3 momentum = lower.momentum() + upper.momentum();
      const double energy = energy_of_motion(lower) + energy_of_motion(upper);
      const double scale = (momentum.norm() + lower.momentum().norm());
      std::size_t contacts = 0;
      for (int n = 0; n < std::clamp(static_cast<int>(0.5 / (speed * kFrame)), 4, 40); ++n) {
        group.step(kFrame);
        ASSERT_EQ(group.crossings(), 0U) << "step " << n;
        contacts += group.contact->report().contacts;
        EXPECT_EQ(group.contact->report().impossible, 0U);
      }
      EXPECT_TRUE(group.finite());
      EXPECT_NEAR((lower.momentum() + upper.momentum() - momentum).norm(), 0.0, 1e-10 * scale);
      EXPECT_LT(energy_of_motion(lower) + energy_of_motion(upper), energy);
      EXPECT_LT(lower.momentum().z(), 0.5 * speed * 160.0 * 1e-3 * 0.03) << "they have hit";
    }
}

/// A strip bent over on itself by its two ends, which then press on each other.
TEST(SheetContact, AStripFoldedOnItselfKeepsItsLayers) {
  Group group;
  Sheet& strip = group.add(equilateral(61, 9, 0.01), cotton());
  strip.pin_where([](const Vec3& x) { return x.x() < 0.015; });
  const std::size_t held = strip.pins.vertex.size();
  strip.pin_where([](const Vec3& x) { return x.x() > 0.585; });
  const std::vector<Vec3> from = strip.pins.target;
  for (int n = 1; n <= 90; ++n) {
    const double angle = std::min(n / 60.0, 1.0) * 175.0;
    const Mat3 turn = turn_about(Vec3::UnitY(), -angle);
    const Vec3 hinge(0.3, 0.0, 0.0);
    for (std::size_t k = held; k < from.size(); ++k)
      strip.pins.target[k] = hinge + turn * (from[k] - hinge) + Vec3(0, 0, n > 60 ? -0.0005 * (n - 60) : 0.0);
    group.step(kFrame);
    ASSERT_EQ(group.crossings(), 0U) << "frame " << n;
  }
  EXPECT_TRUE(group.finite());
  EXPECT_GT(group.contact->report().contacts, 20U);
}

/// Ten layers dropped on a floor come to rest in their order, a thickness apart.
TEST(SheetContact, AStackOfTenComesToRestInItsOrder) {
  constexpr int kLayers = 10;
  Group group;
  ShellParams p = cotton();
  for (int k = 0; k < kLayers; ++k) {
    // None wider than the one below, whose rims would let it droop.
    const Vec3 shift(5.5e-4 * k, 5e-4 * k, 0.002 + 0.003 * k);
    Sheet& sheet = group.add(moved(equilateral(11, 11, 0.01 - 1e-4 * k), Mat3::Identity(), shift), p);
    sheet.gravity = Vec3(0, 0, -9.81);
    sheet.obstacles.push_back({"floor", PlaneShape{Vec3::Zero(), Vec3::UnitZ()}, 0.5});
  }
  for (int n = 0; n < 120; ++n) {
    group.step(kFrame);
    ASSERT_EQ(group.crossings(), 0U) << "frame " << n;
  }
  double energy = 0.0, mass = 0.0;
  for (int k = 0; k < kLayers; ++k) {
    const Sheet& sheet = *group.sheets[k];
    energy += energy_of_motion(sheet);
    double height = 0.0;
    for (const Vec3& x : sheet.state.x) height += x.z() / static_cast<double>(sheet.state.x.size());
    for (const double m : sheet.inputs.mass) mass += m;
    EXPECT_NEAR(height, (k + 0.5) * p.thickness, 0.1 * p.thickness * (1.0 + k)) << "layer " << k;
  }
  EXPECT_LT(std::sqrt(2.0 * energy / mass), 5e-3) << "rms speed [m/s]";
}

/// On a held incline a sheet sticks below the angle of friction, and slides with g (sin a - mu cos a) above it.
TEST(SheetContact, FrictionHoldsAndBrakesAsCoulombSays) {
  for (const double degrees : {15.0, 40.0}) {
    Group group;
    group.params.friction = group.params.kinetic_friction = 0.5;
    ShellParams p = cotton();
    p.air_drag = 0.0;
    group.add(equilateral(41, 21, 0.021), p, false);
    Sheet& sheet = group.add(moved(equilateral(9, 9, 0.01), Mat3::Identity(), Vec3(0.2, 0.15, 0.001)), p);
    const double a = degrees * M_PI / 180.0;
    sheet.gravity = 9.81 * Vec3(std::sin(a), 0.0, -std::cos(a));
    const double settle = 0.2, time = 0.3;
    for (int n = 0; n < std::lround(settle / kFrame); ++n) group.step(kFrame);
    const Vec3 before = sheet.momentum();
    for (int n = 0; n < std::lround(time / kFrame); ++n) group.step(kFrame);
    double mass = 0.0;
    for (const double m : sheet.inputs.mass) mass += m;
    const double gained = (sheet.momentum() - before).x() / mass / time;
    const double expected = std::tan(a) < 0.5 ? 0.0 : 9.81 * (std::sin(a) - 0.5 * std::cos(a));
    EXPECT_NEAR(gained, expected, 0.1 * 9.81 * std::sin(a)) << degrees << " degrees";
    EXPECT_EQ(group.crossings(), 0U);
  }
}

/// A sheet held at two edges is pushed into one that is held all round: both stretch, nothing passes through, also
/// where hardly a substep resolves the motion. From every frame on with a contact made anew: the same bits.
TEST(SheetContact, SheetsThatPinsPressTogetherStayApart) {
  for (const int substeps : {5, 60}) {
    std::uint64_t hash[2];
    for (const bool interrupted : {false, true}) {
      Group group;
      ShellParams p;
      p.substeps = substeps;
      Sheet& lower = group.add(rectangle(10, 12, {0.3, 0.3}), p);
      Sheet& upper = group.add(moved(rectangle(8, 9, {0.2, 0.2}), Mat3::Identity(), Vec3(0.05, 0.06, 0.05)), p);
      lower.pin_where([](const Vec3& x) { return std::min({x.x(), x.y(), 0.3 - x.x(), 0.3 - x.y()}) < 1e-6; });
      upper.pin_where([](const Vec3& x) { return std::min(x.x() - 0.05, 0.25 - x.x()) < 1e-6; });
      const std::vector<Vec3> from = upper.pins.target;
      for (int n = 1; n <= 8; ++n) {
        for (std::size_t k = 0; k < from.size(); ++k) upper.pins.target[k] = from[k] - Vec3(0, 0, n / 24.0);
        if (interrupted) group.contact.reset();
        group.step(1.0 / 24.0);
        ASSERT_EQ(group.crossings(), 0U) << substeps << " substeps, frame " << n;
      }
      StateHash digest;
      for (const auto& sheet : group.sheets) visit(digest, sheet->state);
      hash[interrupted ? 1 : 0] = digest.digest();
    }
    EXPECT_EQ(hash[0], hash[1]) << substeps << " substeps";
  }
}

/// Sheets that start inside of each other's thickness come apart slowly, however short the substeps.
TEST(SheetContact, OverlapMakesLittleSpeed) {
  for (const int substeps : {20, 400}) {
    Group group;
    ShellParams p = cotton();
    p.air_drag = 0.0;
    p.substeps = substeps;
    group.add(equilateral(12, 12, 0.02), p);
    group.add(moved(equilateral(12, 12, 0.02), Mat3::Identity(), Vec3(0.01, 0.013, 1e-5)), p);
    for (int n = 0; n < 10; ++n) {
      group.step(kFrame);
      ASSERT_EQ(group.crossings(), 0U);
      for (const auto& sheet : group.sheets) EXPECT_LT(energy_of_motion(*sheet), 0.5 * mass(*sheet) * 0.3 * 0.3);
    }
  }
}

/// The same bits at one and two threads, and from a state with a contact made anew.
TEST(SheetContact, SameBitsAtOneAndTwoThreadsAndFromAState) {
  const auto run = [](int threads, bool interrupted) {
    ThreadLimit limit(threads);
    Group group;
    for (int k = 0; k < 2; ++k) {
      Sheet& sheet = group.add(
          moved(equilateral(41, 41, 0.01), turn_about(Vec3(1, 1, 0), 20.0 * k), Vec3(0, 0, 0.02 + 0.1 * k)),
          cotton());
      sheet.gravity = Vec3(0, 0, -9.81);
      sheet.obstacles.push_back({"floor", PlaneShape{Vec3::Zero(), Vec3::UnitZ()}, 0.5});
    }
    for (int n = 0; n < 24; ++n) {
      if (interrupted) group.contact.reset();
      group.step(kFrame);
    }
    EXPECT_GT(group.contact->report().contacts, 100U);
    StateHash hash;
    for (const auto& sheet : group.sheets) visit(hash, sheet->state);
    return hash.digest();
  };
  const std::uint64_t one = run(1, false);
  EXPECT_EQ(run(2, false), one);
  EXPECT_EQ(run(2, true), one);
}

/// A driven sheet goes through a held one: nothing can be done about that. A free one between them is caught, and
/// all of it is told.
TEST(SheetContact, TellsWhatDrivenSheetsForce) {
  Group group;
  group.add(moved(equilateral(9, 9, 0.01), Mat3::Identity(), Vec3(0, 0, 0)), cotton(), false);
  group.add(moved(equilateral(8, 8, 0.01), Mat3::Identity(), Vec3(0.001, 0.001, 0.004)), cotton());
  Sheet& press = group.add(moved(equilateral(9, 9, 0.0103), Mat3::Identity(), Vec3(0, 0, 0.01)), cotton(), false);
  for (Vec3& v : press.state.v) v = Vec3(0, 0, -0.2);
  std::size_t impossible = 0;
  for (int n = 0; n < 6; ++n) {
    group.step(kFrame);
    impossible += group.contact->report().impossible;
    ASSERT_TRUE(group.finite());
  }
  EXPECT_GT(impossible, 0U);
}

/// Two driven sheets that go through each other can only be told of; sheets that coincide from the start stay so.
TEST(SheetContact, WhatCannotMoveOrTouchesIsLeftAlone) {
  Group driven;
  driven.add(equilateral(9, 9, 0.01), cotton(), false);
  Sheet& other =
      driven.add(moved(equilateral(9, 9, 0.01), Mat3::Identity(), Vec3(0.001, 0.002, 0.004)), cotton(), false);
  for (Vec3& v : other.state.v) v = Vec3(0, 0, -0.5);
  driven.step(kFrame);
  EXPECT_GT(driven.contact->report().impossible, 0U);

  Group coincident;
  for (int k = 0; k < 2; ++k) coincident.add(equilateral(9, 9, 0.01), cotton());
  for (int n = 0; n < 5; ++n) coincident.step(kFrame);
  EXPECT_EQ(coincident.contact->report().impossible, 0U);
  for (const auto& sheet : coincident.sheets) EXPECT_LT(energy_of_motion(*sheet), 1e-12);
}

/// Sheets far apart, no triangles, one triangle, a pinned pair: nothing to do, done.
TEST(SheetContact, TrivialGroups) {
  for (const int layers : {1, 2}) {
    Group group;
    for (int k = 0; k < layers; ++k)
      group.add(moved(equilateral(2, 2, 0.01), Mat3::Identity(), Vec3(0, 0, 100.0 * k)), cotton());
    for (int n = 0; n < 3; ++n) group.step(kFrame);
    EXPECT_TRUE(group.finite());
    EXPECT_EQ(group.contact->report().contacts, 0U);
  }
}

}  // namespace
}  // namespace wick::solid
