// See multiplier_norm.hpp.
#include "solver/formulation/multiplier_norm.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/discrete/operators.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

using Piece = std::vector<int>; ///< its dofs

/// What the others see of a constant, beside the parts that cancel.
constexpr double cancels = 1e-10;

/// L2's matrix, and an entry for each two dofs that are one.
SparseMatrix neighbours(const SparseMatrix& l2, std::span<const DofLink> links) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const DofLink& link : links)
    entries.emplace_back(link.dof, link.to, 1.0), entries.emplace_back(link.to, link.dof, 1.0);
  SparseMatrix out(l2.rows(), l2.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out + l2;
}

/// The dofs of one unknown, by the pieces of its domain: those that share a cell, or a value by
/// periodicity.
std::vector<Piece> pieces_of(const SparseMatrix& l2, const Space& space,
                             std::span<const DofLink> links, int unknown) {
  const SparseMatrix graph = neighbours(l2, links);
  std::vector<char> taken(static_cast<std::size_t>(l2.rows()), 0);
  std::vector<Piece> out;
  const auto is_new = [&](int i) {
    return taken[static_cast<std::size_t>(i)] == 0 && l2.coeff(i, i) != 0.0 &&
           space.block_of(i % space.components) == unknown;
  };
  for (int seed = 0; seed < l2.rows(); ++seed) {
    if (!is_new(seed)) continue;
    Piece& piece = out.emplace_back();
    const auto take = [&](int i) {
      if (is_new(i)) taken[static_cast<std::size_t>(i)] = 1, piece.push_back(i);
    };
    take(seed);
    for (std::size_t k = 0; k < piece.size(); ++k)
      for (SparseMatrix::InnerIterator it(graph, piece[k]); it; ++it)
        take(static_cast<int>(it.col()));
  }
  return out;
}

/// Does a free unknown see a constant there?
bool is_seen(const Piece& piece, const SparseMatrix& couplings, const StateLayout& layout) {
  Vector seen = Vector::Zero(layout.n_state), size = seen;
  for (const int i : piece)
    for (SparseMatrix::InnerIterator it(couplings, i); it; ++it) {
      const auto entry = layout.entry_of[static_cast<std::size_t>(it.col())];
      if (entry >= 0) seen[entry] += it.value(), size[entry] += std::abs(it.value());
    }
  const auto largest = [&](const Vector& v) {
    return v.head(layout.n_unknowns).cwiseAbs().maxCoeff();
  };
  return largest(seen) > cancels * largest(size);
}

} // namespace

MultiplierNorm::MultiplierNorm(const Problem& problem, const Discretisation& discretisation,
                               const StateLayout& layout, int unknown) {
  const SparseMatrix l2 = mass(discretisation.space);
  l2_ = restrict_rows(l2, layout).leftCols(layout.n_unknowns);
  SparseMatrix couplings = matrix_of_field(problem, discretisation, field_of_u(0));
  couplings += matrix_of_field(problem, discretisation, field_of_u(1));
  for (const Piece& piece : pieces_of(l2, discretisation.space, layout.links, unknown)) {
    if (is_seen(piece, couplings, layout)) continue;
    Mean mean{Vector::Zero(layout.n_unknowns), 0.0};
    bool fixed = false;
    for (const int i : piece) {
      const auto entry = layout.entry_of[static_cast<std::size_t>(i)];
      const double integral = l2.row(i).sum();
      mean.measure += integral;
      if (entry >= 0 && entry < layout.n_unknowns)
        mean.integral[entry] += integral;
      else
        fixed = true;
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
