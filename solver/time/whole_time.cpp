// Errors of the steps together; see whole_time.hpp.
#include "solver/time/whole_time.hpp"

#include <Eigen/Jacobi>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int most_vectors = 60, least_vectors = 4;
/// An estimate needs no more than this, relative to e.
constexpr double small_error = 0.01;
/// Sweeps over one unknown that cost next to nothing, and the share of the run's own sweeps.
constexpr double cheap_sweeps = 3e4;
constexpr double share_of_run = 0.02;

/// The weights w that make |size e_1 - H w| least, H growing by a column (of one entry below the
/// diagonal) each time: H is kept turned into a triangle.
class LeastSquares {
public:
  LeastSquares(int most, double size)
      : triangle_(DenseMatrix::Zero(most, most)), right_(Vector::Unit(most + 1, 0) * size) {}

  /// The residual with this column, too.
  double add(Vector column) {
    const auto m = static_cast<Eigen::Index>(turns_.size());
    for (Eigen::Index k = 0; k < m; ++k)
      column.applyOnTheLeft(k, k + 1, turns_[static_cast<std::size_t>(k)].adjoint());
    turns_.emplace_back().makeGivens(column[m], column[m + 1]);
    column.applyOnTheLeft(m, m + 1, turns_.back().adjoint());
    right_.applyOnTheLeft(m, m + 1, turns_.back().adjoint());
    triangle_.col(m).head(m + 1) = column.head(m + 1);
    return std::abs(right_[m + 1]);
  }
  Vector weights() const {
    const auto m = static_cast<Eigen::Index>(turns_.size());
    return triangle_.topLeftCorner(m, m).triangularView<Eigen::Upper>().solve(right_.head(m));
  }

private:
  DenseMatrix triangle_;
  Vector right_;
  std::vector<Eigen::JacobiRotation<double>> turns_;
};

} // namespace

Vector whole_coefficients(const Operators& operators, double length,
                          std::span<const double> memory) {
  Vector by_field = Vector::Zero(operators.n_fields());
  by_field[field_u] = 1.0;
  by_field[field_rate] = 1.0 / length;
  for (std::size_t m = 0; m < memory.size(); ++m)
    by_field[first_history_field + static_cast<int>(m)] = memory[m];
  return operators.weights.transpose() * by_field;
}

int vectors_for_whole_time(int unknowns, int contact_rows, int steps) {
  const double c = contact_rows; // laws make a dense tangent each time
  const double work = unknowns + c * c + c * c * c / 30.0;
  const double allowed = cheap_sweeps / work + share_of_run * steps / 2.0;
  return allowed < least_vectors ? 0 : std::min(most_vectors, static_cast<int>(allowed));
}

/// answer = R (more + D v).
bool WholeTime::respond(const Vector& v, const Vector& more) {
  Vector force = more;
  state_.head(v.size()) = v;
  for (Eigen::Index b = 0; b < change_.size(); ++b)
    if (change_[b] != 0.0)
      force.noalias() += change_[b] * (operators_.bases[static_cast<std::size_t>(b)] * state_);
  return matrix_.respond(std::span<const Vector>(&force, 1), at_, answer_, multipliers_);
}

bool WholeTime::relax(const Vector& force, int most, double bound, Vector& x, Vector& xi) {
  const double size = x.norm();
  if (!(size > 0.0) || !std::isfinite(size)) return false;
  const Vector none = Vector::Zero(x.size());
  DenseMatrix basis(x.size(), most);
  LeastSquares least(most, size);
  Vector next = x / size;
  for (int m = 0; m < most; ++m) {
    basis.col(m) = next;
    if (!respond(next, none)) return false;
    next -= answer_.front(); // (1 - R D) v
    const double image = next.norm();
    Vector products = Vector::Zero(m + 2);
    for (int twice = 0; twice < 2; ++twice) {
      const Vector part = basis.leftCols(m + 1).transpose() * next;
      next.noalias() -= basis.leftCols(m + 1) * part;
      products.head(m + 1) += part;
    }
    const double left = products[m + 1] = next.norm();
    const double residual = least.add(std::move(products));
    const Vector weights = least.weights();
    if (residual * bound <= small_error * weights.norm()) {
      // Once more: what is left shrinks, and the multipliers are found.
      if (!respond(basis.leftCols(m + 1) * weights, force)) return false;
      x = answer_.front();
      if (!multipliers_.empty()) xi = multipliers_.front();
      return true;
    }
    if (!(left > 1e-12 * image)) return false;
    next /= left;
  }
  return false;
}

} // namespace hvi::solver
