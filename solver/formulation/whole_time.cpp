// Errors of the steps together; see whole_time.hpp.
#include "solver/formulation/whole_time.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int most_vectors = 60, least_vectors = 4;
/// An estimate needs no more than this, relative to e.
constexpr double small_error = 0.01;
/// The number of triangular solves times unknowns that costs next to nothing, and the allowed share
/// of the run's own solves.
constexpr double cheap_solves = 3e4;
constexpr double share_of_run = 0.02;

} // namespace

Vector whole_coefficients(const Operators& operators, double length,
                          std::span<const double> memory) {
  Vector by_field = Vector::Zero(operators.n_fields());
  by_field[field_of_u(0)] = 1.0;
  by_field[field_of_u(1)] = 1.0 / length;
  by_field[field_of_u(2)] = 2.0 / (length * length); // u = a t^2 / 2
  for (std::size_t m = 0; m < memory.size(); ++m)
    by_field[field_of_memory(static_cast<int>(m))] = memory[m];
  return operators.weights.transpose() * by_field;
}

int vectors_for_whole_time(int unknowns, int contact_rows, int steps) {
  const double c = contact_rows; // laws make a dense tangent each time
  const double work = unknowns + c * c + c * c * c / 30.0;
  const double allowed = cheap_solves / work + share_of_run * steps / 2.0;
  return allowed < least_vectors ? 0 : std::min(most_vectors, static_cast<int>(allowed));
}

/// answer = R (more + D v).
bool WholeTime::respond(const Vector& v, const Vector& more) {
  Vector force = more;
  state_.head(v.size()) = v;
  for (Eigen::Index b = 0; b < change_.size(); ++b)
    if (change_[b] != 0.0)
      force.noalias() += change_[b] * (operators_.bases[static_cast<std::size_t>(b)] * state_);
  return hvi::solver::respond(matrix_, std::span<const Vector>(&force, 1), at_, answer_,
                              multipliers_);
}

bool WholeTime::relax(const Vector& force, int most, double bound, Vector& x, Vector& xi) {
  const double size = x.norm();
  if (!(size > 0.0) || !std::isfinite(size)) return false;
  Vector left = x, e = Vector::Zero(x.size());
  const auto take = [&](const Direction& d) {
    const double part = d.image.dot(left);
    e += part * d.vector;
    left -= part * d.image;
  };
  for (const Direction& d : directions_) take(d);
  while (!(left.norm() * bound <= small_error * e.norm())) {
    if (std::ssize(directions_) >= most || !add_direction(left)) return false;
    take(directions_.back());
  }
  // Once more: what is left shrinks, and the multipliers are found.
  if (!respond(e, force)) return false;
  x = answer_.front();
  if (!multipliers_.empty()) xi = multipliers_.front();
  return true;
}

/// v and (1 - R D) v, orthogonal to the images before and of length one.
bool WholeTime::add_direction(const Vector& v) {
  if (!respond(v, Vector::Zero(v.size()))) return false;
  Direction d{v, v - answer_.front()};
  const double size = d.image.norm();
  for (int twice = 0; twice < 2; ++twice)
    for (const Direction& before : directions_) {
      const double part = before.image.dot(d.image);
      d.vector -= part * before.vector;
      d.image -= part * before.image;
    }
  const double left = d.image.norm();
  if (!(left > 1e-12 * size)) return false;
  d.vector /= left, d.image /= left;
  directions_.push_back(std::move(d));
  return true;
}

} // namespace hvi::solver
