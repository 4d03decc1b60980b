// The quadrature of the audit; see independent.hpp.
#include "solver/history/independent.hpp"

#include "solver/common/stream.hpp"
#include "solver/history/past_weights.hpp"
#include "solver/kernel/algebra.hpp"

#include <boost/math/quadrature/gauss.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hvi::solver {

namespace {

/// Two rules agree when they differ by less than this share of int |q|.
constexpr double agree = 1e-11;
constexpr std::size_t most_pieces = 4000;
/// Intervals that are evaluated together.
constexpr std::size_t together = 2048;

using Rule = boost::math::quadrature::gauss<double, 6>;
constexpr std::size_t points = 6;

struct Part {
  Moments value;
  double size = 0; ///< int |f|
};

void place(double from, double to, double* x) {
  const double half = 0.5 * (to - from), middle = from + half;
  for (std::size_t p = 0; p < points / 2; ++p) {
    x[2 * p] = middle - half * Rule::abscissa()[p];
    x[2 * p + 1] = middle + half * Rule::abscissa()[p];
  }
}

/// Of the values q at the places x, which lie in the interval (low, high).
Part add(const double* x, const double* q, double length, double low, double high) {
  Part out;
  for (std::size_t p = 0; p < points; ++p) {
    const double value = 0.5 * length * Rule::weights()[p / 2] * q[p];
    out.value = out.value + Moments{value, value * ((x[p] - low) / (high - low))};
    out.size += std::abs(value);
  }
  return out;
}

double difference(const Part& whole, const Moments& halves) {
  return std::max(std::abs(halves.zero - whole.value.zero), std::abs(halves.one - whole.value.one));
}

/// int f over (from, to), halved until the halves agree with the whole; places in (low, high).
template <class F>
Moments halved(const F& f, double from, double to, double low, double high) {
  const auto gauss = [&](double a, double b) {
    std::array<double, points> x{}, q{};
    place(a, b, x.data());
    for (std::size_t p = 0; p < points; ++p) q[p] = f(x[p]);
    return add(x.data(), q.data(), b - a, low, high);
  };
  struct Open {
    double from, to;
    Part whole;
  };
  std::vector<Open> open{{from, to, gauss(from, to)}};
  const double first = open.front().whole.size;
  Moments sum;
  double size = 0;
  for (std::size_t pieces = 0; !open.empty(); ++pieces) {
    const Open piece = open.back();
    open.pop_back();
    const double middle = 0.5 * (piece.from + piece.to);
    const Part left = gauss(piece.from, middle), right = gauss(middle, piece.to);
    const Moments both = left.value + right.value;
    const double known = std::max({first, size, left.size + right.size});
    const bool shortest = !(middle > piece.from && middle < piece.to);
    if (difference(piece.whole, both) <= agree * known || shortest || pieces >= most_pieces) {
      sum = sum + both;
      size += left.size + right.size;
      continue;
    }
    open.push_back({piece.from, middle, left});
    open.push_back({middle, piece.to, right});
  }
  return sum;
}

/// q(t, lag = t - s) with s in slot::lag.
Expr of_source(const Expr& expression) {
  const std::array<std::pair<Slot, Expr>, 1> change{
      {{slot::lag, Expr::variable(slot::t) - Expr::variable(slot::lag)}}};
  return substitute(expression, change);
}

} // namespace

Moments independent_integral(const PreparedKernel& kernel, double t, double k) {
  using Fine = boost::math::quadrature::gauss<double, 20>;
  const double e = kernel.traits.singular_exponent, m = 1 / (1 - e);
  std::vector<double> ends = kernel.breaks.inside(t, 0, k);
  kernel.function.resolved_edges(t, 0, k, ends);
  for (double& lag : ends) lag = std::pow(lag / k, 1 / m);
  for (int j = 1; j < 60; ++j) ends.push_back(std::ldexp(1, -j));
  for (int j = 2; j < 50; ++j) ends.push_back(1 - std::ldexp(1, -j));
  ends.insert(ends.end(), {0.0, 1.0});
  std::sort(ends.begin(), ends.end());
  Moments sum;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double half = 0.5 * (ends[i + 1] - ends[i]), middle = 0.5 * (ends[i + 1] + ends[i]);
    for (std::size_t p = 0; half > 0 && p < Fine::abscissa().size(); ++p)
      for (const double sign : {-1.0, 1.0}) {
        const double v = middle + sign * half * Fine::abscissa()[p];
        // q dlag = [q lag^e] k^(1 - e) m dv; below 1e-290 the bracket is at its limit.
        const double lag = std::max(k * std::pow(v, m), 1e-290);
        const double value = half * Fine::weights()[p] * kernel.function(t, lag) *
                             std::pow(lag, e) * std::pow(k, 1 - e) * m;
        sum.zero += value;
        sum.one += value * (lag / k);
      }
  }
  return sum;
}

