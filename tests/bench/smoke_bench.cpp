#include <chrono>
#include <cmath>
#include <cstdio>
#include "core/parallel.h"
#include "fluid/advection.h"
using namespace wick; using namespace wick::fluid;
int main(int, char**) {
  const int n = 128;
  Grid g{n,n,n,1.0/n,Vec3::Zero()};
  Sides sides = {Side::closed,Side::closed,Side::closed,Side::closed,Side::closed,Side::open};
  FaceField u = make_face_field(g);
  for (int a=0;a<3;++a){ Int3 m=lattice_size(g,a);
    for (int k=0;k<m[2];++k)for(int j=0;j<m[1];++j)for(int i=0;i<m[0];++i){ Vec3 x=g.face_center(a,i,j,k);
      u[a][g.face(a,i,j,k)] = float(std::sin(3*x[(a+1)%3]+a)*std::cos(5*x[(a+2)%3])*std::sin(3.14159265*x[a])); } }
  Walls walls;
  CellField q(g.cells()), q2(g.cells()), q3(g.cells());
  for (size_t i=0;i<q.size();++i) q[i]=q2[i]=q3[i]=float(std::sin(i*0.001));
  for (int th : {1,2}) { ThreadLimit lim(th);
    Transport t(g,sides,{});
    auto time=[&](const char* name, auto f){ f(); double best=1e9; for(int r=0;r<5;++r){auto s=std::chrono::steady_clock::now(); f(); best=std::min(best,std::chrono::duration<double>(std::chrono::steady_clock::now()-s).count());} printf("%d threads %s %.2f ns/cell\n",th,name,best*1e9/g.cells()); };
    time("set_flow",[&]{t.set_flow(u,walls,2.0/n);});
    CellField* one[]={&q}; CellField* three[]={&q,&q2,&q3};
    time("SL 1",[&]{t.carry(one,Advection::semi_lagrangian);});
    time("SL 3",[&]{t.carry(three,Advection::semi_lagrangian);});
    time("MC 1",[&]{t.carry(one,Advection::maccormack);});
    time("MC 3",[&]{t.carry(three,Advection::maccormack);});
    FaceField w=u;
    time("MC u",[&]{t.carry(w,Advection::maccormack);});
    time("SL u",[&]{t.carry(w,Advection::semi_lagrangian);});
    time("cons 1",[&]{t.carry(one,Advection::conservative);});
  }
}
