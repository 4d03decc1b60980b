// See mesh_tables.hpp.
#include "lang/mesh_tables.hpp"

#include "solver/kernel/algebra.hpp"
#include "solver/kernel/slot.hpp"
#include "solver/kernel/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace hvi::lang {

namespace {

using solver::Group;
namespace slot = solver::slot;

/// Of the largest value of a table: differences that are told.
constexpr double told = 0.01;
/// So many cells of a part are looked at, spread over it.
constexpr std::size_t most_looked_at = 5000;

/// What a table has in the interval of its argument over one cell or side.
struct Within {
  std::size_t points = 0;
  double difference = 0.0; ///< of the mean from that of a rule of three points
};

Within look_within(const solver::Table& table, double low, double high) {
  Within out;
  low = std::max(low, table.first()), high = std::min(high, table.last());
  const auto& all = table.abscissae();
  const auto begin = std::upper_bound(all.begin(), all.end(), low);
  const auto end = std::lower_bound(begin, all.end(), high);
  out.points = static_cast<std::size_t>(end - begin);
  if (out.points < 2) return out; // one kink is what any mesh has beside its nodes
  double sum = 0.0, left = low;
  const auto add = [&](double right) { // by Simpson's rule, which is exact between two points
    sum += (right - left) / 6.0 *
           (table.value(left) + 4.0 * table.value(0.5 * (left + right)) + table.value(right));
    left = right;
  };
  std::for_each(begin, end, add);
  add(high);
  constexpr std::array gauss{std::pair{-0.774596669241483, 5.0 / 18.0}, std::pair{0.0, 8.0 / 18.0},
                             std::pair{0.774596669241483, 5.0 / 18.0}};
  double seen = 0.0;
  for (const auto& [at, weight] : gauss)
    seen += weight * table.value(0.5 * (low + high) + 0.5 * (high - low) * at);
  out.difference = std::abs(sum / (high - low) - seen);
  return out;
}

/// Least and largest value of an expression of the place at the corners of a cell or side.
std::pair<double, double> range_over(const solver::Mesh& mesh, const solver::Region& region,
                                     std::int32_t entity, const solver::Expr& argument) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const bool facet = region.kind == Group::Kind::facets;
  for (int k = 0; k < mesh.dim + (facet ? 0 : 1); ++k) {
    const auto node = facet ? mesh.facets[static_cast<std::size_t>(entity)].nodes[k]
                            : mesh.cells[static_cast<std::size_t>(entity)][k];
    const solver::Point& x = mesh.nodes[static_cast<std::size_t>(node)];
    const double value = solver::evaluate(
        argument, [&](solver::Slot s) { return x[static_cast<std::size_t>(s - slot::x(0))]; });
    low = std::min(low, value), high = std::max(high, value);
  }
  return {low, high};
}

bool is_of_place(const solver::Expr& argument) {
  const auto slots = solver::slots_of(argument);
  return !slots.empty() && std::ranges::all_of(slots, [](solver::Slot s) {
    return s >= slot::x(0) && s <= slot::x(2);
  });
}

class FineTables {
public:
  FineTables(Script& script, const solver::Discretisation& d) : script_(script), d_(d) {}

  void read(const solver::Expr& e, int part, solver::Origin origin) {
    if (part < 0 || d_.parts[static_cast<std::size_t>(part)].kind == Group::Kind::points) return;
    for (const solver::Expr& reading : solver::table_readings(e))
      if (is_of_place(reading.args()[0]) && told_.insert({reading.table()->name(), part}).second)
        look(reading, part, origin);
  }

private:
  void look(const solver::Expr& reading, int part, solver::Origin origin) {
    const solver::Region& region = d_.parts[static_cast<std::size_t>(part)];
    const solver::Table& table = *reading.table();
    Within worst;
    const std::size_t step = region.entities.size() / most_looked_at + 1;
    for (std::size_t i = 0; i < region.entities.size(); i += step) {
      const auto [low, high] = range_over(d_.mesh, region, region.entities[i], reading.args()[0]);
      if (!(low < high)) continue;
      const Within here = look_within(table, low, high);
      worst.points = std::max(worst.points, here.points);
      worst.difference = std::max(worst.difference, here.difference);
    }
    double largest = 0.0;
    for (const double y : table.ordinates()) largest = std::max(largest, std::abs(y));
    if (worst.difference > told * largest) tell(table, region, worst, largest, origin);
  }

  void tell(const solver::Table& table, const solver::Region& region, const Within& worst,
            double largest, solver::Origin origin) {
    const char* const entity = region.kind == Group::Kind::facets ? "side" : "cell";
    script_.diagnostics.add(
        diagnose("W0612", span_of(script_, origin),
                 fmt::format("the table `{}` has up to {} points within one {}, and the mean over "
                             "one differs by up to {:.2g} % of its largest value from what the "
                             "points of a rule see",
                             table.name(), worst.points, entity,
                             100.0 * worst.difference / largest))
            .with_help(fmt::format("make the {}s as small as the distances of its points, or give "
                                   "means over them in the file",
                                   entity)));
  }

  Script& script_;
  const solver::Discretisation& d_;
  std::set<std::pair<std::string, int>> told_; ///< or looked at
};

} // namespace

void report_fine_tables(Script& script, const solver::Discretisation& d) {
  const solver::Plan& plan = *script.plan;
  FineTables tables(script, d);
  for (const auto* loads : {&plan.problem.loads, &plan.problem.state_loads})
    for (const auto& load : *loads)
      for (const auto& e : load.entries) tables.read(e.value, load.part, load.origin);
  for (const auto& form : plan.problem.forms) {
    for (const auto& e : form.entries) tables.read(e.coefficient, form.part, form.origin);
  }
  for (const auto& probe : plan.report.probes)
    if (probe.kind == solver::Probe::Kind::integral)
      tables.read(probe.expression, probe.part, probe.origin);
}

} // namespace hvi::lang
