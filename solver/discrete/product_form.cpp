// See product_form.hpp. Used by uniqueness.cpp and the hypotheses.
#include "solver/discrete/product_form.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// Sums over the entries of K with row in a and column in b.
struct BlockSums {
  using Table = std::array<ByUnknown, slot::most_unknowns>;
  Table squares{}, mirrored{}; ///< K_ij^2; K_ij K_ji of two unknowns
  ByUnknown diagonal{};
};

BlockSums sums_of(const SparseMatrix& k, std::span<const std::uint8_t> of_unknown) {
  BlockSums out;
  for (int i = 0; i < k.rows(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
      const std::size_t a = of_unknown[i], b = of_unknown[it.col()];
      out.squares[a][b] += it.value() * it.value();
      if (a != b) out.mirrored[a][b] += it.value() * k.coeff(it.col(), i);
    }
  for (int i = 0; i < k.rows(); ++i) out.diagonal[of_unknown[i]] += k.coeff(i, i);
  return out;
}

/// Which unknowns read which, directly or through others; each itself.
Couplings through_others(Couplings reads) {
  for (std::size_t a = 0; a < reads.size(); ++a) reads[a][a] = true;
  for (std::size_t by = 0; by < reads.size(); ++by)
    for (std::size_t a = 0; a < reads.size(); ++a)
      for (std::size_t b = 0; b < reads.size(); ++b)
        reads[a][b] = reads[a][b] || (reads[a][by] && reads[by][b]);
  return reads;
}

} // namespace

ProductForm::ProductForm(const SparseMatrix& k, std::span<const std::uint8_t> of_unknown,
                         std::span<const char> with_laws, const Couplings& couplings)
    : of_unknown_(of_unknown) {
  weights_.fill(1.0);
  const Couplings reads = through_others(couplings);
  for (std::size_t a = 0; a < most; ++a)
    for (std::size_t b = 0; b < most; ++b) both_ways_[a][b] = reads[a][b] && reads[b][a];
  const BlockSums sums = sums_of(k, of_unknown);
  for (std::size_t b = 0; b < with_laws.size(); ++b) {
    multiplier_[b] = sums.squares[b][b] == 0.0 && with_laws[b] == 0;
    if (b == 0) continue;
    double above = 0.0, below = 0.0; // of the least squares
    for (std::size_t a = 0; a < b; ++a) {
      if (!both_ways_[a][b]) continue;
      above -= weights_[a] * sums.mirrored[a][b];
      below += sums.squares[b][a];
    }
    double weight = below > 0.0 ? above / below : 0.0;
    if (weight == 0.0) weight = 1.0;
    const double own = with_laws[b] != 0 ? 1.0 : sums.diagonal[b];
    weights_[b] = own != 0.0 ? std::copysign(weight, own) : weight;
  }
  for (int i = 0; i < k.rows(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
      const std::size_t a = of_unknown[i];
      double& size = sizes_[a][of_unknown[it.col()]];
      size = std::max(size, std::abs(weights_[a] * it.value()));
    }
}

SparseMatrix ProductForm::weighted(const SparseMatrix& form) const {
  SparseMatrix out = form;
  for (int i = 0; i < out.rows(); ++i)
    for (SparseMatrix::InnerIterator it(out, i); it; ++it)
      it.valueRef() *= weight(of_unknown_[i], of_unknown_[it.col()]);
  return 0.5 * (out + SparseMatrix(out.transpose()));
}

SparseMatrix ProductForm::symmetric_part(const SparseMatrix& form) const {
  constexpr double rounding = 1e-13;
  SparseMatrix out = weighted(form), diagonal(form.rows(), form.cols());
  std::array<bool, most> seen{};
  double own = 0.0; // of the forms that unknowns have themselves
  for (std::size_t b = 0; b < most; ++b) own = std::max(own, sizes_[b][b]);
  for (int i = 0; i < out.rows(); ++i)
    for (SparseMatrix::InnerIterator it(out, i); it; ++it) {
      const std::size_t a = of_unknown_[i], b = of_unknown_[it.col()];
      if (!multiplier_[a] && !multiplier_[b]) continue;
      if (std::abs(it.value()) <= rounding * std::max(sizes_[a][b], sizes_[b][a]))
        it.valueRef() = 0.0;
      else
        seen[a] = seen[b] = true;
    }
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < out.rows(); ++i)
    if (const std::size_t a = of_unknown_[i]; multiplier_[a])
      entries.emplace_back(i, i, seen[a] ? 0.0 : own);
  diagonal.setFromTriplets(entries.begin(), entries.end());
  return entries.empty() ? out : SparseMatrix(out + diagonal);
}

} // namespace hvi::solver
