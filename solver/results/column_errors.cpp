// From errors of a state to those of the printed columns; see report.hpp. Called by run.cpp.
#include "solver/discrete/strain.hpp"
#include "solver/results/report.hpp"
#include "solver/results/run_result.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

/// Random samples now and then give one of the columns too small an error.
constexpr double safety = 3.0;
/// Steps of difference quotients, by the size of the state.
constexpr double small_step = 1e-5;

/// The largest |sym grad u| (scalar spaces: |grad u|) of the cells.
double largest_strain(const Space& space, const SpaceBlock& block, const Vector& u) {
  double out = 0.0;
  for (int cell = 0; cell < n_cells(space); ++cell)
    out = std::max(out, cell_strain(space, block, u, cell).cwiseAbs().maxCoeff());
  return out;
}

/// The largest distance between two nodes along an axis.
double body_size(const Space& space) {
  double out = 0.0;
  for (std::size_t j = 0; j < space.nodes.front().size(); ++j) {
    const auto [low, high] =
        std::minmax_element(space.nodes.begin(), space.nodes.end(),
                            [j](const Point& a, const Point& b) { return a[j] < b[j]; });
    out = std::max(out, (*high)[j] - (*low)[j]);
  }
  return out;
}

/// Of an unknown: with several of them each has its own size.
SolutionSize own_size(const Space& space, const SpaceBlock& block, const Vector& u,
                      SolutionSize all) {
  if (!space.is_product()) return all;
  double largest = 0.0;
  for (int node = 0; node < static_cast<int>(space.nodes.size()); ++node)
    for (int c = 0; c < block.components; ++c)
      largest = std::max(largest, std::abs(u[space.dof(node, block.first + c)]));
  const double nothing = all.nothing_of[static_cast<std::size_t>(space.block_of(block.first))];
  return {std::max(largest, nothing), nothing, {}, 0.0};
}

/// Of one unknown; see reference_motions.
void motions_of(const Space& space, const SpaceBlock& block, const ErrorSample& like,
                const Vector& u, SolutionSize scale, std::vector<ErrorSample>& out) {
  const int n = block.components, dim = space.mesh->dim;
  const auto add = [&](const auto& value) {
    ErrorSample motion = like;
    motion.u.setZero();
    for (int node = 0; node < static_cast<int>(space.nodes.size()); ++node)
      for (int c = 0; c < n; ++c)
        motion.u[space.dof(node, block.first + c)] =
            value(space.nodes[static_cast<std::size_t>(node)], c);
    motion.xi.setZero();
    out.push_back(std::move(motion));
  };
  for (int c = 0; c < n; ++c) add([&](const Point&, int of) { return of == c ? scale.size : 0.0; });
  const double strain = std::max(largest_strain(space, block, u), scale.nothing / body_size(space));
  for (int c = 0; c < n; ++c)
    for (int j = n == dim ? c : 0; j < dim; ++j)
      add([&](const Point& x, int of) {
        if (n != dim) return of == c ? strain * x[j] : 0.0;
        return 0.5 * strain * ((of == c ? x[j] : 0.0) + (of == j ? x[c] : 0.0));
      });
}

/// Translations by the size of u, and strains of the size of its own (at least those that move by
/// `nothing`): a column that is zero is judged by its change under these.
std::vector<ErrorSample> reference_motions(const Space& space, const ErrorSample& like,
                                           const Vector& u, SolutionSize scale, double xi) {
  std::vector<ErrorSample> out;
  for (const SpaceBlock& block : space.blocks)
    motions_of(space, block, like, u, own_size(space, block, u, scale), out);
  ErrorSample multipliers = like;
  multipliers.u.setZero();
  multipliers.xi.setConstant(xi);
  out.push_back(std::move(multipliers));
  return out;
}

} // namespace

/// d(column) / d(step) of all probes along the direction, by a difference quotient.
std::vector<double> Reporter::change_along(const ErrorSample& direction, double step) {
  std::vector<double> moved(values_.size()), here = values_;
  between_ = now_;
  if (probes_.any_timed()) probes_.evaluate_here(between_, before_, here);
  between_.move(direction, step);
  probes_.evaluate_here(between_, before_, moved);
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = (moved[i] - here[i]) / step;
  return moved;
}

std::vector<ColumnError> Reporter::errors(std::span<const ErrorSample> samples, const Vector& u,
                                          SolutionSize scale) {
  std::vector<ColumnError> out(values_.size());
  if (samples.empty() || values_.empty()) return {};
  std::vector<double> squares(values_.size(), 0.0), floors(values_.size(), 0.0);
  const auto step_of = [&](const ErrorSample& s) {
    const double size = s.u.lpNorm<Eigen::Infinity>();
    return size > 0.0 && scale.size > 0.0 ? small_step * scale.size / size : 1.0;
  };
  for (const auto& sample : samples) {
    const auto change = change_along(sample, step_of(sample));
    for (std::size_t i = 0; i < change.size(); ++i)
      squares[i] += sample.share * change[i] * change[i];
  }
  bool small = true;
  std::vector<double> largest(values_.size());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    out[i].name = plan_.report.probes[i].name;
    out[i].absolute = std::nan("");
    if (!std::isfinite(values_[i])) continue; // what is no number has no digits to lose
    largest[i] = std::abs(values_[i]);
    for (const double value : tables_.column(i))
      if (std::isfinite(value)) largest[i] = std::max(largest[i], std::abs(value));
    out[i].absolute =
        safety * std::sqrt(squares[i]) + std::numeric_limits<double>::epsilon() * largest[i];
    small = small && out[i].absolute <= ForwardError::small * largest[i];
  }
  if (!small) { // a column may be zero by symmetry
    const double xi = now_.xi().size() > 0 ? std::max(now_.xi().lpNorm<Eigen::Infinity>(),
                                                      scale.nothing_of_multipliers)
                                           : 0.0;
    for (const auto& motion :
         reference_motions(discretisation_.space, samples.front(), u, scale, xi)) {
      const auto change = change_along(motion, small_step);
      for (std::size_t i = 0; i < change.size(); ++i) floors[i] += std::abs(change[i]);
    }
    probes_.add_scales_of_reactions(now_, before_, values_, floors);
  }
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const double by = std::isfinite(values_[i]) ? std::max(largest[i], floors[i]) : 0.0;
    out[i].relative = by > 0.0 ? out[i].absolute / by : 0.0;
  }
  std::erase_if(out, [](const ColumnError& column) { return column.name.empty(); }); // parts
  return out;
}

double ForwardError::worst() const {
  double out = solution;
  for (const auto& column : columns)
    if (!(column.relative <= out)) out = column.relative;
  return std::isfinite(out) ? out : std::numeric_limits<double>::infinity();
}

} // namespace hvi::solver
