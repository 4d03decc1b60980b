// See pieces.hpp.
#include "solver/linear/pieces.hpp"

#include <numeric>

namespace hvi::solver {
namespace {

/// The end of the chain that begins at i, which becomes half as long (R. E. Tarjan, J. van Leeuwen,
/// Worst-case analysis of set union algorithms, J. ACM 31 (1984) 245-281).
int root(std::vector<int>& next, int i) {
  while (next[i] != i) i = next[i] = next[next[i]];
  return i;
}

std::vector<int> each_alone(int n) {
  std::vector<int> next(n);
  std::iota(next.begin(), next.end(), 0);
  return next;
}

} // namespace

Pieces::Pieces(const SparseMatrix& k) : piece_(each_alone(static_cast<int>(k.rows()))) {
  for (int i = 0; i < k.outerSize(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it)
      piece_[root(piece_, static_cast<int>(it.row()))] = root(piece_, static_cast<int>(it.col()));
  number();
}

Pieces::Pieces(int n, const std::function<void(const Couple&)>& couple_all)
    : piece_(each_alone(n)) {
  couple_all([&](int i, int j) { piece_[root(piece_, i)] = root(piece_, j); });
  number();
}

Pieces::Pieces(int n, const std::function<void(int, Vector&)>& column) : piece_(each_alone(n)) {
  Vector entries(n);
  for (int j = 0; j < n; ++j) {
    column(j, entries);
    for (int i = 0; i < n; ++i)
      if (entries[i] != 0.0) piece_[root(piece_, i)] = root(piece_, j);
  }
  number();
}

/// Roots become numbers without gaps.
void Pieces::number() {
  for (int& piece : piece_) piece = root(piece_, piece);
  std::vector<int> number_of(piece_.size(), -1);
  for (int& piece : piece_) {
    int& of_root = number_of[piece];
    if (of_root < 0) of_root = count_++;
    piece = of_root;
  }
  joined_ = each_alone(count_);
}

void Pieces::join(const SparseMatrix& h) {
  if (count_ < 2) return;
  std::iota(joined_.begin(), joined_.end(), 0);
  for (int i = 0; i < h.outerSize(); ++i)
    for (SparseMatrix::InnerIterator it(h, i); it; ++it)
      if (it.value() != 0.0)
        joined_[root(joined_, piece_[it.row()])] = root(joined_, piece_[it.col()]);
  for (int& piece : joined_) piece = root(joined_, piece);
}

void Pieces::leave_at_rest(const Vector& b, Vector& x) const {
  if (count_ < 2) return;
  std::vector<char> loaded(count_, 0);
  for (int i = 0; i < b.size(); ++i)
    if (b[i] != 0.0) loaded[joined_[piece_[i]]] = 1;
  for (int i = 0; i < x.size(); ++i)
    if (!loaded[joined_[piece_[i]]]) x[i] = 0.0;
}

} // namespace hvi::solver
