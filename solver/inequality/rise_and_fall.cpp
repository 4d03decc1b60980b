// Jordan's decomposition of a law's slope (rise_and_fall.hpp).
#include "solver/inequality/rise_and_fall.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
/// Steps from an end of a piece, by factors of ten, that are looked at for turns of the slope.
constexpr int first_decade = -14, last_decade = 6, per_decade = 3;

/// Arguments of a piece from its ends inwards, and far out where it has none.
std::vector<double> looked_at(double low, double high) {
  const bool from_low = std::isfinite(low), from_high = std::isfinite(high);
  const double length =
      from_low && from_high
          ? high - low
          : std::max({1.0, from_low ? std::abs(low) : 0.0, from_high ? std::abs(high) : 0.0});
  std::vector<double> out;
  for (int k = first_decade * per_decade; k <= last_decade * per_decade; ++k) {
    const double step = length * std::pow(10.0, double(k) / per_decade);
    for (const double r : {low + step, high - step, step, -step})
      if (r > low && r < high) out.push_back(r);
  }
  std::sort(out.begin(), out.end());
  return out;
}

} // namespace

RiseAndFall::RiseAndFall(const PreparedLaw& law) : law_(&law) {
  const LawGraph& g = law.graph();
  for (int i = 0; i < g.pieces(); ++i) {
    const double low = piece_low(g, i, law.radial()), high = piece_high(g, i);
    if (low < 0.0 && high > 0.0) {
      cut(i, low, 0.0);
      cut(i, 0.0, high);
    } else {
      cut(i, low, high);
    }
  }
  const auto home = std::find_if(stretches_.begin(), stretches_.end(),
                                 [](const Stretch& s) { return s.low >= 0.0; });
  const auto first = static_cast<std::size_t>(home - stretches_.begin());
  const double at_origin = law.radial() ? std::max(0.0, -slope(0, 0.0)) : 0.0;
  add_up_to_the_right(first, at_origin);
  add_up_to_the_left(first, at_origin);
}

/// The slope of a piece, its limits at its ends.
double RiseAndFall::slope(int piece, double r) const {
  const LawGraph& g = law_->graph();
  if (piece > 0 && r <= g.breaks[piece - 1]) return g.right[piece - 1];
  if (piece + 1 < g.pieces() && r >= g.breaks[piece]) return g.left[piece];
  return law_->law().slope(g, piece, r);
}

/// Cuts a piece where its slope turns, as far as that is seen; what is missed is no harm but for
/// the convexity of the parts.
void RiseAndFall::cut(int piece, double low, double high) {
  const LawGraph& g = law_->graph();
  const auto rises = [&](double r) { return !(law_->law().curvature(g, piece, r) < 0.0); };
  const std::vector<double> at = looked_at(low, high);
  double start = low;
  for (std::size_t k = 0; k + 1 < at.size(); ++k) {
    if (rises(at[k]) == rises(at[k + 1])) continue;
    double a = at[k], b = at[k + 1];
    for (int step = 0; step < 60 && b - a > 1e-15 * std::abs(a); ++step) {
      const double m = a + (b - a) / 2.0;
      (rises(m) == rises(at[k]) ? a : b) = m;
    }
    stretches_.push_back({start, b, piece, rises(at[k]), 0.0});
    start = b;
  }
  stretches_.push_back({start, high, piece, at.empty() || rises(at.back()), 0.0});
}

void RiseAndFall::add_up_to_the_right(std::size_t first, double fall) {
  for (std::size_t k = first; k < stretches_.size(); ++k) {
    Stretch& s = stretches_[k];
    const double at_low = slope(s.piece, s.low);
    if (k > first) fall += std::max(0.0, slope(stretches_[k - 1].piece, s.low) - at_low);
    s.constant = s.rises ? fall : at_low + fall;
    if (!s.rises && std::isfinite(s.high)) fall = s.constant - slope(s.piece, s.high);
  }
}

void RiseAndFall::add_up_to_the_left(std::size_t past, double fall) {
  for (std::size_t k = past; k-- > 0;) {
    Stretch& s = stretches_[k];
    const double at_high = slope(s.piece, s.high);
    if (k + 1 < stretches_.size())
      fall -= std::max(0.0, at_high - slope(stretches_[k + 1].piece, s.high));
    s.constant = s.rises ? fall : at_high + fall;
    if (!s.rises && std::isfinite(s.low)) fall = s.constant - slope(s.piece, s.low);
  }
}

double RiseAndFall::fall_in(const Stretch& s, double r) const {
  return s.rises ? s.constant : s.constant - slope(s.piece, r);
}

double RiseAndFall::rising_in(const Stretch& s, double r) const {
  return s.rises ? s.constant + slope(s.piece, r) : s.constant;
}

double RiseAndFall::fall(double r) const {
  for (const Stretch& s : stretches_)
    if (r <= s.high) return fall_in(s, std::max(r, s.low));
  return fall_in(stretches_.back(), r);
}

GraphPoint RiseAndFall::resolvent(double y, double gamma) const {
  const LawGraph& g = law_->graph();
  if (law_->radial() && y <= gamma * rising_in(stretches_.front(), 0.0))
    return {-1, 0.0, y / gamma, 0.0};
  for (const Stretch& s : stretches_) {
    if (std::isfinite(s.high) && y > s.high + gamma * rising_in(s, s.high)) continue;
    if (std::isfinite(s.low) && y < s.low + gamma * rising_in(s, s.low)) // a jump up holds it
      return {s.piece > 0 && g.breaks[s.piece - 1] == s.low ? 2 * s.piece - 1 : 2 * s.piece, s.low,
              (y - s.low) / gamma, 0.0};
    const double z = s.rises ? solve_in(s, y, gamma) : y - gamma * s.constant;
    const double d = s.rises ? law_->law().curvature(g, s.piece, z) : 0.0;
    return {2 * s.piece, z, rising_in(s, z), std::isfinite(d) ? std::max(d, 0.0) : 0.0};
  }
  return {2 * stretches_.back().piece, y, 0.0, 0.0}; // y is no number
}

/// Newton's method in a bracket.
double RiseAndFall::solve_in(const Stretch& s, double y, double gamma) const {
  double low = s.low, high = s.high;
  double z = std::clamp(y, low, high);
  for (int k = 0; k < 200; ++k) {
    const double f = z + gamma * rising_in(s, z) - y;
    if (f == 0.0 || !std::isfinite(f)) break;
    (f > 0.0 ? high : low) = z;
    const double d = law_->law().curvature(law_->graph(), s.piece, z);
    double next = z - f / (1.0 + gamma * (d > 0.0 && d < endless ? d : 0.0));
    if (!(next > low && next < high))
      next = std::isfinite(low) && std::isfinite(high) ? low + (high - low) / 2.0
                                                       : std::clamp(z - f, low, high);
    if (std::abs(next - z) <= 0x1p-52 * std::abs(z)) break;
    z = next;
  }
  return z;
}

} // namespace hvi::solver
