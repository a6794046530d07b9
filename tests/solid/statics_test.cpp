/// Equilibria against beam, membrane and cable theory.
#include <gtest/gtest.h>

#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

/// Bends the plane about y: the point at distance x along the sheet goes to the cylinder of radius R.
std::vector<Vec3> rolled(const ShellMesh& mesh, double radius, double direction) {
  std::vector<Vec3> x;
  const double c = std::cos(direction), s = std::sin(direction);
  for (const Vec3& X : mesh.rest) {
    const double along = c * X.x() + s * X.y(), across = c * X.y() - s * X.x();
    const double a = radius * std::sin(along / radius), up = radius * (1.0 - std::cos(along / radius));
    x.emplace_back(c * a - s * across, s * a + c * across, up);
  }
  return x;
}

double rolled_energy(const ShellMesh& mesh, const ShellParams& params, double radius, double direction) {
  return elastic_energy(mesh, params, make_shell_inputs(mesh, params), rolled(mesh, radius, direction)).bending;
}

double area(const ShellMesh& mesh) {
  double sum = 0.0;
  for (const double a : mesh.rest_area) sum += a;
  return sum;
}

/// Area that hinges stand for: the thirds of triangles at inner edges.
double inner_area(const ShellMesh& mesh) {
  double sum = 0.0;
  for (const Hinge& h : mesh.hinges) sum += (mesh.rest_area[h.triangle[0]] + mesh.rest_area[h.triangle[1]]) / 3.0;
  return sum;
}

TEST(Rolled, EquilateralLatticeHasThePlatesEnergyInEveryDirection) {
  ShellParams params;
  params.bending = 1e-4;
  const ShellMesh mesh = build_mesh(equilateral(60, 60, 0.01));
  for (const double degrees : {0.0, 30.0, 45.0, 60.0, 90.0, 135.0}) {
    const double radius = 0.5;
    const double plate = params.bending * inner_area(mesh) / (2.0 * radius * radius);
    // The boundary is a few per cent of this mesh and not isotropic; the text asks for 3 %.
    EXPECT_NEAR(rolled_energy(mesh, params, radius, degrees * M_PI / 180.0) / plate, 1.0, 0.03) << degrees;
  }
}

TEST(Rolled, OtherLatticesAgreeInTheMeanOverDirections) {
  ShellParams params;
  params.bending = 1e-4;
  for (const Lattice lattice : {Lattice::grid, Lattice::union_jack}) {
    const ShellMesh mesh = build_mesh(rectangle(60, 60, {0.6, 0.6}, lattice));
    double mean = 0.0;
    for (int k = 0; k < 16; ++k) {
      const double ratio =
          rolled_energy(mesh, params, 0.5, k * M_PI / 16) / (params.bending * inner_area(mesh) * 2.0);
      mean += ratio / 16.0;
    }
    EXPECT_NEAR(mean, 1.0, 0.03);
  }
}

/// Flexural rigidity of a narrow strip along x whose long edges are free: they let it curve across as well, and it
/// takes the cross curvature of least energy. E(c) for z = (x² + c y²)/(2R) is a parabola, known from three of its
/// points.
double strip_rigidity(const ShellMesh& mesh, const ShellParams& params) {
  const double radius = 100.0;
  const auto energy = [&](double c) {
    std::vector<Vec3> x = mesh.rest;
    for (Vec3& p : x) p.z() = (p.x() * p.x() + c * p.y() * p.y()) / (2.0 * radius);
    return elastic_energy(mesh, params, make_shell_inputs(mesh, params), x).bending;
  };
  const double e0 = energy(0.0), slope = 0.5 * (energy(1.0) - energy(-1.0)),
               half = 0.5 * (energy(1.0) + energy(-1.0)) - e0;
  return (e0 - slope * slope / (4.0 * half)) * 2.0 * radius * radius / area(mesh);
}

struct Elastica {
  double G, drop;
};

/// Drop of the tip over the length of a cantilever of 60 elements under load G = q L³/B.
/// The time step resolves this sheet: B h²/(ρ t l⁴) is 0.003, so that the softening of one sweep is below 1 %.
double cantilever_drop(double G, int substeps, double dt) {
  const double spacing = 1.0 / 60.0;
  ShellParams params;
  params.thickness = 1e-3;
  params.density = 1e3;
  params.young_warp = params.young_weft = 5e4;
  params.poisson = 0.0;
  params.bending = 3.7e-4;
  params.damping = 0.0;
  params.air_drag = 0.13;
  params.substeps = substeps;
  const double B = params.bending;
  TriangleSoup soup = equilateral(63, 3, spacing);
  const ShellMesh mesh = build_mesh(soup);
  params.bending *= B / strip_rigidity(mesh, params);
  Sheet sheet(std::move(soup), params);
  sheet.pin_where([&](const Vec3& X) { return X.x() < 2.01 * spacing; });
  const double length = 1.0 + 0.5 * spacing;
  sheet.gravity = Vec3(0, 0, -G * B / (params.density * params.thickness * std::pow(length, 3)));
  sheet.run(150.0, dt);
  double drop = 0.0;
  int tips = 0;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i)
    if (mesh.rest[i].x() > 62.0 * spacing - 1e-9) {
      drop -= sheet.state.x[i].z();
      ++tips;
    }
  return drop / tips / length;
}

