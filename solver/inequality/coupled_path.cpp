// The path of solutions of coupled laws as their bounds grow from 0 to what they are (coupled.hpp).
//
// A solution exists at every share, but those at growing shares need not hang together: the path
// may turn back, at a limit point or at a kink where a point changes its state, and reach share 1
// by a detour. So it is followed by its arc length (H. B. Keller, Numerical solution of bifurcation
// and nonlinear eigenvalue problems, in: Applications of Bifurcation Theory, 1977): with the
// direction (a, b) of the last chord each solution is sought in the plane
//
//     <a, c - c_last> + b (share - share_last) = length.
//
// Where that plane holds none, the path may have turned: the same with -b.
#include "solver/inequality/coupled.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

constexpr int most_steps = 400, most_failures = 400;
constexpr int most_corrections = 12;
constexpr double first_length = 1e-2, shortest_length = 1e-6, longest_length = 0.2;

} // namespace

void InequalityEngine::Coupled::go(const Waypoint& to) {
  set_share(to.share);
  go(to.place);
}

double InequalityEngine::Coupled::product(const Vector& a, const Vector& b) const {
  return a.cwiseProduct(w.diagonal.cwiseAbs()).dot(b) / energy;
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

/// Newton's method in the plane at `length` from the last solution; false leaves it anywhere.
bool InequalityEngine::Coupled::step_on_path(const Waypoint& last, const Vector& along,
                                             double along_share, double length) {
  set_share(std::max(1e-3, last.share + length * along_share));
  go(last.place);
  w.c += length * along;
  w.update_z();
  merit();
  for (int k = 0; k < most_corrections; ++k) {
    w.snap_factor = k < 4 ? tight_snap : certificate_snap;
    if (!direction() || !share_direction()) return false;
    const double gap =
        length - product(along, w.c - last.place.c) - along_share * (share - last.share);
    const double rate = product(along, path_c) + along_share;
    const double ds = (gap - product(along, w.dc)) / rate;
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

/// At a kink: the direction of the path on the pieces a little further on, along or against which
/// the solutions go on. True when one was found; not the way back.
bool InequalityEngine::Coupled::turn_on_path(const Waypoint& last, const Vector& along,
                                             double along_share) {
  for (const double ahead : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2}) {
    for (const double side : {1.0, -1.0}) {
      go(last);
      w.c += ahead * along;
      set_share(std::max(1e-3, last.share + side * ahead * along_share));
      merit();
      if (!direction() || !share_direction()) continue;
      Vector there = path_c;
      double there_share = 1.0;
      const double size = std::sqrt(product(there, there) + 1.0);
      there /= size, there_share /= size;
      for (const double sign : {1.0, -1.0}) {
        const double way = sign * (product(there, along) + there_share * along_share);
        if (way < -0.9999) continue;
        const Vector to = sign * there;
        for (const double length : {3.0 * ahead, 30.0 * ahead}) {
          if (!step_on_path(last, to, sign * there_share, length)) continue;
          const Vector gone = w.c - last.place.c;
          const double gone_share = share - last.share;
          const double far = std::sqrt(product(gone, gone) + gone_share * gone_share);
          if (product(gone, along) + gone_share * along_share > -0.999 * far) return true;
        }
      }
    }
  }
  return false;
}

bool InequalityEngine::Coupled::follow_share() {
  scale = 1.0;
  Waypoint last = waypoint();
  if (!(last.share > 0.0)) return false;
  energy = std::max(last.place.c.cwiseAbs2().dot(w.diagonal.cwiseAbs()),
                    std::numeric_limits<double>::min());
  Vector along = last.place.c - previous.place.c;
  double along_share = last.share - previous.share, length = first_length;
  const auto normalise = [&] {
    const double size = std::sqrt(product(along, along) + along_share * along_share);
    if (!(size > 0.0)) return false;
    along /= size, along_share /= size;
    return true;
  };
  if (!normalise()) return false;
  int failures = 0;
  for (int step = 0; step < most_steps && failures < most_failures;) {
    bool found = step_on_path(last, along, along_share, length);
    if (!found) found = step_on_path(last, along, -along_share, length);
    if (!found) {
      ++failures;
      length /= 4.0;
      if (length >= shortest_length) continue;
      if (!turn_on_path(last, along, along_share)) break;
      length = first_length;
    }
    ++step;
    const Waypoint now = waypoint();
    if (now.share >= 1.0) {
      set_share(1.0);
      if (solve(most_corrections)) return true;
      go(now);
    }
    along = now.place.c - last.place.c, along_share = now.share - last.share;
    if (!normalise()) break;
    last = now;
    length = std::min(2.0 * length, longest_length);
  }
  go(last);
  return false;
}

} // namespace hvi::solver
