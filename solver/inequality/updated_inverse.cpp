// An inverse and its updates (updated_inverse.hpp).
#include "solver/inequality/updated_inverse.hpp"

#include <cblas.h>

namespace hvi::solver {

namespace {
/// An update after which less than this part is left along its direction loses too many digits.
constexpr double least_left = 1e-3;
/// Beyond this error the inverse is made again.
constexpr double too_rough = 1e-8;
} // namespace

UpdatedInverse::UpdatedInverse(const ContactPoints& points, const StiffnessPattern& pattern,
                               const ReducedOperator& s)
    : points_(points), pattern_(pattern), op_(s), pieces_(points) {}

/// For the points in these states, all of them inside a piece.
bool UpdatedInverse::make(const std::vector<int>& states) {
  made_ = false;
  history_.first_states = states;
  history_.updates.clear();
  history_.updates.reserve(6 * static_cast<std::size_t>(most_moved()));
  error = std::numeric_limits<double>::infinity();
  pieces_.resize(states.size());
  SparseMatrix h = pattern_.zero();
  for (int p = 0; p < points_.size(); ++p) {
    if (!pieces_.take(p, states[p])) return false;
    pattern_.add(p, {&pieces_[p].k, 1}, h);
  }
  return made_ = op_.inverse(h, inverse_);
}

/// Puts a point on another piece. Where that cannot be, pieces and inverse no longer agree, and it
/// has to be made anew.
bool UpdatedInverse::update(int p, int to_state) {
  const double before = pieces_[p].k;
  if (!pieces_.take(p, to_state)) return made_ = false;
  history_.updates.emplace_back(p, to_state);
  const double change = points_[p].weight * (pieces_[p].k - before);
  if (change == 0.0) return true;
  error = std::numeric_limits<double>::infinity();
  const int n = points_.unknowns;
  Vector v = Vector::Zero(n);
  double along = 0.0; // g . v
  for (SparseMatrix::InnerIterator it(points_.g, points_[p].first); it; ++it) {
    const auto j = it.col();
    v.head(j) += it.value() * inverse_.row(j).head(j).transpose();
    v.tail(n - j) += it.value() * inverse_.col(j).tail(n - j);
  }
  for (SparseMatrix::InnerIterator it(points_.g, points_[p].first); it; ++it)
    along += it.value() * v[it.col()];
  const double left = 1.0 + change * along, alpha = -change / left;
  if (!(left > least_left)) return made_ = false;
  cblas_dsyr(CblasColMajor, CblasLower, n, alpha, v.data(), 1, inverse_.data(), n);
  return true;
}

bool UpdatedInverse::bring(const std::vector<int>& states) {
  const std::vector<int>& now = pieces_.states();
  const bool same = made_ && states == now;
  std::size_t moved = 0;
  for (int p = 0; p < points_.size() && !same; ++p) {
    if (states[p] < 0 || states[p] % 2 == 1) return false;
    moved += made_ && states[p] != now[p];
  }
  const auto most = static_cast<std::size_t>(most_moved());
  if (!made_ || moved > most || history_.updates.size() > 4 * most ||
      (std::isfinite(error) && error > too_rough))
    return make(states);
  for (int p = 0; p < points_.size() && moved > 0; ++p)
    if (states[p] != now[p] && !update(p, states[p])) return false;
  return true;
}

int UpdatedInverse::follow(const Vector& z) {
  int moved = 0;
  for (int p = 0; p < points_.size(); ++p) {
    const int state = pieces_.next_state(p, z[points_[p].first]);
    if (state == StraightPieces::stays) continue;
    if (state == StraightPieces::unreachable) return -1;
    if (++moved > most_moved() || !update(p, state)) return -1;
  }
  return moved;
}

void UpdatedInverse::solve(const Vector& b, Vector& x) const {
  const int n = points_.unknowns;
  x.resize(n);
  cblas_dsymv(CblasColMajor, CblasLower, n, 1.0, inverse_.data(), n, b.data(), 1, 0.0, x.data(), 1);
}

bool UpdatedInverse::remake(const InverseHistory& history) {
  const auto possible = [&](int point, int state) {
    return point >= 0 && point < points_.size() && state >= 0 &&
           points_.law(point).valid_state(state);
  };
  for (int p = 0; p < points_.size(); ++p)
    if (!possible(p, history.first_states[p])) return false;
  if (!make(history.first_states)) return false;
  for (const auto& [point, state] : history.updates)
    if (!possible(point, state) || !update(point, state)) return false;
  return true;
}

} // namespace hvi::solver
