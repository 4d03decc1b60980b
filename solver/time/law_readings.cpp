// See law_readings.hpp. Held by Contact.
#include "solver/time/law_readings.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {
namespace {

bool is_of_field(Slot s) { return s >= slot::first_field; }
using slot::field_of;
int component_read(Slot s) { return LawPoints::traced(slot::derivative_of(s)); }

} // namespace

std::vector<int> fields_read(const LawSpec& law) {
  std::vector<int> out;
  for (const Expr& reading : law.readings)
    for (const Slot s : reading.slots())
      if (is_of_field(s) && std::ranges::find(out, field_of(s)) == out.end())
        out.push_back(field_of(s));
  return out;
}

LawReadings::LawReadings(const LawSpec& law, LawPoints& points, const StateLayout& layout)
    : points_(points.x.size()), fields_(fields_read(law)),
      trace_(restrict_columns(std::exchange(points.trace, {}), layout)),
      tape_(compile(law.readings)) {
  components_ = points_ > 0 ? static_cast<int>(trace_.rows()) / static_cast<int>(points_) : 0;
  values.assign(points_ * law.readings.size(), 0.0);
  std::vector<char> is_read(static_cast<std::size_t>(components_), 0);
  for (const Slot s : tape_.inputs) {
    if (is_of_field(s)) is_read[static_cast<std::size_t>(component_read(s))] = 1;
    auto& input = inputs_.emplace_back(points_, 0.0);
    for (std::size_t p = 0; p < points_; ++p)
      if (s <= slot::x(2))
        input[p] = points.x[p][static_cast<std::size_t>(s)];
      else if (s >= slot::normal(0) && s <= slot::normal(2))
        input[p] = points.normal[p][static_cast<std::size_t>(s - slot::normal(0))];
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

void LawReadings::read(double t, const LawFields& fields) {
  std::vector<const double*> pointers;
  int traced = -1;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const Slot s = tape_.inputs[i];
    pointers.push_back(inputs_[i].data());
    if (s == slot::t) std::ranges::fill(inputs_[i], t);
    if (!is_of_field(s)) continue;
    if (const int field = field_of(s); std::exchange(traced, field) != field)
      of_field_.noalias() = trace_ * fields[field];
    for (std::size_t p = 0; p < points_; ++p)
      inputs_[i][p] = of_field_[static_cast<Eigen::Index>(p) * components_ + component_read(s)];
  }
  thread_local TapeWorkspace workspace;
  evaluate(tape_, pointers, points_, values, workspace);
}

Readings LawReadings::at(int point) const {
  Readings out{};
  for (std::size_t i = 0; i * points_ < values.size(); ++i)
    out[i] = values[i * points_ + static_cast<std::size_t>(point)];
  return out;
}

} // namespace hvi::solver
