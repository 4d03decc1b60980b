// Semismooth Newton on coupled laws (coupled.hpp).
#include "solver/inequality/coupled.hpp"

#include "solver/inequality/multipliers.hpp"
#include "solver/inequality/release.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

namespace hvi::solver {

namespace {

/// Steps after which the merit function must be below what it was.
constexpr std::size_t memory_of_merit = 6;
constexpr double shortest_step = 1.0 / 256.0;
constexpr int most_bad_steps = 4;
constexpr double smallest_raise = 1e-4;
constexpr int most_raises = 60;

} // namespace

CoupledNewton::CoupledNewton(Position& at, CoupledBounds& bounds, CoupledTangent& tangent,
                             double tolerance, InequalityReport& report)
    : at_(at), bounds_(bounds), tangent_(tangent), tolerance_(tolerance), report_(report),
      trial_(Vector::Zero(at.points.rows)) {}

CoupledPlace CoupledNewton::here() const {
  return {at_.c, at_.xi, at_.places.state, at_.places.component};
}

void CoupledNewton::go(const CoupledPlace& place) {
  at_.c = place.c, at_.xi = place.xi;
  at_.places.state = place.state, at_.places.component = place.component;
  at_.update_arguments();
}

/// The multiplier that the last `classify` gave the point.
double CoupledNewton::projected(int p) const {
  const PointData& q = at_.points[p];
  const GraphStates& places = at_.places;
  if (places.state[p] % 2 == 0) return places.xi_hat[q.first];
  return at_.xi[q.first] + (at_.z[q.first] - places.z_hat[q.first]) / (scale_ * q.gamma);
}

/// Places all points on their graphs: first those with a law of their own, then the coupled ones.
void CoupledNewton::classify() {
  for (int p = 0; p < at_.points.size(); ++p)
    if (!bounds_.is_coupled(p)) at_.places.classify(p, at_.z, at_.xi, scale_);
  for (CoupledBound& b : bounds_.all) {
    bounds_.set(b, projected(b.normal));
    at_.places.classify(b.point, at_.z, at_.xi, scale_);
    b.rate = bounds_.slope_rate(b);
  }
}

double CoupledNewton::merit() {
  const ContactPoints& points = at_.points;
  at_.balance.product.update(at_.c);
  at_.update_arguments();
  classify();
  const Vector& residual = at_.balance.residual(at_.xi);
  double sum = 0.0;
  for (int i = 0; i < points.unknowns; ++i)
    sum += residual[i] * residual[i] / std::max(std::abs(points.diagonal[i]), 1e-300);
  for (const PointData& q : points.data)
    for (int row = q.first; row < q.first + q.rows; ++row) {
      const double f = at_.z[row] - at_.places.z_hat[row];
      sum += f * f * q.weight / (scale_ * q.gamma);
    }
  return sum;
}

/// The componentwise residual with multipliers that stand for certain (in `trial_`): those of the
/// other laws first, for they are the bounds.
double CoupledNewton::multipliers(double snap_factor) {
  const ContactPoints& points = at_.points;
  const auto place_bounds = [&](bool slipping_only) {
    for (CoupledBound& b : bounds_.all) {
      bounds_.set(b, trial_[points[b.normal].first]);
      if (!slipping_only || !at_.places.resting(b.point))
        points[b.point].put(trial_, certain_multiplier(at_, b.point));
    }
  };
  at_.balance.product.update(at_.c);
  at_.snap.update(at_.c, at_.balance, snap_factor);
  for (int p = 0; p < points.size(); ++p)
    if (!bounds_.is_coupled(p)) points[p].put(trial_, certain_multiplier(at_, p));
  place_bounds(false);
  const Errors& errors = at_.balance.errors(at_.c, trial_);
  bool balanced = false;
  const auto balance_resting = [&](bool coupled) {
    for (int p = 0; p < points.size(); ++p)
      if (bounds_.is_coupled(p) == coupled && points[p].exclusive && at_.places.resting(p))
        balanced |= balance_point(at_, p, errors.left, trial_);
  };
  balance_resting(false);
  if (balanced) place_bounds(true);
  balance_resting(true);
  return balanced ? at_.balance.errors(at_.c, trial_).worst : errors.worst;
}

bool CoupledNewton::finish(double snap_factor, double& ratio) {
  const Vector before = at_.c;
  for (int p = 0; p < at_.points.size(); ++p) at_.places.settle(p, at_.c);
  at_.update_arguments();
  ratio = multipliers(snap_factor);
  if (ratio <= at_.balance.target()) {
    at_.xi = trial_;
    return true;
  }
  at_.c = before;
  at_.update_arguments();
  classify(); // the bounds of (c, xi) again
  return false;
}

/// The longest of the steps 1, 1/2, ... after which the merit function is below `limit`; where none
/// is, takes the best of them and returns 0.
double CoupledNewton::line_search(const CoupledStep& step, double limit, double& after) {
  const Vector c0 = at_.c, xi0 = at_.xi;
  double best = 1.0;
  after = std::numeric_limits<double>::infinity();
  const auto try_step = [&](double t) {
    at_.c = c0 + t * step.c;
    at_.xi = xi0 + t * (step.xi - xi0);
    return merit();
  };
  for (double t = 1.0; t >= shortest_step; t /= 2.0) {
    const double value = try_step(t);
    if (value < after) after = value, best = t;
    if (value <= (1.0 - 1e-2 * t) * limit) return t;
  }
  try_step(best);
  return 0.0;
}

bool CoupledNewton::newton(int limit) {
  std::deque<double> merits{merit()};
  CoupledStep direction;
  double ratio = 0.0, last_ratio = std::numeric_limits<double>::infinity();
  for (int k = 0, bad = 0; k < limit && bad < most_bad_steps; ++k) {
    if (!tangent_.step(direction, report_)) return false;
    double after = 0.0;
    const double step =
        line_search(direction, *std::max_element(merits.begin(), merits.end()), after);
    if (!std::isfinite(after)) return false;
    if (finish(k < 8 ? Snap::tight : Snap::certificate, ratio)) return true;
    if (step == 1.0 && ratio <= tolerance_ && ratio > 0.25 * last_ratio) {
      at_.xi = trial_; // no further progress but for rounding
      return true;
    }
    last_ratio = ratio;
    bad += step == 0.0;
    merits.push_back(after);
    if (merits.size() > memory_of_merit) merits.pop_front();
  }
  return false;
}

/// Newton's method with one factor of gamma, then with others.
bool CoupledNewton::newton_with_scales(int limit) {
  const CoupledPlace start = here();
  for (const double weight : {1.0, 0.1, 10.0}) {
    scale_ = weight;
    if (newton(limit)) return true;
    go(start);
  }
  return false;
}

bool CoupledNewton::solve(int limit) {
  for (int round = 0; round <= 20 * at_.points.size() + 100; ++round) {
    if (!newton_with_scales(limit)) return false;
    if (release_next(at_, round < 40 ? 1e-9 : 0.02 * (round - 39)).moved == 0) return true;
    at_.z_start = at_.z;
  }
  return false;
}

/// From a solution with share s to those with larger shares; false with the last one it reached.
bool CoupledNewton::raise_share() {
  double step = 1.0 - bounds_.share();
  CoupledPlace last = here();
  double reached = bounds_.share();
  for (int raise = 0; reached < 1.0; ++raise) {
    bounds_.set_share(std::min(1.0, reached + step));
    if (solve(25)) {
      reached = bounds_.share(), last = here();
      step *= 2.0;
      continue;
    }
    go(last);
    step /= 4.0;
    if (step < smallest_raise || raise > most_raises) {
      bounds_.set_share(reached);
      return false;
    }
  }
  return true;
}

} // namespace hvi::solver
