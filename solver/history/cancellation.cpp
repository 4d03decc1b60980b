// Differences of one function at two times; see cancellation.hpp.
#include "solver/history/cancellation.hpp"

#include "solver/kernel/algebra.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace hvi::solver {

namespace {

Expr at_source(const Expr& f) {
  const std::array<std::pair<Slot, Expr>, 1> change{
      {{slot::t, Expr::variable(slot::t) - Expr::variable(slot::lag)}}};
  return substitute(f, change);
}

Expr difference(const Expr& f);

/// a b - a' b' = (a - a') b + a' (b - b').
Expr product_difference(const Expr& a, const Expr& b) {
  return difference(a) * b + at_source(a) * difference(b);
}

/// a/b - a'/b' = ((a - a') - (a'/b') (b - b')) / b.
Expr quotient_difference(const Expr& a, const Expr& b) {
  return (difference(a) - at_source(a) / at_source(b) * difference(b)) / b;
}

/// a^n - a'^n = (a - a') (a^(n-1) + a^(n-2) a' + ..).
Expr whole_power_difference(const Expr& a, int n) {
  const Expr then = at_source(a);
  Expr sum = 0.0;
  for (int i = 0; i < n; ++i) sum = sum + pow(a, Expr(n - 1 - i)) * pow(then, Expr(i));
  return difference(a) * sum;
}

/// e^a - e^a' = 2 e^((a + a')/2) sinh((a - a')/2).
Expr exponential_difference(const Expr& a) {
  const Expr half = Expr(0.5) * difference(a);
  return Expr(2.0) * exp(at_source(a) + half) * Expr::make(Op::sinh, {half});
}

/// log a - log a' with d = a - a': 2 artanh(d / (a + a')), by its series where d is small. The
/// conditions are affine where a is, so that the quadrature can split there.
Expr logarithm_difference(const Expr& a) {
  constexpr double small = 0.02; // the series ends beyond 1e-18
  const Expr then = at_source(a), d = difference(a), y = d / (a + then), z = y * y;
  Expr series = Expr(1.0 / 11);
  for (const int n : {9, 7, 5, 3, 1}) series = series * z + Expr(1.0 / n);
  series = Expr(2.0) * y * series;
  const Expr whole = log(a) - log(then);
  return select(less(d, Expr(small) * then), select(less(Expr(-small) * then, d), series, whole),
                whole);
}

Expr power_difference(const Expr& a, const Expr& exponent, const Expr& whole) {
  if (!exponent.is_constant()) return whole - at_source(whole);
  const double c = exponent.value();
  constexpr int most = 8;
  if (c == std::round(c) && c >= 1 && c <= most)
    return whole_power_difference(a, static_cast<int>(c));
  if (c == std::round(c) && c <= -1 && c >= -most)
    return quotient_difference(Expr(1.0), pow(a, Expr(-c)));
  // a^c - a'^c = 2 (a a')^(c/2) sinh(c (log a - log a')/2)
  return Expr(2.0) * pow(a, Expr(0.5 * c)) * pow(at_source(a), Expr(0.5 * c)) *
         Expr::make(Op::sinh, {Expr(0.5 * c) * logarithm_difference(a)});
}

/// f(t) - f(t - lag).
Expr difference(const Expr& f) {
  if (!f.depends_on(slot::t)) return 0.0;
  const auto args = f.args();
  switch (f.op()) {
  case Op::slot:
    return Expr::variable(slot::lag);
  case Op::neg:
    return -difference(args[0]);
  case Op::add:
    return difference(args[0]) + difference(args[1]);
  case Op::mul:
    return product_difference(args[0], args[1]);
  case Op::div:
    return quotient_difference(args[0], args[1]);
  case Op::pow:
    return power_difference(args[0], args[1], f);
  case Op::sqrt:
    return difference(args[0]) / (f + at_source(f));
  case Op::exp:
    return exponential_difference(args[0]);
  case Op::log:
    return logarithm_difference(args[0]);
  default:
    return f - at_source(f);
  }
}

/// Pairs f(t), -f(s) among the addends. An affine f is combined by the sum itself.
std::optional<Expr> rewritten_sum(const Expr& e) {
  auto terms = addends(e);
  bool changed = false;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (!terms[i].depends_on(slot::t) || terms[i].depends_on(slot::lag)) continue;
    const Expr there = at_source(terms[i]);
    for (std::size_t j = 0; j < terms.size(); ++j) {
      if (j == i || !(terms[j] == -there || -terms[j] == there)) continue;
      terms[i] = difference(terms[i]);
      terms[j] = 0.0;
      changed = true;
      break;
    }
  }
  if (!changed) return std::nullopt;
  return sum_of(terms);
}

/// log(f(t) / f(s)).
std::optional<Expr> rewritten_logarithm(const Expr& e) {
  const Expr& ratio = e.args()[0];
  if (ratio.op() != Op::div) return std::nullopt;
  const Expr &a = ratio.args()[0], &b = ratio.args()[1];
  if (!a.depends_on(slot::lag) && at_source(a) == b) return logarithm_difference(a);
  if (!b.depends_on(slot::lag) && at_source(b) == a) return -logarithm_difference(b);
  return std::nullopt;
}

} // namespace

Expr without_cancellation(const Expr& kernel) {
  return transform(kernel, [](const Expr& e) {
    std::optional<Expr> better;
    if (e.op() == Op::add) better = rewritten_sum(e);
    if (e.op() == Op::log) better = rewritten_logarithm(e);
    return better ? *better : e;
  });
}

} // namespace hvi::solver
