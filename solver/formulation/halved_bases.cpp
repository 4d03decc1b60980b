// See halved_bases.hpp.
#include "solver/formulation/halved_bases.hpp"

#include "solver/common/parallel.hpp"
#include "solver/discrete/dealt_matrices.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

std::vector<SymmetricBlocks> halved(const Operators& operators, int threads) {
  std::vector<SymmetricBlocks> out(operators.bases.size());
  for_each_piece(operators.n_bases(), threads,
                 [&](int b) { out[b] = SymmetricBlocks(operators.bases[b], operators.mirrored); });
  if (std::any_of(out.begin(), out.end(), [](const auto& half) { return half.empty(); }))
    out.clear();
  return out;
}

void keep_halves(Operators& operators, int threads) {
  const bool square = std::ranges::all_of(operators.bases, [&](const SparseMatrix& base) {
    return base.cols() == operators.n_unknowns;
  });
  if (!square || !operators.symmetric || !operators.changing.empty()) return;
  operators.halves = halved(operators, threads);
  if (operators.halves.empty()) return;
  for (SparseMatrix& base : operators.bases) SparseMatrix().swap(base);
}

const SparseMatrix& base_by_rows(const Operators& operators, int b, SparseMatrix& room) {
  const auto at = static_cast<std::size_t>(b);
  if (operators.halves.empty()) return operators.bases[at];
  SparseMatrix(operators.halves[at].by_rows()).swap(room);
  return room;
}

void add_magnitude_of_base(const Operators& operators, int b, double factor, const Vector& x,
                           Vector& y) {
  if (operators.dealt) {
    Vector of;
    operators.dealt->magnitude(b, x, of);
    y += factor * of;
    return;
  }
  SparseMatrix room;
  const SparseMatrix& base = base_by_rows(operators, b, room);
  for (int i = 0; i < base.rows(); ++i)
    for (SparseMatrix::InnerIterator it(base, i); it; ++it)
      y[i] += factor * std::abs(it.value() * x[it.col()]);
}

void product_of_base(const Operators& operators, int b, const Vector& x, Vector& y) {
  const auto at = static_cast<std::size_t>(b);
  if (operators.dealt) {
    Vector whole;
    operators.dealt->product(b, x, y, whole);
    return;
  }
  if (operators.halves.empty()) {
    y.noalias() = operators.bases[at] * x;
    return;
  }
  y.setZero(x.size());
  operators.halves[at].add_product(x, y);
}

void add_product_of_base(const Operators& operators, int b, double factor, const Vector& x,
                         Vector& y) {
  const auto at = static_cast<std::size_t>(b);
  if (operators.dealt) {
    Vector of;
    product_of_base(operators, b, x, of);
    y += factor * of;
    return;
  }
  if (operators.halves.empty())
    y.noalias() += factor * (operators.bases[at] * x);
  else
    operators.halves[at].add_product(factor * x, y);
}

} // namespace hvi::solver
