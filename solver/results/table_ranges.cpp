// See table_ranges.hpp.
#include "solver/results/table_ranges.hpp"

#include "solver/kernel/algebra.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hvi::solver {

Expr is_outside(const Expr& reading) {
  const Expr& at = reading.args()[0];
  const Expr above = select(less(Expr(reading.table()->last()), at), 1.0, 0.0);
  return select(less(at, Expr(reading.table()->first())), 1.0, above);
}

void refuse_reading(Origin origin, const std::string& what, const Table& table, double t) {
  throw Failure(FailureKind::bad_value, origin,
                fmt::format("{} reads the table `{}` outside its range [{}, {}], at t = {:.6g}",
                            what, table.name(), table.first(), table.last(), t),
                "a table is not extrapolated: its file needs the range, or limit the argument, "
                "as in `min(t, 1)`");
}

std::vector<TableRanges::Reading> TableRanges::readings_in(std::span<const Probe> probes) {
  std::vector<Reading> out;
  for (std::size_t i = 0; i < probes.size(); ++i)
    for (const Expr& reading : table_readings(probes[i].expression)) {
      out.push_back({static_cast<int>(i), reading.table(), probes[i]});
      out.back().outside.expression = is_outside(reading);
    }
  return out;
}

std::vector<Probe> TableRanges::indicators(std::span<const Reading> readings) {
  std::vector<Probe> out;
  for (const Reading& reading : readings) out.push_back(reading.outside);
  return out;
}

TableRanges::TableRanges(const Problem& problem, std::span<const Probe> probes,
                         const Discretisation& discretisation, const RunState& run)
    : readings_(readings_in(probes)),
      outside_(problem, indicators(readings_), discretisation, run) {}

void TableRanges::refuse_outside(const Snapshot& snapshot, const Snapshot& before,
                                 std::span<const double> values) {
  for (const Reading& reading : readings_)
    if (!reading.outside.time) refuse_outside(reading.of, snapshot, before, values);
}

void TableRanges::refuse_outside(int i, const Snapshot& snapshot, const Snapshot& before,
                                 std::span<const double> values) {
  if (std::isfinite(values[static_cast<std::size_t>(i)])) return;
  for (std::size_t k = 0; k < readings_.size(); ++k) {
    if (readings_[k].of != i) continue;
    const Probe& probe = readings_[k].outside;
    const int at = static_cast<int>(k);
    const double outside = probe.kind == Probe::Kind::combination
                               ? outside_.combined(at, snapshot.t(), values)
                               : outside_.value(at, snapshot, before);
    if (!(outside > 0.0)) continue;
    refuse_reading(probe.origin,
                   probe.name.empty() ? "a column" : fmt::format("the column `{}`", probe.name),
                   *readings_[k].table, snapshot.t());
  }
}

} // namespace hvi::solver
