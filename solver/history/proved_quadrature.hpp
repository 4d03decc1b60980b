// Quadrature with a proof that its panels resolve the integrand: they are halved until it is
// analytic and small enough around each of them for the rule's error to be rounding.
//
// K. Petras, Self-validating integration and approximation of piecewise analytic functions, J.
// Comput. Appl. Math. 145 (2002) 345-359; F. Johansson, Numerical integration in
// arbitrary-precision ball arithmetic, Mathematical Software - ICMS 2018. A peak of any width is
// found: around a panel that hides it the bound is large.
#pragma once

#include "solver/history/quadrature.hpp"
#include "solver/history/strip.hpp"

namespace hvi::solver {

/// The largest error of the 31-point rule for |f| <= 1 on the ellipse, relative to the length of
/// the panel: it integrates polynomials of degree 46 exactly and its weights are positive.
inline double rule_error() {
  static const double error = 4 * std::pow(ellipse, -46) / (ellipse - 1);
  return error;
}

/// Integrals with what could not be resolved.
template <std::size_t M>
struct Proved {
  Values<M> integral{}, size{}; ///< int f, int |f|
  bool proved = true;           ///< false: an operation has no bound, two rules were compared
  double unresolved = 0.0;      ///< int |f| over panels that could not be halved further
  double at = 0.0;              ///< where most of it lies
};

/// int_a^b f(x) dx, 0 <= a or b <= 0. `modulus(low, high)` bounds f around a panel. The first
/// component is the one that is bounded; the others must not exceed it by much. Panels at a jump
/// end when they are as short as rounding, at a singularity at 0 when they hold nothing: what they
/// hold is `unresolved`. `scale`: a size of which rounding does not matter.
template <std::size_t M, class F, class B>
Proved<M> integrate_proved(const F& f, const B& modulus, double a, double b, double scale = 0.0,
                           std::size_t limit = 30000) {
  struct Open {
    double low, high;
  };
  constexpr double share = 2e-15, least = 1e-290;
  Proved<M> out;
  double worst = 0.0;
  std::size_t panels = 0;
  std::vector<Open> open{{a, b}};
  while (!open.empty()) {
    const double low = open.back().low, high = open.back().high;
    open.pop_back();
    const double length = high - low, middle = 0.5 * (low + high);
    const Modulus most = modulus(low, high);
    if (most.state == Strip::State::unknown) return {.proved = false};
    const bool analytic = most.state == Strip::State::analytic;
    const bool can_halve =
        length > 1e-15 * std::max(std::abs(low), std::abs(high)) + least && panels < limit;
    const auto halve = [&] {
      ++panels;
      open.push_back(low == 0.0 ? Open{low, middle} : Open{middle, high});
      open.push_back(low == 0.0 ? Open{middle, high} : Open{low, middle}); // the end at 0 last
    };
    const bool at_zero = low == 0.0 || high == 0.0;
    if (!analytic && can_halve && !at_zero) {
      halve();
      continue;
    }
    const auto panel = detail::gauss_kronrod_panel<M>(f, low, high, {});
    const double known = std::max({scale, out.size[0], panel.magnitude[0]});
    const bool good =
        analytic && rule_error() * most.most * length <= share * known + least * length;
    // Beside a singularity at 0: as short as this panel is, the rest is a small multiple of it.
    const bool empty =
        at_zero && length <= 1e-14 * (b - a) && panel.magnitude[0] <= 0.1 * share * known;
    if (!good && !empty && can_halve) {
      halve();
      continue;
    }
    if (!good && !empty) {
      out.unresolved += panel.magnitude[0];
      if (!(panel.magnitude[0] <= worst)) worst = panel.magnitude[0], out.at = middle;
    }
    for (std::size_t m = 0; m < M; ++m) {
      out.integral[m] += panel.integral[m];
      out.size[m] += panel.magnitude[m];
    }
  }
  return out;
}

/// The same where nothing bounds f: two rules compared on panels that grow fourfold from 0, so that
/// a layer at 0 is seen. Features in between that are narrower than a panel may be missed.
template <std::size_t M, class F>
Values<M> integrate_graded(const F& f, double a, double b, Values<M> scale = {}) {
  constexpr int levels = 26; // 4^-26 is rounding
  Values<M> sum{};
  const auto add = [&](double low, double high) {
    const auto part = integrate_smooth<M>(f, low, high, scale);
    for (std::size_t m = 0; m < M; ++m) sum[m] += part[m];
  };
  double high = b;
  for (int level = 0; level < levels && high > 4 * a; ++level, high /= 4) add(high / 4, high);
  add(a, high);
  return sum;
}

} // namespace hvi::solver
