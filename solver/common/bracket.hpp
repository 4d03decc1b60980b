// A number of the theory with what is known about it: proved, proved between two bounds, or
// sampled.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace hvi::solver {

/// How a number was found.
enum class Provenance {
  proved,  ///< its two bounds agree to `proved_digits`: closed form, or an enclosure that is tight
  between, ///< it lies between two finite bounds, by proof
  sampled  ///< the largest that was seen: nothing is known above it
};
/// As the reports say it; the bounds follow "proved between".
constexpr std::string_view word(Provenance p) {
  return p == Provenance::proved    ? "proved"
         : p == Provenance::between ? "proved between"
                                    : "sampled";
}

/// A number that lies in [low, high]. `low` was seen: the number is not smaller. `high` is a bound
/// by proof; infinite beside a finite `low`: there is no such bound. A number that is infinite by
/// proof has two infinite ends.
struct Bracket {
  double low = 0.0, high = 0.0;

  static Bracket exactly(double value) { return {value, value}; }
  static Bracket at_least(double seen) { return {seen, std::numeric_limits<double>::infinity()}; }

  static constexpr double proved_digits = 1e-6; ///< relative
  Provenance how() const {
    if (low == high) return Provenance::proved;
    if (!std::isfinite(high)) return Provenance::sampled;
    const double size = std::max(std::abs(low), std::abs(high));
    return high - low <= proved_digits * size ? Provenance::proved : Provenance::between;
  }
  /// A conclusion from an upper bound of the number stands on a proof.
  bool bounded_by_proof() const { return how() != Provenance::sampled; }
  /// The value to compute with: the proved upper bound, else the largest that was seen.
  double value() const { return how() == Provenance::sampled ? low : high; }
};

/// Of the larger of two numbers, and of the sum.
inline Bracket larger(const Bracket& a, const Bracket& b) {
  return {std::max(a.low, b.low), std::max(a.high, b.high)};
}
inline Bracket operator+(const Bracket& a, const Bracket& b) {
  return {a.low + b.low, a.high + b.high};
}

} // namespace hvi::solver
