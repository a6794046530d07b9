#include <gtest/gtest.h>
#include "solid/primitives.h"
#include "solid/shell.h"
#include <chrono>
#include <cstdio>
#include "core/parallel.h"
using namespace wick; using namespace wick::solid;
TEST(Tmp, Speed) {
 for(int threads : {1,2}) { ThreadLimit lim(threads);
  for (double damping : {0.0, 1e-3}) {
  ShellMesh m = build_mesh(rectangle(140,140,{1,1},Lattice::staggered));
  ShellParams p; p.damping=damping;
  auto t0=std::chrono::steady_clock::now();
  ShellSolver s(m,p);
  double build=std::chrono::duration<double>(std::chrono::steady_clock::now()-t0).count();
  auto in=make_shell_inputs(m,p);
  ShellState st{m.rest, std::vector<Vec3>(m.vertex_count(),Vec3::Zero())};
  Pins pins; pins.vertex={0,139}; pins.target={m.rest[0],m.rest[139]};
  for(int f=0;f<20;++f){ auto r=s.step(st,m,in,pins,{}, {}, {}, {0,0,-9.81},1/60.0); if(f%5==4) std::printf("thr %d damp %g build %.2f ms step %.2f ms sub %d stretch %.4f speed %.3f lim %zu\n",threads,damping,build*1e3,r.seconds*1e3,r.substeps,r.max_stretch,r.max_speed,r.limited);}
 }}
}
