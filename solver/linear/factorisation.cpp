// What every direct solver can do with its own sweeps; see factorisation.hpp.
#include "solver/linear/factorisation.hpp"

#include <numeric>

namespace hvi::solver {

void Factorisation::reduce_each(std::span<const Vector> b, std::vector<Vector>& r,
                                std::vector<Vector>& kept) {
  r.resize(b.size());
  kept.resize(b.size());
  for (std::size_t k = 0; k < b.size(); ++k) {
    reduce(b[k], r[k]);
    kept[k] = this->kept();
  }
}

void Factorisation::back_all(const DenseMatrix& c, std::span<const Vector> kept,
                             const DenseMatrix& weights, DenseMatrix& x, std::vector<int>& place) {
  constexpr Eigen::Index unit = 8;
  const Eigen::Index rows = (c.cols() + unit - 1) / unit * unit;
  Vector one;
  for (Eigen::Index k = 0; k < c.cols(); ++k) {
    if (kept.empty()) {
      extend(c.col(k), one);
    } else {
      Vector sum = Vector::Zero(kept.front().size());
      for (std::size_t m = 0; m < kept.size(); ++m)
        sum += weights(k, static_cast<Eigen::Index>(m)) * kept[m];
      resume(sum);
      back(c.col(k), one);
    }
    if (k == 0) x.setZero(rows, one.size());
    x.row(k) = one.transpose();
  }
  place.resize(static_cast<std::size_t>(x.cols()));
  std::iota(place.begin(), place.end(), 0);
}

void Factorisation::back_each(std::span<const Vector> c, std::span<const Vector> kept,
                              std::vector<Vector>& x) {
  const auto count = static_cast<Eigen::Index>(c.size());
  if (count == 1) {
    resume(kept.front());
    x.resize(1);
    return back(c.front(), x.front());
  }
  DenseMatrix contact(c.front().size(), count), all;
  for (Eigen::Index k = 0; k < count; ++k) contact.col(k) = c[static_cast<std::size_t>(k)];
  std::vector<int> place;
  back_all(contact, kept, DenseMatrix::Identity(count, count), all, place);
  x.assign(c.size(), Vector(static_cast<Eigen::Index>(place.size())));
  for (std::size_t k = 0; k < c.size(); ++k)
    for (std::size_t i = 0; i < place.size(); ++i)
      x[k][static_cast<Eigen::Index>(i)] = all(static_cast<Eigen::Index>(k), place[i]);
}

} // namespace hvi::solver