TEST(Elastica, DropOfAHeavyCantilever) {
  // Shooting solution of B θ'' = q (L − s) cos θ, θ(0) = 0, θ'(L) = 0.
  for (const Elastica& e :
       {Elastica{0.1, 0.01250}, {1, 0.12347}, {2, 0.23851}, {5, 0.49591}, {10, 0.70020}, {20, 0.82988}}) {
    const double drop = cantilever_drop(e.G, 20, 1.0 / 60.0);
    EXPECT_NEAR(drop / e.drop, 1.0, 0.03) << "G = " << e.G;
  }
}

TEST(Elastica, DoesNotDependOnSubstepsNorOnTheStep) {
  const double reference = cantilever_drop(5.0, 20, 1.0 / 60.0);
  EXPECT_NEAR(cantilever_drop(5.0, 40, 1.0 / 60.0) / reference, 1.0, 0.01);
  EXPECT_NEAR(cantilever_drop(5.0, 20, 1.0 / 240.0) / reference, 1.0, 0.01);
  EXPECT_NEAR(cantilever_drop(5.0, 20, 1.0 / 24.0) / reference, 1.0, 0.01);
}

TEST(Hanging, StripStretchesUnderItsOwnWeight) {
  ShellParams params;
  params.density = 1e3;
  params.thickness = 1e-3;
  params.poisson = 0.0;
  params.young_warp = params.young_weft = 2e6;
  params.damping = 0.0;
  params.air_drag = 20.0;
  params.substeps = 200;
  Sheet sheet(rectangle(3, 21, {0.1, 1.0}, Lattice::grid), params);
  sheet.pin_where([](const Vec3& X) { return X.y() > 0.999; });
  sheet.gravity = Vec3(0, -9.81, 0);
  sheet.run(4.0, 1.0 / 60.0);
  const double expected = 9.81 / (2.0 * 2e3);  // w L²/(2k), k = Y t
  double stretch = 0.0;
  for (int i = 0; i < 3; ++i) stretch -= sheet.state.x[i].y() / 3.0;
  EXPECT_NEAR(stretch / expected, 1.0, 0.02);
}

TEST(Hanging, CatenaryOfAnInextensibleStrip) {
  ShellParams params;
  params.density = 1e3;
  params.thickness = 1e-3;
  params.poisson = 0.0;
  params.young_warp = params.young_weft = 5e7;
  params.bending = 1e-7;
  params.damping = 0.0;
  params.air_drag = 3.0;
  params.substeps = 100;
  Sheet sheet(rectangle(41, 2, {2.0, 0.05}, Lattice::grid), params);
  sheet.pin_where([](const Vec3& X) { return X.x() < 1e-9 || X.x() > 2.0 - 1e-9; });
  // Bring the ends 1.5 apart: half length 1 = a sinh(0.75/a), sag = a (cosh(0.75/a) − 1).
  double a = 0.5;
  for (int k = 0; k < 60; ++k)
    a -= (a * std::sinh(0.75 / a) - 1.0) / (std::sinh(0.75 / a) - 0.75 / a * std::cosh(0.75 / a));
  const double sag = a * (std::cosh(0.75 / a) - 1.0);
  sheet.gravity = Vec3(0, 0, -9.81);
  for (int k = 1; k <= 60; ++k) {
    for (std::size_t p = 0; p < sheet.pins.vertex.size(); ++p)
      if (sheet.mesh.rest[sheet.pins.vertex[p]].x() > 1.0) sheet.pins.target[p].x() = 2.0 - 0.5 * k / 60.0;
    sheet.step(1.0 / 60.0);
  }
  sheet.run(5.0, 1.0 / 60.0);
  EXPECT_NEAR(-sheet.state.x[20].z() / sag, 1.0, 0.01);
}

TEST(Membrane, UniaxialPull) {
  ShellParams params;
  params.density = 1e3;
  params.thickness = 1e-3;
  params.poisson = 0.0;
  params.young_warp = 1e5;
  params.young_weft = 4e5;
  params.damping = 0.0;
  params.air_drag = 10.0;
  params.substeps = 100;
  for (const bool along_warp : {true, false}) {
    Sheet sheet(rectangle(11, 11, {1.0, 1.0}, Lattice::grid), params);
    const int axis = along_warp ? 0 : 1;
    sheet.pin_where([&](const Vec3& X) { return X[axis] < 1e-9; });
    const double k = (along_warp ? params.young_warp : params.young_weft) * params.thickness, pull = 0.4 * k;
    sheet.force.assign(sheet.mesh.vertex_count(), Vec3::Zero());
    for (std::size_t i = 0; i < sheet.mesh.vertex_count(); ++i) {
      const Vec3& X = sheet.mesh.rest[i];
      const double across = X[1 - axis];
      const double share = across < 1e-9 || across > 1.0 - 1e-9 ? 0.05 : 0.1;
      if (X[axis] > 1.0 - 1e-9) sheet.force[i][axis] = pull * share;
    }
    sheet.run(4.0, 1.0 / 60.0);
    const double F = sheet.state.x[along_warp ? 65 : 115][axis];
    EXPECT_NEAR(k * (F * F - 1.0) / 2.0 * F / pull, 1.0, 0.01);
  }
}

}  // namespace
}  // namespace wick::solid
