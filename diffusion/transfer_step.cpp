/// Supply and spreading of the models that move amounts along edges, in place of Eq (8a).
#include <algorithm>

#include "diffusion/gravity_transport.h"
#include "diffusion/porous.h"
#include "diffusion/strain_diffusion_impl.h"

namespace wick::diffusion {

void DiffusionSolver::Impl::transfer(const DiffusionInput& in, double dt, Values& u_star, DiffusionReport& report) {
  const Values& mass = *in.mass;
  const bool scaled = params.reference == Reference::current;
  const TransferInput input{.mesh = in.mesh,
                            .graph = &graph,
                            .x = in.x,
                            .rest_scale = scaled ? in.rest_scale : nullptr,
                            .mass = &mass,
                            .loss = &loss,
                            .supply = &supply,
                            .supply_value = in.supply_value,
                            .capacity = in.capacity,
                            .gravity = in.gravity,
                            .dt = dt};

  // What is given explicitly is there from the start.
  for (std::size_t i = 0; i < u_star.size(); ++i)
    if (mass[i] > 0.0) u_star[i] = std::max(0.0, u_star[i] + amount[i] / mass[i]);

  TransferResult result;
  if (params.model == Model::porous) {
    build_edges(in, {Operator::cotan, 1.0, true});
    result = flow_through_pores(params.porous, input, op, params.tolerance, solver, u_star);
  } else {
    result = transport_by_gravity(params.gravity_transport, input, u_star);
  }

  report.solve = result.solve;
  report.lost = result.lost;
  for (std::size_t i = 0; i < u_star.size(); ++i)
    if (mass[i] > 0.0) given[i] = result.given[i] + amount[i];
  report.supplied = sum_of(u_star.size(), [&](std::size_t i) { return given[i]; });
}

}  // namespace wick::diffusion
