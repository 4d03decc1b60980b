// See separate.hpp.
#include "solver/linear/separate.hpp"

#include "solver/common/clock.hpp"
#include "solver/linear/lapack.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace hvi::solver {
namespace {

class Separate final : public Factorisation {
public:
  Separate(int n_contact, int size)
      : s_(n_contact, n_contact), diagonal_(size - n_contact), y_(Vector::Zero(size - n_contact)) {
    statistics_.ordering = "none";
    statistics_.nonzeros = static_cast<double>(n_contact) * (n_contact + 1.0) / 2.0;
    statistics_.bytes = 2.0 * n_contact * n_contact * sizeof(double);
  }
  std::unique_ptr<Factorisation> another() const override {
    return separate_factor(contacts(), contacts() + static_cast<int>(diagonal_.size()));
  }

  void factor(const SparseMatrix& k) override {
    const double start = cpu_seconds();
    factored_ = false;
    read(k);
    ++statistics_.factorisations;
    l_ = s_.triangularView<Eigen::Lower>();
    const int n = contacts();
    int info = 0;
    if (n > 0) dpotrf_("L", &n, l_.data(), &n, &info);
    double least = std::numeric_limits<double>::infinity();
    int where = -1;
    const auto take = [&](int unknown, double pivot) {
      if (!(pivot > 0.0) || !std::isfinite(pivot)) pivot = 0.0;
      if (pivot < least) least = pivot, where = unknown;
    };
    if (info > 0) take(info - 1, 0.0);
    for (int i = 0; i < (info > 0 ? info - 1 : n); ++i) take(i, l_(i, i) * l_(i, i) / s_(i, i));
    for (Eigen::Index i = 0; i < diagonal_.size(); ++i)
      take(contacts() + static_cast<int>(i), diagonal_[i] > 0.0 ? 1.0 : 0.0);
    if (info != 0 || least < smallest_pivot)
      throw NotFactorable(where, least,
                          "the matrix is not positive definite: the elimination breaks down");
    statistics_.seconds_factor = cpu_seconds() - start;
    factored_ = true;
  }

  void reduce(const Vector& b, Vector& r) override {
    if (!factored_) throw std::logic_error("reduce before a successful factorisation");
    r = b.head(contacts());
    y_ = b.tail(diagonal_.size()).cwiseQuotient(diagonal_);
    ++statistics_.triangular_solves;
  }
  void back(const Vector& c, Vector& x) override {
    x.resize(contacts() + diagonal_.size());
    x.head(contacts()) = c;
    x.tail(diagonal_.size()) = y_;
    ++statistics_.triangular_solves;
  }
  Vector kept() const override { return y_; }
  void resume(const Vector& kept) override { y_ = kept; }
  void solve(const Vector& b, Vector& x) override {
    Vector r;
    reduce(b, r);
    l_.triangularView<Eigen::Lower>().solveInPlace(r);
    l_.transpose().triangularView<Eigen::Upper>().solveInPlace(r);
    back(r, x);
  }
  const DenseMatrix& schur() const override { return s_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  int contacts() const { return static_cast<int>(s_.rows()); }

  void read(const SparseMatrix& k) {
    const int n = contacts();
    bool fits = k.rows() == n + diagonal_.size() && k.cols() == k.rows();
    s_.setZero();
    diagonal_.setZero();
    for (int i = 0; fits && i < k.rows(); ++i)
      for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
        const auto j = static_cast<int>(it.col());
        if (i < n && j < n)
          s_(i, j) = it.value();
        else if (i == j)
          diagonal_[i - n] = it.value();
        else
          fits = fits && it.value() == 0.0;
      }
    if (!fits)
      throw Failure(FailureKind::bad_value, {}, "the matrix couples what is to be separate");
  }

  DenseMatrix s_, l_;
  Vector diagonal_, y_;
  bool factored_ = false;
  FactorStatistics statistics_;
};

} // namespace

std::unique_ptr<Factorisation> separate_factor(int n_contact, int size) {
  return std::make_unique<Separate>(n_contact, size);
}

} // namespace hvi::solver
