// Dimensions and their inference.
#include "lang/units/dimension.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace hvi::lang::units {

Rational::Rational(std::int64_t above, std::int64_t below) {
  const std::int64_t common = std::gcd(above, below) * (below < 0 ? -1 : 1);
  above_ = above / common;
  below_ = below / common;
  constexpr std::int64_t most = 1'000'000;
  if (std::abs(above_) <= most && below_ <= most) return;
  const double rounded = std::clamp(value(), -1e3, 1e3);
  *this = Rational(std::llround(1000 * rounded), 1000);
}

Rational operator+(const Rational& a, const Rational& b) {
  return {a.above_ * b.below_ + b.above_ * a.below_, a.below_ * b.below_};
}

Rational operator*(const Rational& a, const Rational& b) {
  return {a.above_ * b.above_, a.below_ * b.below_};
}

Rational operator/(const Rational& a, const Rational& b) {
  return {a.above_ * b.below_, a.below_ * b.above_};
}

std::optional<Rational> rational_near(double value) {
  constexpr std::int64_t most = 1000;
  if (!(std::abs(value) <= static_cast<double>(most))) return std::nullopt;
  for (std::int64_t below = 1; below <= most; ++below) {
    const double above = value * static_cast<double>(below);
    if (std::abs(above - std::round(above)) <= 1e-12 * std::max(1.0, std::abs(above)))
      return Rational(static_cast<std::int64_t>(std::round(above)), below);
  }
  return std::nullopt;
}

Dimension Dimension::base(int which) {
  Dimension out;
  out.powers_[static_cast<std::size_t>(which)] = 1;
  return out;
}

Dimension Dimension::unknown(int which) {
  Dimension out;
  out.unknown_[which] = 1;
  return out;
}

Dimension operator*(const Dimension& a, const Dimension& b) {
  Dimension out = a;
  for (std::size_t i = 0; i < n_base; ++i) out.powers_[i] = a.powers_[i] + b.powers_[i];
  for (const auto& [which, power] : b.unknown_) {
    Rational& sum = out.unknown_[which];
    sum = sum + power;
    if (sum.is_zero()) out.unknown_.erase(which);
  }
  return out;
}

Dimension Dimension::to(const Rational& power) const {
  Dimension out;
  if (power.is_zero()) return out;
  for (std::size_t i = 0; i < n_base; ++i) out.powers_[i] = powers_[i] * power;
  for (const auto& [which, own] : unknown_) out.unknown_[which] = own * power;
  return out;
}

Dimension Inference::resolved(const Dimension& d) const {
  Dimension out{d.powers()};
  for (const auto& [which, power] : d.unknowns()) {
    const auto found = known_.find(which);
    out = out * (found == known_.end() ? Dimension::unknown(which) : found->second).to(power);
  }
  return out;
}

bool Inference::unify(const Dimension& a, const Dimension& b) {
  const Dimension ratio = resolved(a / b);
  if (ratio.is_known()) return ratio.is_one();
  const auto [which, power] = *ratio.unknowns().rbegin(); // the newest: old names last longer
  const Dimension value = Dimension::unknown(which) / ratio.to(Rational(1) / power);
  for (auto& [other, of] : known_) {
    const auto found = of.unknowns().find(which);
    if (found == of.unknowns().end()) continue;
    const Rational times = found->second;
    of = of / Dimension::unknown(which).to(times) * value.to(times);
  }
  known_.emplace(which, value);
  return true;
}

} // namespace hvi::lang::units
