#include "solid/sheet_group.h"

#include <algorithm>
#include <chrono>

#include "core/parallel.h"

namespace wick::solid {

namespace {

constexpr std::size_t kGrain = 4096;

/// The rows of all sheets, one after the other.
struct Rows {
  std::vector<std::size_t> first;  ///< of each sheet, and one more
  std::vector<Row> x, start;
  std::vector<std::uint8_t> touched;

  explicit Rows(std::span<const GroupedSheet> sheets) : first(1, 0) {
    for (const GroupedSheet& s : sheets) first.push_back(first.back() + s.mesh->vertex_count());
    x.resize(first.back());
    touched.resize(first.back());
  }
};

/// Positions at `share` of the step: of the solvers as they are now, of the others on their straight way.
void gather_rows(std::span<const GroupedSheet> sheets, double share, Rows& rows) {
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    Row* const to = rows.x.data() + rows.first[s];
    const std::size_t count = rows.first[s + 1] - rows.first[s];
    if (sheets[s].solver != nullptr) {
      std::copy_n(sheets[s].solver->positions().begin(), count, to);
      continue;
    }
    const std::vector<Vec3>&from = *sheets[s].from, &end = sheets[s].state->x;
    parallel_for(count, kGrain, [&](std::size_t i) {
      const Vec3 p = share >= 1.0 ? end[i] : Vec3(from[i] + share * (end[i] - from[i]));
      to[i] = {p.x(), p.y(), p.z(), 0.0};
    });
  }
}

void scatter_rows(std::span<const GroupedSheet> sheets, const Rows& rows) {
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    if (sheets[s].solver == nullptr) continue;
    std::vector<Row>& to = sheets[s].solver->positions();
    const std::size_t first = rows.first[s];
    parallel_for(rows.first[s + 1] - first, kGrain, [&](std::size_t i) {
      const Row& r = rows.x[first + i];
      to[i] = {r.x, r.y, r.z, to[i].w};
    });
  }
}

/// What rests on an obstacle yields less than what rests on it, so that layers are pushed up and not down into the
/// obstacle.
void weigh_supported(std::span<const GroupedSheet> sheets, Rows& rows) {
  constexpr double kYield = 0.01;
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    if (sheets[s].solver == nullptr) continue;
    const std::vector<std::uint8_t>& supported = sheets[s].solver->touched();
    for (std::size_t i = 0; i < supported.size(); ++i)
      if (supported[i] != 0) rows.x[rows.first[s] + i].w *= kYield;
  }
}

/// What a contact has moved takes the speed of its way, and its piece has lost spin to the other.
void note_contacts(std::span<const GroupedSheet> sheets, const Rows& rows) {
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    if (sheets[s].solver == nullptr) continue;
    for (std::size_t i = rows.first[s]; i < rows.first[s + 1]; ++i)
      if (rows.touched[i] != 0) sheets[s].solver->note_contact(i - rows.first[s], rows.start[i]);
  }
}

}  // namespace

std::vector<ShellStepReport> step_together(std::span<GroupedSheet> sheets, SheetContact& contact, double dt) {
  std::vector<ShellStepReport> reports(sheets.size());
  if (!(dt > 0.0)) return reports;
  const auto clock = std::chrono::steady_clock::now();
  int substeps = 1;
  for (const GroupedSheet& s : sheets)
    if (s.solver != nullptr) substeps = std::max(substeps, substep_count(*s.params, dt));
  for (const GroupedSheet& s : sheets)
    if (s.solver != nullptr) s.solver->begin(*s.state, *s.loads, dt, substeps);
  Rows rows(sheets);
  gather_rows(sheets, 0.0, rows);
  contact.begin_step(rows.x, dt, substeps);
  for (int k = 0; k < substeps; ++k) {
    const double share = (k + 1.0) / substeps;
    for (const GroupedSheet& s : sheets)
      if (s.solver != nullptr) s.solver->deform(k);
    std::fill(rows.touched.begin(), rows.touched.end(), std::uint8_t{0});
    rows.start = rows.x;
    gather_rows(sheets, share, rows);
    contact.push_apart(rows.x, rows.touched);
    scatter_rows(sheets, rows);
    for (const GroupedSheet& s : sheets)
      if (s.solver != nullptr) s.solver->meet_obstacles(k);
    gather_rows(sheets, share, rows);
    weigh_supported(sheets, rows);
    contact.certify(rows.x, rows.touched);
    scatter_rows(sheets, rows);
    note_contacts(sheets, rows);
    for (const GroupedSheet& s : sheets)
      if (s.solver != nullptr) s.solver->end_substep();
  }
  for (std::size_t s = 0; s < sheets.size(); ++s)
    if (sheets[s].solver != nullptr) reports[s] = sheets[s].solver->end(*sheets[s].state, *sheets[s].mesh);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - clock).count();
  for (ShellStepReport& report : reports) report.seconds = seconds / static_cast<double>(sheets.size());
  return reports;
}

}  // namespace wick::solid
