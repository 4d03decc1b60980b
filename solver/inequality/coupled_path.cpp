// The path of solutions of coupled laws as their bounds grow from 0 to what they are (coupled.hpp).
//
// A solution exists at every share, but those at growing shares need not hang together: the path
// may turn back, at a limit point or at a kink where a point changes its state, and reach share 1
// by a detour. So it is followed by its arc length (H. B. Keller, Numerical solution of bifurcation
// and nonlinear eigenvalue problems, in: Applications of Bifurcation Theory, 1977): with its
// direction (a, b) at the last solution each is sought in the plane
//
//     <a, c - c_last> + b (share - share_last) = length.
//
// Where that plane holds none at any length there is a kink: the path goes on along other pieces.
#include "solver/inequality/coupled.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

constexpr int most_steps = 1000, most_failures = 1000;
constexpr int most_corrections = 12;
constexpr double first_length = 1e-2, shortest_length = 1e-6, longest_length = 0.2;
/// Where points take other pieces in a longer step it may have gone over to another path, and where
/// it turns by more than this cosine.
constexpr double longest_across_kink = 1e-3, least_cosine = 0.97;

} // namespace

void InequalityEngine::Coupled::go(const Waypoint& to) {
  set_share(to.share);
  go(to.place);
}

double InequalityEngine::Coupled::product(const Vector& a, const Vector& b) const {
  return a.cwiseProduct(w.diagonal.cwiseAbs()).dot(b) / energy;
}

double InequalityEngine::Coupled::product(const Heading& a, const Heading& b) const {
  return product(a.c, b.c) + a.share * b.share;
}

/// What (c, xi) of a linear step change with the share: path_c, path_xi. Needs the last factor.
bool InequalityEngine::Coupled::share_direction() {
  path_xi.setZero(w.n_rows);
  for (const Bound& b : bounds) {
    const Small e = slip(b);
    const double rate = b.rate * b.multiplier / share; // bounds know share times the multiplier
    for (int k = 0; k < w.points[b.point].rows; ++k)
      path_xi[w.points[b.point].first + k] = rate * e[k];
  }
  const Vector force = -(w.force_of * path_xi);
  lu->solve(force, path_c);
  const Vector z = w.problem.g * path_c;
  for (int p = 0; p < w.n_points; ++p) {
    const Small v = w.apply_d(p, w.at(z, p)), x = w.at(path_xi, p);
    w.put(path_xi, p, {x[0] + v[0], x[1] + v[1], x[2] + v[2]});
  }
  for (const Bound& b : bounds) {
    const Small e = slip(b);
    const double normal = b.rate * w.d[b.normal][0] * z[w.points[b.normal].first];
    for (int k = 0; k < w.points[b.point].rows; ++k)
      path_xi[w.points[b.point].first + k] += normal * e[k];
  }
  return path_c.allFinite();
}

/// Newton's method in the plane at `length` from the last solution; false leaves it anywhere. It
/// begins at multipliers that fit the displacements there: else a law that falls is linearised far
/// from both, and the points take other pieces than those of the path.
bool InequalityEngine::Coupled::step_on_path(const Waypoint& last, const Heading& along,
                                             double length) {
  set_share(std::max(1e-3, last.share + length * along.share));
  go(last.place);
  w.c += length * along.c;
  w.xi += length * along.xi;
  w.update_z();
  merit();
  for (int k = 0; k < most_corrections; ++k) {
    w.snap_factor = k < 4 ? tight_snap : certificate_snap;
    if (!direction() || !share_direction()) return false;
    const double gap =
        length - product(along.c, w.c - last.place.c) - along.share * (share - last.share);
    const double rate = product(along.c, path_c) + along.share;
    const double ds = (gap - product(along.c, w.dc)) / rate;
    if (!std::isfinite(ds) || std::abs(ds) > 0.5 || share + ds <= 0.0) return false;
    w.c += w.dc + ds * path_c;
    w.xi = target_xi + ds * path_xi;
    set_share(share + ds);
    if (!std::isfinite(merit())) return false;
    const double off = std::abs(ds);
    double ratio = 0.0;
    if (off <= 1e-9 && finish(ratio)) return true;
    if (off <= 1e-6 && k >= 2) { // the rest with the share that it has
      if (newton(most_corrections)) return true;
      return false;
    }
  }
  return false;
}

/// Where the path goes on from the present place, on the pieces there: with the share where the
/// determinant of the linearisation is positive, as it is at share 0, against it where not. A path
/// keeps that orientation along pieces and across kinks (B. C. Eaves, H. Scarf, The solution of
/// systems of piecewise linear equations, Math. Oper. Res. 1 (1976) 1-27), so that at a kink, where
/// a chord says little, the piece says which way is on.
bool InequalityEngine::Coupled::look_ahead(Heading& out) {
  merit();
  if (!direction() || !share_direction()) return false;
  const double size =
      std::copysign(std::sqrt(product(path_c, path_c) + 1.0), lu->determinant_sign());
  out = {path_c / size, path_xi / size, 1.0 / size};
  return true;
}

/// Has a step from `last` found the path, and not another one nearby? `next`: how it goes on.
bool InequalityEngine::Coupled::keeps_to_path(const Waypoint& last, const Heading& along,
                                              double length, Heading& next) {
  const bool same = w.state == last.place.state;
  if (!same && length > longest_across_kink) return false;
  const Heading gone{w.c - last.place.c, {}, share - last.share};
  if (!(product(gone, along) > least_cosine * std::sqrt(product(gone, gone)))) return false;
  return look_ahead(next) && (!same || product(next, along) > least_cosine);
}

/// At a kink: on along the pieces a little further on.
bool InequalityEngine::Coupled::turn_on_path(const Waypoint& last, const Heading& along) {
  Heading there;
  for (const double ahead : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2})
    for (const double side : {1.0, -1.0}) {
      go(last);
      w.c += ahead * along.c;
      w.xi += ahead * along.xi;
      set_share(std::max(1e-3, last.share + side * ahead * along.share));
      if (!look_ahead(there)) continue;
      for (const double length : {3.0 * ahead, 30.0 * ahead})
        if (step_on_path(last, there, length) && w.state != last.place.state) return true;
    }
  return false;
}

bool InequalityEngine::Coupled::follow_share() {
  scale = 1.0;
  if (!(share > 0.0)) return false;
  energy = std::max(w.c.cwiseAbs2().dot(w.diagonal.cwiseAbs()), std::numeric_limits<double>::min());
  double length = first_length;
  Heading along, next;
  Waypoint last = waypoint();
  if (!look_ahead(along)) return false;
  int failures = 0;
  for (int step = 0; step < most_steps && failures < most_failures; ++step) {
    last = waypoint();
    while (!step_on_path(last, along, length) || !keeps_to_path(last, along, length, next)) {
      ++failures;
      length /= 4.0;
      if (length >= shortest_length) continue;
      if (turn_on_path(last, along) && look_ahead(next)) break;
      go(last);
      return false;
    }
    if (share >= 1.0) {
      const Waypoint now = waypoint();
      set_share(1.0);
      if (solve(most_corrections)) return true;
      go(now);
    }
    along = next;
    length = std::min(2.0 * std::max(length, shortest_length), longest_length);
  }
  go(last);
  return false;
}

} // namespace hvi::solver
