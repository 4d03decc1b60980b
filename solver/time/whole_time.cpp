// Errors of the steps together; see whole_time.hpp.
#include "solver/time/whole_time.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int most_vectors = 30, least_vectors = 4;
/// An estimate needs no more than this, relative to R f.
constexpr double small_residual = 0.05;
/// Sweeps over one unknown that cost next to nothing, and the share of the run's own sweeps.
constexpr double cheap_sweeps = 3e4;
constexpr double share_of_run = 0.02;

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

bool WholeTime::relax(const Vector& force, int most, Vector& x, Vector& xi) {
  const double size = x.norm();
  if (!(size > 0.0) || !std::isfinite(size)) return false;
  const Vector none = Vector::Zero(x.size());
  DenseMatrix basis(x.size(), most), images(x.size(), most);
  Vector next = x / size;
  for (int m = 0; m < most; ++m) {
    basis.col(m) = next;
    if (!respond(next, none)) return false;
    images.col(m) = next - answer_.front(); // (1 - R D) v
    const DenseMatrix tried = images.leftCols(m + 1);
    const Vector weights = tried.colPivHouseholderQr().solve(x);
    if ((x - tried * weights).norm() <= small_residual * size) {
      // Once more: what is left shrinks, and the multipliers are found.
      if (!respond(basis.leftCols(m + 1) * weights, force)) return false;
      x = answer_.front();
      if (!multipliers_.empty()) xi = multipliers_.front();
      return true;
    }
    next = images.col(m);
    for (int twice = 0; twice < 2; ++twice)
      next -= basis.leftCols(m + 1) * (basis.leftCols(m + 1).transpose() * next);
    const double left = next.norm();
    if (!(left > 1e-12 * images.col(m).norm())) return false;
    next /= left;
  }
  return false;
}

} // namespace hvi::solver
