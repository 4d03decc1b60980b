// Values along a line of a report, and its file.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/kernel/table.hpp"
#include "solver/mesh/mesh.hpp"
#include "solver/output/table.hpp"
#include "solver/results/law_sampler.hpp"

#include <array>
#include <memory>
#include <variant>
#include <vector>

namespace hvi::solver {

/// The fields of one `line` item at its places, as probes have them there. Where the mesh has no
/// such place the values are NaN.
class LineValues {
public:
  LineValues(const LineSpec& spec, const Problem& problem, const Discretisation& d,
             const Contact& contact, const CellLocator& locator);

  const LineSpec& spec() const { return *spec_; }
  /// Columns: the distance from the first place, the coordinates, the fields.
  void take(const Contact& contact, const Snapshot& snapshot);
  bool taken() const { return !table_.columns.empty(); }
  const ReportTable& table() const { return table_; }
  void save(StateWriter& w) const;
  void restore(StateReader& r);

private:
  /// Of an expression at a place; of one that reads states, at the points where they live. The
  /// first: what it reads does not live there.
  using Value = std::variant<std::monostate, PointValue, LawSampler>;

  /// A table that a column reads at a place: positive where its argument is outside its range.
  struct Reading {
    std::size_t column;
    std::shared_ptr<const Table> table;
    PointValue outside;
  };

  void read_tables(const Discretisation& d, std::size_t column, const Expr& component, int cell,
                   const std::array<double, 4>& in);
  void refuse_outside_tables(std::size_t place, std::size_t column, const Snapshot& snapshot);
  /// Throws Failure(bad_value) for a column without values.
  void refuse_elsewhere() const;
  void name_columns();

  const LineSpec* spec_;
  int dim_;
  std::vector<std::string> names_;
  std::vector<Point> places_;
  /// By place, then component; none where the mesh has no such place.
  std::vector<std::vector<Value>> values_;
  std::vector<std::vector<Reading>> readings_; ///< by place
  ReportTable table_;
};

/// Lines that meet the mesh nowhere.
std::vector<Failure> lines_outside(const ReportSpec& report, const Mesh& mesh);
/// Of its columns.
std::vector<std::string> line_units(const ReportSpec& report, std::size_t i, int dim);
/// "sigma.xx" and the like: the fields of a line as columns.
std::vector<std::string> columns_of(const FieldSpec& field);

} // namespace hvi::solver
