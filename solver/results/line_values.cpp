// See line_values.hpp. Used by the Reporter.
#include "solver/results/line_values.hpp"

#include "solver/discrete/domains.hpp"
#include "solver/discrete/fields_read.hpp"
#include "solver/kernel/algebra.hpp"
#include "solver/results/table_ranges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::solver {
namespace {

std::vector<Point> places_of(const LineSpec& line) {
  std::vector<Point> out;
  for (int k = 0; k < line.points; ++k) {
    const double share = k / static_cast<double>(line.points - 1);
    Point& at = out.emplace_back();
    for (std::size_t i = 0; i < at.size(); ++i)
      at[i] = (1.0 - share) * line.from[i] + share * line.to[i];
  }
  return out;
}

double distance_between(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

} // namespace

std::vector<std::string> columns_of(const FieldSpec& field) {
  const std::size_t n = field.components.size();
  if (n == 1) return {field.name};
  std::vector<std::string> out;
  const bool vector = n <= 3;
  const std::size_t d = n == 9 ? 3 : 2;
  for (std::size_t i = 0; i < n; ++i)
    out.push_back(vector ? fmt::format("{}.{}", field.name, "xyz"[i])
                         : fmt::format("{}.{}{}", field.name, "xyz"[i / d], "xyz"[i % d]));
  return out;
}

LineValues::LineValues(const LineSpec& spec, const Problem& problem, const Discretisation& d,
                       const Contact& contact, const CellLocator& locator)
    : spec_(&spec), dim_(d.mesh.dim), places_(places_of(spec)) {
  for (const auto& field : spec.fields)
    for (auto& name : columns_of(field)) names_.push_back(std::move(name));
  const auto value_at = [&](const Expr& component, const Point& at, int cell,
                            std::array<double, 4> in) -> Value {
    Expr expression = component;
    if (reads_multiplier(component)) {
      try {
        auto found = LawSampler::at(problem, d, contact, component, spec.origin, at);
        if (found) return std::move(*found);
      } catch (const Failure&) { // a state that does not live there
        return std::monostate();
      }
      expression = away_from_states(problem, component);
    }
    const int its = cell_that_reads(d, expression, at, cell, in);
    if (its < 0) return std::monostate();
    return PointValue(d.space, expression, its, in);
  };
  std::array<double, 4> barycentric{};
  for (const Point& at : places_) {
    auto& here = values_.emplace_back();
    readings_.emplace_back();
    const int cell = locator.find(at, barycentric);
    if (cell < 0) continue;
    for (const auto& field : spec.fields)
      for (const Expr& component : field.components) {
        here.push_back(value_at(component, at, cell, barycentric));
        if (std::holds_alternative<PointValue>(here.back()))
          read_tables(d, here.size() - 1, component, cell, barycentric);
      }
  }
  refuse_elsewhere();
}

void LineValues::read_tables(const Discretisation& d, std::size_t column, const Expr& component,
                             int cell, const std::array<double, 4>& in) {
  for (const Expr& reading : table_readings(component))
    readings_.back().push_back(
        {column, reading.table(), PointValue(d.space, is_outside(reading), cell, in)});
}

void LineValues::refuse_outside_tables(std::size_t place, std::size_t column,
                                       const Snapshot& snapshot) {
  for (Reading& reading : readings_[place])
    if (reading.column == column && reading.outside(snapshot.values()) > 0.0)
      refuse_reading(spec_->origin, fmt::format("the line of `{}`", names_[column]), *reading.table,
                     snapshot.t());
}

void LineValues::refuse_elsewhere() const {
  for (std::size_t c = 0; c < names_.size(); ++c)
    if (std::ranges::all_of(values_, [&](const auto& here) {
          return here.empty() || std::holds_alternative<std::monostate>(here[c]);
        }))
      throw Failure(FailureKind::bad_value, spec_->origin,
                    fmt::format("no point of the line lies where `{}` lives", names_[c]));
}

void LineValues::name_columns() {
  table_ = ReportTable{{"distance"}, {{}}};
  for (int i = 0; i < dim_; ++i) table_.names.emplace_back(1, "xyz"[i]);
  table_.names.insert(table_.names.end(), names_.begin(), names_.end());
  table_.columns.resize(table_.names.size());
}

void LineValues::save(StateWriter& w) const {
  w.put(static_cast<std::uint8_t>(taken()));
  for (const auto& column : table_.columns) w.put(column);
}

void LineValues::restore(StateReader& r) {
  if (r.get<std::uint8_t>() == 0) return;
  name_columns();
  for (auto& column : table_.columns) column = r.get_vector<double>(places_.size());
}

void LineValues::take(const Contact& contact, const Snapshot& snapshot) {
  name_columns();
  const auto number = [&](Value& value) {
    if (auto* inside = std::get_if<PointValue>(&value)) return (*inside)(snapshot.values());
    if (auto* sampler = std::get_if<LawSampler>(&value))
      return sampler->integral(contact, snapshot);
    return std::nan("");
  };
  for (std::size_t k = 0; k < places_.size(); ++k) {
    auto column = table_.columns.begin();
    (column++)->push_back(distance_between(places_[k], places_[0]));
    for (int i = 0; i < dim_; ++i) (column++)->push_back(places_[k][static_cast<std::size_t>(i)]);
    for (std::size_t c = 0; c < names_.size(); ++c) {
      const double found = values_[k].empty() ? std::nan("") : number(values_[k][c]);
      if (!std::isfinite(found)) refuse_outside_tables(k, c, snapshot);
      (column++)->push_back(found);
    }
  }
}

std::vector<Failure> lines_outside(const ReportSpec& report, const Mesh& mesh) {
  std::vector<Failure> out;
  const CellLocator locator(mesh, report.lines.size());
  std::array<double, 4> barycentric{};
  for (const LineSpec& line : report.lines) {
    const auto places = places_of(line);
    if (std::ranges::any_of(places,
                            [&](const Point& at) { return locator.find(at, barycentric) >= 0; }))
      continue;
    out.emplace_back(FailureKind::bad_value, line.origin,
                     fmt::format("no point of the line from {} to {} is in the mesh",
                                 describe_point(line.from, mesh.dim),
                                 describe_point(line.to, mesh.dim)));
  }
  return out;
}

std::vector<std::string> line_units(const ReportSpec& report, std::size_t i, int dim) {
  std::vector<std::string> out(static_cast<std::size_t>(1 + dim), report.unit_of_length);
  for (const FieldSpec& field : report.lines[i].fields)
    out.insert(out.end(), field.components.size(), field.unit);
  return out;
}

} // namespace hvi::solver
