// See separate.hpp.
#include "solver/linear/separate.hpp"

#include "solver/common/clock.hpp"
#include "solver/linear/lapack.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace hvi::solver {
namespace {

/// The least pivot, relative to its diagonal entry, and where.
struct LeastPivot {
  double value = std::numeric_limits<double>::infinity();
  int unknown = -1;
  void take(int of, double pivot) {
    if (!(pivot > 0.0) || !std::isfinite(pivot)) pivot = 0.0;
    if (pivot < value) value = pivot, unknown = of;
  }
};

/// The dense S and the diagonal of what follows it.
void read(const SparseMatrix& k, DenseMatrix& s, Vector& diagonal) {
  const auto n = static_cast<int>(s.rows());
  bool fits = k.rows() == n + diagonal.size() && k.cols() == k.rows();
  s.setZero();
  diagonal.setZero();
  for (int i = 0; fits && i < k.rows(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
      const auto j = static_cast<int>(it.col());
      if (i < n && j < n)
        s(i, j) = it.value();
      else if (i == j)
        diagonal[i - n] = it.value();
      else
        fits = fits && it.value() == 0.0;
    }
  if (!fits) throw Failure(FailureKind::bad_value, {}, "the matrix couples what is to be separate");
}

Eigen::Map<Vector> contact_part(RightHandSides y, const EliminationOrder& order) {
  return {y.only() + order.interior, order.contacts()};
}

class Separate final : public Factorisation {
public:
  Separate(int n_contact, int size) : s_(n_contact, n_contact), diagonal_(size - n_contact) {
    order_.interior = size - n_contact;
    for (int i = n_contact; i < size; ++i) order_.unknown.push_back(i);
    for (int i = 0; i < n_contact; ++i) order_.unknown.push_back(i);
    statistics_.ordering = "none";
    statistics_.nonzeros = static_cast<double>(n_contact) * (n_contact + 1.0) / 2.0;
    statistics_.bytes = 2.0 * n_contact * n_contact * sizeof(double);
  }
  std::unique_ptr<Factorisation> another() const override {
    return separate_factor(order_.contacts(), order_.size());
  }

  void factor(const SparseMatrix& k) override {
    const double start = cpu_seconds();
    factored_ = false;
    read(k, s_, diagonal_);
    ++statistics_.factorisations;
    l_ = s_.triangularView<Eigen::Lower>();
    const int n = order_.contacts();
    int info = 0;
    if (n > 0) dpotrf_("L", &n, l_.data(), &n, &info);
    LeastPivot least;
    if (info > 0) least.take(info - 1, 0.0);
    for (int i = 0; i < (info > 0 ? info - 1 : n); ++i)
      least.take(i, l_(i, i) * l_(i, i) / s_(i, i));
    for (int i = 0; i < order_.interior; ++i) least.take(n + i, diagonal_[i] > 0.0 ? 1.0 : 0.0);
    if (info != 0 || least.value < smallest_pivot)
      throw NotFactorable(least.unknown, least.value,
                          "the matrix is not positive definite: the elimination breaks down");
    statistics_.seconds_factor += cpu_seconds() - start;
    factored_ = true;
  }

  void forward(RightHandSides y, Columns columns) override {
    count_solve();
    double* entry = y.values;
    for (int i = 0; i < order_.interior; ++i)
      for (int k = 0; k < y.stride; ++k) *entry++ /= diagonal_[i];
    if (columns != Columns::interior)
      l_.triangularView<Eigen::Lower>().solveInPlace(contact_part(y, order_));
  }
  void back(RightHandSides y, Columns columns) override {
    count_solve();
    if (columns != Columns::interior)
      l_.transpose().triangularView<Eigen::Upper>().solveInPlace(contact_part(y, order_));
  }
  const DenseMatrix& schur() const override { return s_; }
  const EliminationOrder& order() const override { return order_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void count_solve() {
    if (!factored_) throw std::logic_error("a solve before a factorisation");
    ++statistics_.triangular_solves;
  }

  EliminationOrder order_;
  DenseMatrix s_, l_; ///< S = L L^T
  Vector diagonal_;
  bool factored_ = false;
  FactorStatistics statistics_;
};

} // namespace

std::unique_ptr<Factorisation> separate_factor(int n_contact, int size) {
  return std::make_unique<Separate>(n_contact, size);
}

} // namespace hvi::solver