IndependentSum::IndependentSum(const PreparedKernel& kernel, std::size_t n, int order,
                               double expected_step)
    : kernel_(kernel), n_(n), order_(order), accepted_(expected_step) {
  if (kernel.breaks.singular_at_source_zero())
    by_source_ =
        std::make_shared<KernelFunction>(of_source(kernel.spec.expression), kernel.spec.origin);
}

void IndependentSum::start(double t0, std::span<const double> u0) {
  accepted_.start(t0);
  times_.assign(1, t0);
  values_.clear();
  by_index_.clear();
  if (order_ == 1) values_.assign(u0.begin(), u0.end());
}

void IndependentSum::commit(double t, std::span<const double> u) {
  accepted_.accept(t);
  times_.push_back(t);
  values_.insert(values_.end(), u.begin(), u.end());
}

bool IndependentSum::reaches_source_zero(double t, const Interval& i) const {
  return by_source_ && std::abs(t - i.high) <= 4e-16 * t;
}

/// Breaks of q(t, .) between two lags, and where the proof found it to change.
std::vector<double> IndependentSum::find_cuts(double t, double low, double high) const {
  std::vector<double> cuts;
  kernel_.function.resolved_edges(t, low, high, cuts);
  if (!kernel_.breaks.searched()) {
    const auto inside = kernel_.breaks.inside(t, low, high);
    cuts.insert(cuts.end(), inside.begin(), inside.end());
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

/// The cuts of a convolution depend on the interval alone, not on those that are integrated with
/// it: a resumed run, which finds all its weights at once, has the bits of one that found them step
/// by step.
const std::vector<double>& IndependentSum::cuts(double t, const Interval& i) {
  if (!kernel_.traits.convolution) return cuts_;
  const int k = std::ilogb(i.high) + 1;
  const auto [entry, fresh] = octave_cuts_.try_emplace(k);
  if (fresh) entry->second = find_cuts(t, 0, std::ldexp(1.0, k));
  return entry->second;
}

/// Is q smooth within the interval, as far as the proof and the breaks say?
bool IndependentSum::plain(double t, const Interval& i) {
  const auto& known = cuts(t, i);
  const auto cut = std::upper_bound(known.begin(), known.end(), i.low);
  const bool whole = cut == known.end() || *cut >= i.high;
  return whole && !kernel_.breaks.searched() && !reaches_source_zero(t, i);
}

Moments IndependentSum::weight(double t, const Interval& i) {
  const auto& known = cuts(t, i);
  const auto first = std::upper_bound(known.begin(), known.end(), i.low);
  std::vector<double> ends(first, std::lower_bound(first, known.end(), i.high));
  if (kernel_.breaks.searched()) {
    const auto inside = kernel_.breaks.inside(t, i.low, i.high);
    ends.insert(ends.end(), inside.begin(), inside.end());
    std::sort(ends.begin(), ends.end());
  }
  ends.push_back(i.high);
  const auto f = [&](double lag) { return kernel_.function(t, lag); };
  Moments sum;
  double from = i.low;
  for (const double to : ends) {
    if (to > from)
      sum = sum + (to == i.high && reaches_source_zero(t, i) ? from_source(t, from, i)
                                                             : halved(f, from, to, i.low, i.high));
    from = to;
  }
  return sum;
}

/// The lags (from, high) that reach s = 0, as a function of s itself: in lags its digits are lost.
Moments IndependentSum::from_source(double t, double from, const Interval& i) const {
  const auto f = [&](double s) { return (*by_source_)(t, s); };
  // The place of s = t - lag in the interval of s runs the other way.
  const Moments m = halved(f, 0.0, t - from, 0.0, i.high - i.low);
  return {m.zero, m.zero - m.one};
}

void IndependentSum::integrate(double t, std::span<const Interval> intervals,
                               std::span<Moments> out) {
  if (intervals.empty()) return;
  if (!kernel_.traits.convolution) {
    double low = intervals.front().low, high = intervals.front().high;
    for (const Interval& i : intervals) low = std::min(low, i.low), high = std::max(high, i.high);
    cuts_ = find_cuts(t, low, high);
  }
  constexpr std::size_t each = 3 * points;
  for (std::size_t begin = 0; begin < intervals.size(); begin += together) {
    const std::size_t count = std::min(together, intervals.size() - begin);
    lags_.resize(each * count);
    kernel_values_.resize(each * count);
    for (std::size_t j = 0; j < count; ++j) {
      const Interval& i = intervals[begin + j];
      const double middle = 0.5 * (i.low + i.high);
      place(i.low, i.high, &lags_[each * j]);
      place(i.low, middle, &lags_[each * j + points]);
      place(middle, i.high, &lags_[each * j + 2 * points]);
    }
    kernel_.function.evaluate(t, lags_, kernel_values_);
    for (std::size_t j = 0; j < count; ++j) {
      const Interval& i = intervals[begin + j];
      const auto part = [&](std::size_t k, double length) {
        const std::size_t at = each * j + k * points;
        return add(&lags_[at], &kernel_values_[at], length, i.low, i.high);
      };
      const double length = i.high - i.low;
      const Part whole = part(0, length), left = part(1, 0.5 * length),
                 right = part(2, 0.5 * length);
      const Moments both = left.value + right.value;
      const bool good = plain(t, i) && difference(whole, both) <= agree * whole.size;
      out[begin + j] = good ? both : weight(t, i);
    }
  }
}

void IndependentSum::sum(double t_new, std::span<double> out) {
  const std::size_t count = times_.size() - 1;
  const auto step = accepted_.common_step(t_new);
  std::vector<Moments> weights(count);
  std::vector<Interval> intervals;
  if (kernel_.traits.convolution && step) {
    const std::size_t known = std::max<std::size_t>(1, by_index_.size()); // 0: the own step
    for (std::size_t m = known; m <= count; ++m)
      intervals.push_back({static_cast<double>(m) * *step, static_cast<double>(m + 1) * *step});
    by_index_.resize(std::max(count + 1, by_index_.size()));
    integrate(0.0, intervals, {by_index_.data() + known, intervals.size()});
    for (std::size_t j = 0; j < count; ++j) weights[j] = by_index_[count - j];
  } else {
    for (std::size_t j = 0; j < count; ++j)
      intervals.push_back({t_new - times_[j + 1], t_new - times_[j]});
    integrate(t_new, intervals, weights);
  }
  put_node_weights(weights, order_, node_weights_);
  if (order_ == 1)
    node_weights_.back() += independent_integral(kernel_, t_new, t_new - times_.back()).one;
  std::fill(out.begin(), out.end(), 0.0);
  for (std::size_t j = 0; j < node_weights_.size(); ++j)
    for (std::size_t i = 0; i < n_; ++i) out[i] += node_weights_[j] * values_[j * n_ + i];
}

double IndependentSum::bytes() const {
  return static_cast<double>((times_.size() + values_.size()) * sizeof(double));
}

void IndependentSum::save(StateWriter& out) const {
  out.put(static_cast<std::uint64_t>(n_));
  out.put(order_);
  accepted_.save(out);
  out.put(times_);
  out.put(values_);
}

void IndependentSum::restore(StateReader& in) {
  in.expect(static_cast<std::uint64_t>(n_), "number of unknowns");
  in.expect(order_, "order");
  accepted_.restore(in);
  by_index_.clear();
  times_ = in.get_times(accepted_.start_time(), accepted_.now());
  values_ = in.get_numbers();
  if (times_.empty() || values_.size() != n_ * (times_.size() - (order_ == 0 ? 1 : 0)))
    in.fail("is inconsistent");
}

} // namespace hvi::solver
