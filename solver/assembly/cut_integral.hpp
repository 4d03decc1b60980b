// Integrals of loads over a step: a Gauss rule on pieces that are cut in two until the sums agree.
#pragma once

#include "solver/fem/quadrature.hpp"
#include "solver/linear/sparse.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

/// How often an interval is cut before two sums that are alike are believed, how often at most, and
/// which part of the integral's size is no difference. With five cuts at least, what is shorter
/// than a hundredth of the interval may be missed.
struct CutLimits {
  int least, most;
  double tolerance;
};

namespace cut_integral_parts {

/// Not in halves: a jump near the middle leaves the sums of a symmetric rule what they are.
constexpr double first_part = 0.381966011250105;
/// Of a time: in shorter pieces the points of a rule are their ends, where a load may be infinite.
constexpr double shortest = 1e-12;

inline double size_of(double value) { return std::abs(value); }
inline double size_of(const Vector& values) {
  return values.size() > 0 ? values.lpNorm<Eigen::Infinity>() : 0.0;
}

template <class Value, class F>
Value by_rule(const IntervalRule& rule, const F& f, double begin, double end) {
  const double length = end - begin;
  Value sum = rule.weights[0] * length * f(begin + rule.points[0] * length);
  for (std::size_t q = 1; q < rule.points.size(); ++q)
    sum += rule.weights[q] * length * f(begin + rule.points[q] * length);
  return sum;
}

/// The tolerance `alike` is the same at every depth: one that is divided falls below rounding.
/// `unsettled` grows by how far apart the sums are where there is no further cut.
template <class Value, class F>
Value cut(const CutLimits& limits, const IntervalRule& rule, const F& f, double begin, double end,
          const Value& whole, double alike, int depth, double& unsettled) {
  const double middle = begin + first_part * (end - begin);
  const Value left = by_rule<Value>(rule, f, begin, middle),
              right = by_rule<Value>(rule, f, middle, end), both = left + right;
  const bool told = depth >= limits.least && size_of(Value(both - whole)) <= alike;
  const bool tiny = end - begin <= shortest * std::max(std::abs(begin), std::abs(end));
  if (depth == limits.most || tiny || told) {
    if (!told) unsettled += size_of(Value(both - whole));
    return both;
  }
  return cut(limits, rule, f, begin, middle, left, alike, depth + 1, unsettled) +
         cut(limits, rule, f, middle, end, right, alike, depth + 1, unsettled);
}

} // namespace cut_integral_parts

template <class Value>
struct CutIntegral {
  Value value;
  double unsettled; ///< how far sums were apart at the last cuts, as a part of the integral's size
};

/// int f over [begin, end], f(t) a number or a vector of them.
template <class F>
auto cut_integral(const CutLimits& limits, const IntervalRule& rule, const F& f, double begin,
                  double end) {
  using Value = std::decay_t<decltype(f(begin))>;
  namespace parts = cut_integral_parts;
  const Value whole = parts::by_rule<Value>(rule, f, begin, end);
  const double size =
      parts::size_of(whole) +
      (end - begin) * parts::size_of(Value(f(end - rule.points[0] * (end - begin))));
  double unsettled = 0.0;
  const Value value =
      parts::cut(limits, rule, f, begin, end, whole, limits.tolerance * size, 0, unsettled);
  return CutIntegral<Value>{value, unsettled > 0.0 ? unsettled / size : 0.0};
}

} // namespace hvi::solver
