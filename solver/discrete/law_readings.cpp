// See law_readings.hpp. Held by Contact.
#include "solver/discrete/law_readings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace hvi::solver {
namespace {

using slot::field_of;
int component_read(Slot s) { return LawPoints::traced(slot::derivative_of(s)); }

/// number(s) of every slot that the law reads and for which `wanted`, each once.
template <class Wanted, class Number>
std::vector<int> numbers_read(const LawSpec& law, Wanted wanted, Number number) {
  std::vector<int> out;
  for (const Expr& reading : law.readings)
    for (const Slot s : reading.slots())
      if (wanted(s) && std::ranges::find(out, number(s)) == out.end()) out.push_back(number(s));
  return out;
}

/// The slope of a law that is a sum of constants times what it reads, as a function of the
/// solution; nothing for other laws.
std::optional<Expr> slope_of_source(const LawSpec& law) {
  if (law.radial || law.by_slope || !law.coupled.empty()) return std::nullopt;
  const Expr slope = derivative(law.expression, slot::argument(0));
  Expr out = 0.0;
  for (std::size_t i = 0; i < law.readings.size(); ++i) {
    const Expr by = derivative(slope, slot::reading(static_cast<int>(i)));
    if (!by.is_constant()) return std::nullopt;
    out = out + by * law.readings[i];
  }
  return out;
}

} // namespace

std::vector<int> fields_read(const LawSpec& law) {
  return numbers_read(law, slot::is_field, field_of);
}

std::vector<int> terms_read(const LawSpec& law) {
  return numbers_read(law, slot::is_multiplier, slot::term_of);
}

LawReadings::LawReadings(const LawSpec& law, int index, LawPoints& points,
                         const StateLayout& layout)
    : law_(index), points_(points.x.size()), fields_(fields_read(law)),
      trace_(restrict_columns(std::exchange(points.trace, {}), layout)),
      tape_(compile(law.readings)) {
  components_ = points_ > 0 ? static_cast<int>(trace_.rows()) / static_cast<int>(points_) : 0;
  values.assign(points_ * law.readings.size(), 0.0);
  std::vector<char> is_read(static_cast<std::size_t>(components_), 0);
  for (const Slot s : tape_.inputs) {
    if (slot::is_field(s)) is_read[static_cast<std::size_t>(component_read(s))] = 1;
    auto& input = inputs_.emplace_back(points_, 0.0);
    for (std::size_t p = 0; p < points_; ++p)
      if (s <= slot::x(2))
        input[p] = points.x[p][static_cast<std::size_t>(s)];
      else if (s >= slot::normal(0) && s <= slot::normal(2))
        input[p] = points.normal[p][static_cast<std::size_t>(s - slot::normal(0))];
  }
  if (const auto slope = slope_of_source(law))
    for (const Slot s : tape_.inputs) {
      const std::vector<Expr> by{derivative(*slope, s)};
      slope_by_input_.push_back(compile(by));
    }
  trace_.prune([&](Eigen::Index row, Eigen::Index, double) {
    return is_read[static_cast<std::size_t>(row % components_)] != 0;
  });
}

void LawReadings::restrict_to(const std::vector<int>& unknowns, int size) {
  std::vector<int> position(static_cast<std::size_t>(trace_.cols()), -1);
  for (std::size_t c = 0; c < unknowns.size(); ++c)
    position[static_cast<std::size_t>(unknowns[c])] = static_cast<int>(c);
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < trace_.rows(); ++row)
    for (SparseMatrix::InnerIterator it(trace_, row); it; ++it)
      entries.emplace_back(row, position[static_cast<std::size_t>(it.col())], it.value());
  SparseMatrix out(trace_.rows(), size);
  out.setFromTriplets(entries.begin(), entries.end());
  trace_ = std::move(out);
}

void LawReadings::read(double t, const LawFields& fields, const MultiplierAt& multiplier) {
  std::vector<const double*> pointers;
  int traced = -1;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const Slot s = tape_.inputs[i];
    pointers.push_back(inputs_[i].data());
    if (s == slot::t) std::ranges::fill(inputs_[i], t);
    if (slot::is_multiplier(s))
      for (std::size_t p = 0; p < points_; ++p)
        inputs_[i][p] = multiplier(slot::term_of(s), slot::row_of(s), static_cast<int>(p));
    if (!slot::is_field(s)) continue;
    if (const int field = field_of(s); std::exchange(traced, field) != field)
      of_field_.noalias() = trace_ * fields[field];
    for (std::size_t p = 0; p < points_; ++p)
      inputs_[i][p] = of_field_[static_cast<Eigen::Index>(p) * components_ + component_read(s)];
  }
  thread_local TapeWorkspace workspace;
  evaluate(tape_, pointers, points_, values, workspace);
}

/// Of one input of the tape, by point.
std::vector<double> LawReadings::sizes_of(Slot input, const LawFields& fields, const Vector& reach,
                                          const MultiplierSize& multiplier) const {
  std::vector<double> out(points_, 0.0);
  if (slot::is_multiplier(input)) {
    out.assign(points_, multiplier(slot::term_of(input)));
  } else if (slot::is_field(input)) {
    const Vector& field = fields[field_of(input)];
    const double factor = reach.size() == field.size() ? fields.factor(field_of(input)) : 0.0;
    for (std::size_t p = 0; p < points_; ++p)
      for (SparseMatrix::InnerIterator it(trace_, static_cast<Eigen::Index>(p) * components_ +
                                                      component_read(input));
           it; ++it)
        out[p] += std::abs(it.value()) *
                  (std::abs(field[it.col()]) + (factor > 0.0 ? factor * reach[it.col()] : 0.0));
  }
  return out;
}

double LawReadings::slope_scale(const LawFields& fields, const Vector& reach,
                                const MultiplierSize& multiplier) const {
  std::vector<double> sums(points_, 0.0), by(points_);
  TapeWorkspace workspace;
  for (std::size_t i = 0; i < slope_by_input_.size(); ++i) {
    const auto sizes = sizes_of(tape_.inputs[i], fields, reach, multiplier);
    std::vector<const double*> pointers;
    for (const Slot s : slope_by_input_[i].inputs) {
      const auto at = std::ranges::find(tape_.inputs, s) - tape_.inputs.begin();
      pointers.push_back(inputs_[static_cast<std::size_t>(at)].data());
    }
    evaluate(slope_by_input_[i], pointers, points_, by, workspace);
    for (std::size_t p = 0; p < points_; ++p) sums[p] += std::abs(by[p]) * sizes[p];
  }
  return points_ > 0 ? *std::ranges::max_element(sums) : 0.0;
}

Readings LawReadings::at(int point) const {
  Readings out{};
  for (std::size_t i = 0; i * points_ < values.size(); ++i)
    out[i] = values[i * points_ + static_cast<std::size_t>(point)];
  return out;
}

} // namespace hvi::solver
