// What every direct solver derives from its triangular solves; see factorisation.hpp.
#include "solver/linear/factorisation.hpp"

#include <numeric>
#include <stdexcept>

namespace hvi::solver {

void Factorisation::reduce_each(std::span<const Vector> b, std::vector<Vector>& r) {
  r.resize(b.size());
  kept_of_each_.clear();
  for (std::size_t k = 0; k < b.size(); ++k) {
    reduce(b[k], r[k]);
    kept_of_each_.push_back(kept());
  }
}

void Factorisation::back_each(std::span<const Vector> c, std::vector<Vector>& x) {
  if (c.size() != kept_of_each_.size()) throw std::logic_error("back_each before its reduce_each");
  x.resize(c.size());
  for (std::size_t k = 0; k < c.size(); ++k) {
    resume(kept_of_each_[k]);
    back(c[k], x[k]);
  }
}

void Factorisation::back_all(const DenseMatrix& c, std::span<const Vector> kept,
                             const DenseMatrix& weights, DenseMatrix& x, std::vector<int>& place) {
  constexpr Eigen::Index unit = 8;
  const Eigen::Index rows = (c.cols() + unit - 1) / unit * unit;
  Vector one;
  for (Eigen::Index k = 0; k < c.cols(); ++k) {
    Vector sum = Vector::Zero(this->kept().size());
    for (std::size_t m = 0; m < kept.size(); ++m)
      sum += weights(k, static_cast<Eigen::Index>(m)) * kept[m];
    resume(sum);
    back(c.col(k), one);
    if (k == 0) x.setZero(rows, one.size());
    x.row(k) = one.transpose();
  }
  place.resize(static_cast<std::size_t>(x.cols()));
  std::iota(place.begin(), place.end(), 0);
}

} // namespace hvi::solver
