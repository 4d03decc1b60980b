// The path of solutions by its arc length (coupled_path.hpp).
#include "solver/inequality/coupled_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

constexpr int most_steps = 1000, most_failures = 1000;
constexpr int most_on_path = 12;
constexpr double first_length = 1e-2, shortest_length = 1e-6, longest_length = 0.2;
/// A step longer than this in which points change their pieces, or one after which the direction
/// has turned by more than this cosine, may have landed on another path.
constexpr double longest_across_kink = 1e-3, least_cosine = 0.97;

} // namespace

SharePath::SharePath(Position& at, CoupledBounds& bounds, CoupledTangent& tangent,
                     CoupledNewton& newton, InequalityReport& report)
    : at_(at), bounds_(bounds), tangent_(tangent), newton_(newton), report_(report) {}

void SharePath::go(const Waypoint& to) {
  bounds_.set_share(to.share);
  newton_.go(to.place);
}

double SharePath::product(const Vector& a, const Vector& b) const {
  return a.cwiseProduct(at_.points.diagonal.cwiseAbs()).dot(b) / energy_;
}

double SharePath::product(const Heading& a, const Heading& b) const {
  return product(a.c, b.c) + a.share * b.share;
}

/// Newton's method in the plane at `length` from the last solution; false leaves it anywhere. It
/// begins at multipliers that fit the displacements there: else a law that falls is linearised far
/// from both, and the points take other pieces than those of the path.
bool SharePath::step(const Waypoint& last, const Heading& along, double length) {
  bounds_.set_share(std::max(1e-3, last.share + length * along.share));
  newton_.go(last.place);
  at_.c += length * along.c;
  at_.xi += length * along.xi;
  at_.update_arguments();
  newton_.merit();
  CoupledStep direction, by_share;
  for (int k = 0; k < most_on_path; ++k) {
    const double share = bounds_.share();
    if (!tangent_.step(direction, report_) || !tangent_.by_share(by_share)) return false;
    const double gap =
        length - product(along.c, at_.c - last.place.c) - along.share * (share - last.share);
    const double rate = product(along.c, by_share.c) + along.share;
    const double ds = (gap - product(along.c, direction.c)) / rate;
    if (!std::isfinite(ds) || std::abs(ds) > 0.5 || share + ds <= 0.0) return false;
    at_.c += direction.c + ds * by_share.c;
    at_.xi = direction.xi + ds * by_share.xi;
    bounds_.set_share(share + ds);
    if (!std::isfinite(newton_.merit())) return false;
    const double off = std::abs(ds);
    double ratio = 0.0;
    if (off <= 1e-9 && newton_.finish(k < 4 ? Snap::tight : Snap::certificate, ratio)) return true;
    if (off <= 1e-6 && k >= 2) { // the rest with the share that it has
      return newton_.newton(most_on_path);
    }
  }
  return false;
}

/// Where the path goes on from the present place, on the pieces there: with the share where the
/// determinant of the linearisation is positive, as it is at share 0, against it where not. A path
/// keeps that orientation along pieces and across kinks (B. C. Eaves, H. Scarf, The solution of
/// systems of piecewise linear equations, Math. Oper. Res. 1 (1976) 1-27), so that at a kink, where
/// a chord says little, the piece says which way is on.
bool SharePath::look_ahead(Heading& out) {
  CoupledStep direction, by_share;
  newton_.merit();
  if (!tangent_.step(direction, report_) || !tangent_.by_share(by_share)) return false;
  const double size =
      std::copysign(std::sqrt(product(by_share.c, by_share.c) + 1.0), tangent_.determinant_sign());
  out = {by_share.c / size, by_share.xi / size, 1.0 / size};
  return true;
}

/// Has a step from `last` found the path, and not another one nearby? `next`: how it goes on.
bool SharePath::keeps_to_path(const Waypoint& last, const Heading& along, double length,
                              Heading& next) {
  const bool same = at_.places.state == last.place.state;
  if (!same && length > longest_across_kink) return false;
  const Heading gone{at_.c - last.place.c, {}, bounds_.share() - last.share};
  if (!(product(gone, along) > least_cosine * std::sqrt(product(gone, gone)))) return false;
  return look_ahead(next) && (!same || product(next, along) > least_cosine);
}

/// Past a kink: goes on in the direction of the pieces a little further along.
bool SharePath::turn(const Waypoint& last, const Heading& along) {
  Heading there;
  for (const double ahead : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2})
    for (const double side : {1.0, -1.0}) {
      go(last);
      at_.c += ahead * along.c;
      at_.xi += ahead * along.xi;
      bounds_.set_share(std::max(1e-3, last.share + side * ahead * along.share));
      if (!look_ahead(there)) continue;
      for (const double length : {3.0 * ahead, 30.0 * ahead})
        if (step(last, there, length) && at_.places.state != last.place.state) return true;
    }
  return false;
}

bool SharePath::follow() {
  newton_.weigh_evenly();
  if (!(bounds_.share() > 0.0)) return false;
  energy_ = std::max(at_.c.cwiseAbs2().dot(at_.points.diagonal.cwiseAbs()),
                     std::numeric_limits<double>::min());
  double length = first_length;
  Heading along, next;
  Waypoint last = here();
  if (!look_ahead(along)) return false;
  int failures = 0;
  for (int count = 0; count < most_steps && failures < most_failures; ++count) {
    last = here();
    while (!step(last, along, length) || !keeps_to_path(last, along, length, next)) {
      ++failures;
      length /= 4.0;
      if (length >= shortest_length) continue;
      if (turn(last, along) && look_ahead(next)) break;
      go(last);
      return false;
    }
    if (bounds_.share() >= 1.0) {
      const Waypoint now = here();
      bounds_.set_share(1.0);
      if (newton_.solve(most_on_path)) return true;
      go(now);
    }
    along = next;
    length = std::min(2.0 * std::max(length, shortest_length), longest_length);
  }
  go(last);
  return false;
}

} // namespace hvi::solver
