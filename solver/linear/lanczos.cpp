// Lanczos' method with thick restarts; see lanczos.hpp.
#include "solver/linear/lanczos.hpp"

#include "solver/linear/dense.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// Vectors in the basis; of many unknowns fewer, which then take the room of few long ones.
Eigen::Index basis_size(Eigen::Index n) {
  constexpr Eigen::Index many = 200000, vectors = 40;
  return std::min(n, n > many ? vectors / 2 : vectors);
}

/// The Krylov space of a map, orthonormal in its inner product, and the map on it.
class KrylovSpace {
public:
  explicit KrylovSpace(const SymmetricMap& map)
      : map_(map), size_(basis_size(map.n)), v_(map.n, size_), bv_(map.n, size_),
        h_(DenseMatrix::Zero(size_, size_)) {
    // No symmetry of a mesh is one of it.
    w_ = Vector::LinSpaced(map.n, 1.0, 2.0);
    measure();
  }

  std::optional<double> extreme(End end, double error) {
    constexpr int most_steps = 6000;
    for (int step = 0; step < most_steps; ++step) {
      if (!std::isfinite(beta_) || beta_ == 0.0) return std::nullopt;
      if (count_ == size_) restart(end);
      extend();
      if (count_ < size_ && !ended() && (count_ < first_look || count_ % 5 != 0)) continue;
      spectrum_ = symmetric_spectrum(h_.topLeftCorner(count_, count_));
      const Eigen::Index at = end == End::least ? 0 : count_ - 1;
      const double value = spectrum_.values[at];
      const double residual = beta_ * std::abs(spectrum_.vectors(count_ - 1, at));
      if (ended() || residual <= error * std::max(std::abs(value), smallest)) return value;
    }
    return std::nullopt;
  }

private:
  /// Before that a Ritz value may stand still at another eigenvalue.
  static constexpr Eigen::Index first_look = 20;
  /// An eigenvalue of this size counts as 0.
  static constexpr double smallest = 4e-11;

  /// B w by a product of its own: the B v of a combination that cancels is that of no vector.
  void measure() {
    bw_ = map_.metric(w_);
    beta_ = std::sqrt(std::max(0.0, w_.dot(bw_)));
  }

  /// What is left of T v is rounding: the space is an invariant one.
  bool ended() const {
    constexpr double rounding = 1e-13;
    return count_ == map_.n ||
           beta_ <= rounding * h_.topLeftCorner(count_, count_).cwiseAbs().maxCoeff();
  }

  /// Takes w in as the next vector of the basis, and T of it as the next w.
  void extend() {
    const Eigen::Index j = count_++;
    v_.col(j) = w_ / beta_, bv_.col(j) = bw_ / beta_;
    w_ = map_.apply(v_.col(j), bv_.col(j));
    const auto v = v_.leftCols(count_), bv = bv_.leftCols(count_);
    Vector column = Vector::Zero(count_);
    for (int pass = 0; pass < 2; ++pass) { // twice is enough (Kahan, Parlett)
      const Vector part = bv.transpose() * w_;
      w_.noalias() -= v * part;
      column += part;
    }
    measure();
    h_.col(j).head(count_) = column, h_.row(j).head(count_) = column.transpose();
  }

  /// Keeps the half of the Ritz vectors that lies at this end.
  void restart(End end) {
    const Eigen::Index kept = std::max<Eigen::Index>(1, size_ / 2);
    const DenseMatrix chosen =
        end == End::least ? spectrum_.vectors.leftCols(kept) : spectrum_.vectors.rightCols(kept);
    v_.leftCols(kept) = DenseMatrix(v_ * chosen);
    bv_.leftCols(kept) = DenseMatrix(bv_ * chosen);
    h_.setZero();
    h_.topLeftCorner(kept, kept).diagonal() =
        end == End::least ? spectrum_.values.head(kept) : spectrum_.values.tail(kept);
    count_ = kept;
  }

  const SymmetricMap& map_;
  Eigen::Index size_, count_ = 0;
  DenseMatrix v_, bv_, h_; ///< V, B V; V^T B T V
  Vector w_, bw_;          ///< what T V leaves behind V
  double beta_ = 0.0;      ///< its length
  Spectrum spectrum_;      ///< of h at the last look
};

} // namespace

std::optional<double> extreme_eigenvalue(const SymmetricMap& map, End end, double error) {
  if (map.n == 0) return std::nullopt;
  return KrylovSpace(map).extreme(end, error);
}

} // namespace hvi::solver
