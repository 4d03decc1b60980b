// Tables that columns, fields and lines of a report read: they are not extrapolated.
#pragma once

#include "solver/kernel/table.hpp"
#include "solver/results/probes.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// 1 where the argument of a reading (table_readings) is outside the range of its table, else 0.
Expr is_outside(const Expr& reading);
/// Throws Failure(bad_value): `what` reads it there.
[[noreturn]] void refuse_reading(Origin origin, const std::string& what, const Table& table,
                                 double t);

/// For each table that a probe reads a probe of the same kind, which is positive where the table's
/// argument is outside its range: asked only where the probe itself has no value.
class TableRanges {
public:
  TableRanges(const Problem& problem, std::span<const Probe> probes,
              const Discretisation& discretisation, const RunState& run);

  /// Throws Failure(bad_value) where one of these values of the probes is none, for that reason.
  /// Those with a time of their own are left out.
  void refuse_outside(const Snapshot& snapshot, const Snapshot& before,
                      std::span<const double> values);
  /// The same of probe i, whatever its time.
  void refuse_outside(int i, const Snapshot& snapshot, const Snapshot& before,
                      std::span<const double> values);

private:
  struct Reading {
    int of; ///< a probe of the report
    std::shared_ptr<const Table> table;
    Probe outside;
  };
  static std::vector<Reading> readings_in(std::span<const Probe> probes);
  static std::vector<Probe> indicators(std::span<const Reading> readings);

  std::vector<Reading> readings_;
  ProbeSet outside_; ///< by reading
};

} // namespace hvi::solver
