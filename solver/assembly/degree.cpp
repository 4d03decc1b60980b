// Polynomial degrees of expressions.
#include "solver/assembly/degree.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// Rules have no higher degree: what they leave of a polynomial beyond it is small.
constexpr int largest_degree = 30;
/// A power beyond is as good as no polynomial.
constexpr int largest_power = 1000;

int slot_degree(Slot slot, int order) {
  if (slot <= slot::x(2)) {
    return 1;
  }
  return slot::is_field(slot) ? shape_degree(slot::derivative_of(slot), order) : 0;
}

/// base^exponent for a constant whole exponent.
std::optional<int> power_degree(const Expr& expression, int base) {
  if (base == 0 && expression.args()[1].is_constant()) {
    return 0;
  }
  if (!expression.args()[1].is_constant()) {
    return std::nullopt;
  }
  const double exponent = expression.args()[1].value();
  if (exponent < 0 || exponent > largest_power || exponent != std::floor(exponent)) {
    return std::nullopt;
  }
  return base * static_cast<int>(exponent);
}

} // namespace

int shape_degree(int derivative_index, int order) {
  return slot::is_value(derivative_index) ? order : order - 1;
}

std::optional<int> polynomial_degree(const Expr& expression, int order) {
  if (expression.op() == Op::constant) {
    return 0;
  }
  if (expression.op() == Op::slot) {
    return slot_degree(expression.slot(), order);
  }
  std::vector<int> degrees;
  for (const Expr& arg : expression.args()) {
    const auto degree = polynomial_degree(arg, order);
    if (!degree) {
      return std::nullopt;
    }
    degrees.push_back(*degree);
  }
  const int largest = *std::max_element(degrees.begin(), degrees.end());
  // Any function of what is constant on an entity is constant on it.
  if (largest == 0) {
    return 0;
  }
  switch (expression.op()) {
  case Op::add:
    return largest;
  case Op::neg:
    return largest;
  case Op::mul:
    return degrees[0] + degrees[1];
  case Op::div:
    return degrees[1] == 0 ? std::optional(degrees[0]) : std::nullopt;
  case Op::pow:
    return degrees[1] == 0 ? power_degree(expression, degrees[0]) : std::nullopt;
  case Op::select:
    return degrees[0] == 0 ? std::optional(std::max(degrees[1], degrees[2])) : std::nullopt;
  default:
    return std::nullopt;
  }
}

int exact_degree(const Expr& coefficient, int shapes, int order) {
  const auto degree = polynomial_degree(coefficient, order);
  return degree ? std::min(*degree + shapes, largest_degree) : 2 * (order + 1);
}

} // namespace hvi::solver
