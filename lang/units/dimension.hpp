// Dimensions: products of rational powers of the seven base quantities of the SI, and of quantities
// that are not known yet. They form a vector space over the rationals, so that "these two are
// equal" is a linear equation and inference is elimination. The same for integer powers, where
// dimensions are an abelian group: A. J. Kennedy, Programming languages and dimensions, Technical
// report 391, University of Cambridge, 1996, after which F# made its units of measure.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang::units {

/// A power. Always in lowest terms, the denominator positive. Beyond a million it is rounded to
/// thousandths: no quantity has such a power.
class Rational {
public:
  constexpr Rational() = default;
  constexpr Rational(int whole) : above_(whole) {} // NOLINT: a whole number is a rational one
  Rational(std::int64_t above, std::int64_t below);

  [[nodiscard]] std::int64_t above() const { return above_; }
  [[nodiscard]] std::int64_t below() const { return below_; }
  [[nodiscard]] bool is_zero() const { return above_ == 0; }
  [[nodiscard]] double value() const {
    return static_cast<double>(above_) / static_cast<double>(below_);
  }
  friend Rational operator+(const Rational& a, const Rational& b);
  friend Rational operator-(const Rational& a) { return {-a.above_, a.below_}; }
  friend Rational operator-(const Rational& a, const Rational& b) { return a + (-b); }
  friend Rational operator*(const Rational& a, const Rational& b);
  friend Rational operator/(const Rational& a, const Rational& b);
  friend bool operator==(const Rational&, const Rational&) = default;

private:
  std::int64_t above_ = 0, below_ = 1;
};

/// The fraction with a denominator of at most 1000 that a number is to rounding; none: it is no
/// such.
std::optional<Rational> rational_near(double value);

inline constexpr int n_base = 7;

/// m, kg, s, K, A, mol, cd.
using Powers = std::array<Rational, n_base>;

/// A dimension, with unknown ones in it while it is inferred.
class Dimension {
public:
  Dimension() = default; ///< 1: no dimension
  explicit Dimension(const Powers& powers) : powers_(powers) {}
  static Dimension base(int which);
  static Dimension unknown(int which);

  [[nodiscard]] const Powers& powers() const { return powers_; }
  [[nodiscard]] bool is_known() const { return unknown_.empty(); }
  [[nodiscard]] bool is_one() const { return *this == Dimension{}; }
  /// The unknown ones in it, with their powers.
  [[nodiscard]] const std::map<int, Rational>& unknowns() const { return unknown_; }

  friend Dimension operator*(const Dimension& a, const Dimension& b);
  friend Dimension operator/(const Dimension& a, const Dimension& b) { return a * b.to(-1); }
  [[nodiscard]] Dimension to(const Rational& power) const;
  friend bool operator==(const Dimension&, const Dimension&) = default;

private:
  Powers powers_{};
  std::map<int, Rational> unknown_; ///< without zeros
};

/// Unknown dimensions and what is known of them.
class Inference {
public:
  Dimension fresh() { return Dimension::unknown(n_unknown_++); }
  /// With all that is known put in.
  [[nodiscard]] Dimension resolved(const Dimension& d) const;
  /// Makes a and b equal; false where that cannot be, and then nothing has changed.
  bool unify(const Dimension& a, const Dimension& b);
  /// Knows what it knew then; unknowns made since stay others than those to come.
  void forget_since(const Inference& then) { known_ = then.known_; }

private:
  int n_unknown_ = 0;
  std::map<int, Dimension> known_; ///< solved for: no solved one stands in any of them
};

} // namespace hvi::lang::units
