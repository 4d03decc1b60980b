// Adaptive Gauss-Kronrod quadrature of several integrands at once, to machine precision. The rules
// and the bisection are those of R. Piessens, E. de Doncker-Kapenga, C. W. Ueberhuber,
// D. K. Kahaner, QUADPACK: a subroutine package for automatic integration, 1983.
#pragma once

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace hvi::solver {

/// Values of M integrals.
template <std::size_t M>
using Values = std::array<double, M>;

namespace detail {

template <std::size_t M>
struct Panel {
  Values<M> integral{}, magnitude{};
  bool smooth = true;    ///< Gauss and Kronrod agree to the accuracy asked for
  double difference = 0; ///< of the two, relative to the magnitude
};

/// One 31-point panel. |K31 - G15| is the error of G15; that of K31 is far below it, so that
/// agreement to 2e-12 stands for rounding error of K31 (QUADPACK takes (200 |K - G|)^1.5).
template <std::size_t M, class F>
Panel<M> gauss_kronrod_panel(const F& f, double a, double b, const Values<M>& scale) {
  using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;
  using Gauss = boost::math::quadrature::gauss<double, 15>;
  const auto& nodes = Rule::abscissa();
  const double half = 0.5 * (b - a), middle = 0.5 * (a + b);
  constexpr double least = 1e-290; // below it numbers lose digits: exp(-lag) at large lags
  Panel<M> panel;
  Values<M> gauss{};
  const auto add = [&](double x, std::size_t i) {
    const Values<M> value = f(x);
    for (std::size_t m = 0; m < M; ++m) {
      panel.integral[m] += Rule::weights()[i] * value[m] * half;
      panel.magnitude[m] += Rule::weights()[i] * std::abs(value[m]) * half;
      if (i % 2 == 0) gauss[m] += Gauss::weights()[i / 2] * value[m] * half;
    }
  };
  add(middle, 0);
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    add(middle - half * nodes[i], i);
    add(middle + half * nodes[i], i);
  }
  for (std::size_t m = 0; m < M; ++m) {
    const double bound = 2e-12 * panel.magnitude[m] + 1e-16 * scale[m] + least * (b - a);
    const double off = std::abs(panel.integral[m] - gauss[m]);
    if (off > bound) panel.smooth = false;
    if (panel.magnitude[m] > 0)
      panel.difference = std::max(panel.difference, off / panel.magnitude[m]);
  }
  return panel;
}

} // namespace detail

/// int_a^b f(x) dx, f: double -> Values<M>. Bisects where the two rules differ, at most `limit`
/// panels. A difference that is small and does not shrink with its panel is the rounding of f (a
/// cosine of a large argument) and is left. A value that is not finite, and panels that do not
/// suffice, show in the result (NaN). `scale`: sizes of which 1e-16 does not matter.
template <std::size_t M, class F>
Values<M> integrate_smooth(const F& f, double a, double b, Values<M> scale = {},
                           std::size_t limit = 30000) {
  struct Open {
    double low, high, difference; ///< of the rules on the panel it is half of, relative
  };
  constexpr double small = 1e-9, unresolved = 1e-6;
  Values<M> result{}, size{}, open_error{};
  std::vector<Open> open{{a, b, 1.0}};
  const double narrow = 1e-14 * std::max(std::abs(a), std::abs(b));
  std::size_t panels = 0;
  while (!open.empty()) {
    const auto [low, high, before] = open.back();
    open.pop_back();
    const auto panel = detail::gauss_kronrod_panel<M>(f, low, high, scale);
    for (std::size_t m = 0; m < M; ++m) scale[m] = std::max(scale[m], panel.magnitude[m]);
    const bool noise = panel.difference <= small && panel.difference > 0.5 * before;
    const bool refine = !panel.smooth && !noise && high - low > narrow;
    if (refine && ++panels < limit) {
      open.push_back({0.5 * (low + high), high, panel.difference});
      open.push_back({low, 0.5 * (low + high), panel.difference});
      continue;
    }
    for (std::size_t m = 0; m < M; ++m) {
      result[m] += panel.integral[m];
      size[m] += panel.magnitude[m];
      if (refine) open_error[m] += panel.difference * panel.magnitude[m];
    }
  }
  for (std::size_t m = 0; m < M; ++m) // never an answer that was not resolved
    if (open_error[m] > unresolved * size[m]) result[m] = std::numeric_limits<double>::quiet_NaN();
  return result;
}

} // namespace hvi::solver
