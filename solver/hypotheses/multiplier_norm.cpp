// See multiplier_norm.hpp.
#include "solver/hypotheses/multiplier_norm.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/time/operators.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// What the others see of a constant, beside the parts that cancel.
constexpr double cancels = 1e-10;

/// Of the dofs of one unknown: the number of their piece, those that share a cell in one; -1 of
/// others.
std::vector<int> pieces_of_dofs(const SparseMatrix& l2, const Space& space, int unknown) {
  std::vector<int> out(static_cast<std::size_t>(l2.rows()), -1);
  const auto is_new = [&](Eigen::Index i) {
    return out[static_cast<std::size_t>(i)] < 0 && l2.coeff(i, i) != 0.0 &&
           space.block_of(static_cast<int>(i) % space.components) == unknown;
  };
  int pieces = 0;
  for (Eigen::Index seed = 0; seed < l2.rows(); ++seed) {
    std::vector<Eigen::Index> open;
    const auto take = [&](Eigen::Index i) {
      if (!is_new(i)) return;
      out[static_cast<std::size_t>(i)] = pieces - 1;
      open.push_back(i);
    };
    if (is_new(seed)) ++pieces, take(seed);
    while (!open.empty()) {
      const Eigen::Index i = open.back();
      open.pop_back();
      for (SparseMatrix::InnerIterator it(l2, i); it; ++it) take(it.col());
    }
  }
  return out;
}

/// By piece: does a free unknown see a constant there?
std::vector<char> seen_constants(const SparseMatrix& couplings, const StateLayout& layout,
                                 const std::vector<int>& piece_of, int pieces) {
  std::vector<char> out;
  Vector seen(layout.n_unknowns), size(layout.n_unknowns);
  for (int piece = 0; piece < pieces; ++piece) {
    seen.setZero(), size.setZero();
    for (int i = 0; i < couplings.rows(); ++i)
      for (SparseMatrix::InnerIterator it(couplings, i); it && piece_of[i] == piece; ++it) {
        const auto entry = layout.entry_of[static_cast<std::size_t>(it.col())];
        if (entry < 0 || entry >= layout.n_unknowns) continue;
        seen[entry] += it.value(), size[entry] += std::abs(it.value());
      }
    out.push_back(seen.lpNorm<Eigen::Infinity>() > cancels * size.lpNorm<Eigen::Infinity>());
  }
  return out;
}

} // namespace

MultiplierNorm::MultiplierNorm(const Problem& problem, const Discretisation& discretisation,
                               const StateLayout& layout, int unknown) {
  const SparseMatrix l2 = mass(discretisation.space);
  l2_ = restrict_rows(l2, layout).leftCols(layout.n_unknowns);
  if (!layout.links.empty()) return;
  const auto piece_of = pieces_of_dofs(l2, discretisation.space, unknown);
  const int pieces = *std::ranges::max_element(piece_of) + 1;
  SparseMatrix couplings = matrix_of_field(problem, discretisation, field_of_u(0));
  couplings += matrix_of_field(problem, discretisation, field_of_u(1));
  const auto seen = seen_constants(couplings, layout, piece_of, pieces);
  for (int piece = 0; piece < pieces; ++piece) {
    if (seen[static_cast<std::size_t>(piece)] != 0) continue;
    Mean mean{Vector::Zero(layout.n_unknowns), 0.0};
    bool fixed = false;
    for (int i = 0; i < l2.rows(); ++i) {
      if (piece_of[static_cast<std::size_t>(i)] != piece) continue;
      const auto entry = layout.entry_of[static_cast<std::size_t>(i)];
      const bool free = entry >= 0 && entry < layout.n_unknowns;
      const double integral = l2.row(i).sum();
      mean.measure += integral;
      if (free) mean.integral[entry] = integral;
      fixed = fixed || !free;
    }
    if (fixed) means_.push_back(std::move(mean));
  }
}

Vector MultiplierNorm::times(const Vector& p) const {
  Vector out = l2_ * p;
  for (const Mean& mean : means_) out -= (mean.integral.dot(p) / mean.measure) * mean.integral;
  return out;
}

} // namespace hvi::solver
