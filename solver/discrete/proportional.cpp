// Which forms are multiples of one another; used by operators.cpp.
#include "solver/discrete/proportional.hpp"

#include "solver/linear/same_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace hvi::solver {
namespace {

// Coefficients of one tensor go through different roundings (c * lambda + 2 * c * mu).
constexpr double rounding = 1e-14;

/// Collects the ratio of pairs of numbers as long as it is one and the same.
class Ratio {
public:
  bool add(double a, double b, double scale_a, double scale_b) {
    if (std::abs(b) <= rounding * scale_b) return std::abs(a) <= rounding * scale_a;
    if (!value_) value_ = a / b;
    return std::abs(a - *value_ * b) <= rounding * std::max(std::abs(a), std::abs(*value_ * b));
  }
  std::optional<double> value() const { return value_; }

private:
  std::optional<double> value_;
};

/// Splits the constant factor off a product.
std::pair<double, Expr> split(const Expr& e) {
  if (e.is_constant()) return {e.value(), Expr(1.0)};
  if (e.op() == Op::neg) {
    const auto [c, rest] = split(e.args()[0]);
    return {-c, rest};
  }
  if (e.op() == Op::mul) {
    const auto [c, left] = split(e.args()[0]);
    const auto [d, right] = split(e.args()[1]);
    return {c * d, left * right};
  }
  return {1.0, e};
}

/// c, where both were written with one tensor and factors that differ by the constant c.
std::optional<double> written_ratio(const FormTerm& a, const FormTerm& b) {
  if (!a.tensor || !b.tensor || a.tensor->index != b.tensor->index ||
      a.tensor->unknown != b.tensor->unknown)
    return std::nullopt;
  const auto [c, rest_a] = split(a.tensor->factor);
  const auto [d, rest_b] = split(b.tensor->factor);
  return rest_a == rest_b && d != 0.0 ? std::optional(c / d) : std::nullopt;
}

std::vector<FormTerm::Entry> sorted_entries(const FormTerm& term) {
  std::vector<FormTerm::Entry> out;
  for (const auto& entry : term.entries)
    if (!entry.coefficient.is(0.0)) out.push_back(entry);
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
    return std::pair(a.test, a.trial) < std::pair(b.test, b.trial);
  });
  return out;
}

/// The largest pair is compared first: the ratio is taken where it is best known.
std::optional<double> ratio_of(std::span<const double> a, std::span<const double> b) {
  double scale_a = 0, scale_b = 0;
  std::size_t largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    scale_a = std::max(scale_a, std::abs(a[i]));
    if (std::abs(b[i]) > scale_b) largest = i;
    scale_b = std::max(scale_b, std::abs(b[i]));
  }
  if (scale_a == 0 || scale_b == 0) return std::nullopt;
  const double ratio = a[largest] / b[largest];
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(a[i] - ratio * b[i]) > rounding * scale_a) return std::nullopt;
  return ratio;
}

} // namespace

std::optional<double> symbolic_ratio(const FormTerm& a, const FormTerm& b) {
  if (a.part != b.part || a.rule != b.rule) return std::nullopt;
  if (const auto written = written_ratio(a, b)) return written;
  const auto entries_a = sorted_entries(a), entries_b = sorted_entries(b);
  if (entries_a.size() != entries_b.size() || entries_a.empty()) return std::nullopt;
  Ratio ratio;
  for (std::size_t e = 0; e < entries_a.size(); ++e) {
    if (entries_a[e].test != entries_b[e].test || entries_a[e].trial != entries_b[e].trial)
      return std::nullopt;
    const auto [factor_a, rest_a] = split(entries_a[e].coefficient);
    const auto [factor_b, rest_b] = split(entries_b[e].coefficient);
    if (!(rest_a == rest_b) || !ratio.add(factor_a, factor_b, 0.0, 0.0)) return std::nullopt;
  }
  return ratio.value();
}

std::optional<double> numeric_ratio(const SparseMatrix& a, const SparseMatrix& b) {
  if (!same_pattern(a, b)) return std::nullopt;
  const auto n = static_cast<std::size_t>(a.nonZeros());
  return ratio_of({a.valuePtr(), n}, {b.valuePtr(), n});
}

std::optional<double> column_ratio(const Vector& a, const Vector& b) {
  return ratio_of({a.data(), static_cast<std::size_t>(a.size())},
                  {b.data(), static_cast<std::size_t>(b.size())});
}

} // namespace hvi::solver
