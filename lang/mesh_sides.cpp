// See mesh_sides.hpp.
#include "lang/mesh_sides.hpp"

#include "solver/discrete/probe_places.hpp"

#include <fmt/format.h>

namespace hvi::lang {

void report_several_values(Script& script, const solver::Discretisation& d) {
  const auto place = [&](const solver::Point& at) {
    return solver::describe_point(at, d.mesh.dim);
  };
  for (const auto& [probe, taken, other] : solver::several_values(script.plan->report, d))
    script.diagnostics.add(
        diagnose("W0613", span_of(script, probe->origin),
                 fmt::format("two sides meet at {}, each with a value of its own: this is that of "
                             "the cell around {}, not of the one around {}",
                             place(probe->point), place(taken), place(other)))
            .with_help("say which is meant: a piece of the mesh, or a part of its cells, as in "
                       "`at [0.5, 1] on upper`; `jump(u)` on a pair is the difference"));
}

} // namespace hvi::lang
