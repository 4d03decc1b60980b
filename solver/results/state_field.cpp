// See state_field.hpp. Used by frames of pictures and reports, and by the Reporter.
#include "solver/results/state_field.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/discrete/fields_read.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

bool StateField::is_one(const Problem& problem, const Contact& contact, const FieldSpec& field) {
  return lives_in_bodies(contact, field.components) &&
         !parts_of_states(problem, contact, field.components).empty();
}

StateField::StateField(const Problem& problem, const Discretisation& d, const Contact& contact,
                       const FieldSpec& field)
    : d_(d), contact_(contact), field_(field) {
  for (const int part : parts_of_states(problem, contact, field.components))
    on_parts_.emplace_back(problem, d, contact, field.components, field.origin, part);
  for (const Expr& component : field.components)
    elsewhere_.push_back(away_from_states(problem, component));
  if (std::ranges::any_of(elsewhere_, reads_multiplier)) elsewhere_.clear();
}

std::vector<double> StateField::of_cells(const Snapshot& snapshot) {
  const std::size_t n = field_.components.size(), cells = d_.mesh.cells.size();
  std::vector<double> out(n * cells, std::numeric_limits<double>::quiet_NaN());
  if (!elsewhere_.empty()) out = cell_values(d_.space, elsewhere_, snapshot.values());
  std::vector<double> sums(n * cells, 0.0), weights(cells, 0.0), values;
  for (LawSampler& sampler : on_parts_) {
    const PointBlock& points = sampler.points();
    values.resize(n * points.size());
    sampler.evaluate(contact_, snapshot, values);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const auto cell = static_cast<std::size_t>(points.cell[p]);
      weights[cell] += points.weight[p];
      for (std::size_t c = 0; c < n; ++c)
        sums[cell * n + c] += points.weight[p] * values[c * points.size() + p];
    }
  }
  for (std::size_t k = 0; k < out.size(); ++k)
    if (weights[k / n] > 0.0) out[k] = sums[k] / weights[k / n];
  return out;
}

std::vector<double> StateField::of_nodes(const Snapshot& snapshot) {
  const std::vector<double> cells = of_cells(snapshot);
  const std::size_t n = field_.components.size();
  std::vector<double> out(n * d_.space.nodes.size(), 0.0), weights(d_.space.nodes.size(), 0.0);
  for (int cell = 0; cell < static_cast<int>(d_.mesh.cells.size()); ++cell) {
    const double* const here = cells.data() + n * static_cast<std::size_t>(cell);
    if (std::any_of(here, here + n, [](double v) { return std::isnan(v); })) continue;
    const double measure = cell_measure(d_.mesh, cell);
    for (const std::int32_t node : d_.space.nodes_of_cell(cell)) {
      weights[static_cast<std::size_t>(node)] += measure;
      for (std::size_t c = 0; c < n; ++c)
        out[static_cast<std::size_t>(node) * n + c] += measure * here[c];
    }
  }
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] =
        weights[k / n] > 0.0 ? out[k] / weights[k / n] : std::numeric_limits<double>::quiet_NaN();
  return out;
}

} // namespace hvi::solver
