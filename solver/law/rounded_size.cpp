// See rounded_size.hpp.
#include "solver/law/rounded_size.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// A value and the size of what it was made of: its rounding is that size times a few units in the
/// last place.
struct Rounded {
  double value = 0.0, size = 0.0;
};

/// f(a) with the derivative d there. An a that is rounding is 0 (the end of a root), and exact.
Rounded through(double value, double d, const Rounded& a) {
  const bool exact = std::abs(a.value) <= 1e-14 * a.size;
  return {value, std::max(std::abs(value), exact ? 0.0 : std::abs(d) * a.size)};
}

/// By the rules for sums, products and the usual functions.
class RoundingOf {
public:
  RoundingOf(double r, const Point& x, const LawTime& t) : r_(r), x_(x), t_(t) {}

  Rounded operator()(const Expr& e) const {
    const auto args = e.args();
    switch (e.op()) {
    case Op::neg: {
      const Rounded a = (*this)(args[0]);
      return {-a.value, a.size};
    }
    case Op::add: {
      const Rounded a = (*this)(args[0]), b = (*this)(args[1]);
      return {a.value + b.value, a.size + b.size};
    }
    case Op::mul: {
      const Rounded a = (*this)(args[0]), b = (*this)(args[1]);
      return {a.value * b.value, a.size * std::abs(b.value) + std::abs(a.value) * b.size};
    }
    case Op::div: {
      const Rounded a = (*this)(args[0]), b = (*this)(args[1]);
      const double v = a.value / b.value;
      return {v, (a.size + std::abs(v) * b.size) / std::abs(b.value)};
    }
    case Op::pow: {
      if (!args[1].is_constant()) break;
      const Rounded a = (*this)(args[0]);
      const double v = std::pow(a.value, args[1].value());
      return through(v, v * args[1].value() / a.value, a);
    }
    case Op::exp: {
      const Rounded a = (*this)(args[0]);
      const double v = std::exp(a.value);
      return through(v, v, a);
    }
    case Op::log: {
      const Rounded a = (*this)(args[0]);
      return through(std::log(a.value), 1.0 / a.value, a);
    }
    case Op::sqrt: {
      const Rounded a = (*this)(args[0]);
      const double v = std::sqrt(a.value);
      return through(v, 0.5 / v, a);
    }
    default:
      break;
    }
    const double v =
        evaluate(e, [&](Slot s) { return s == slot::argument(0) ? r_ : t_.value(s, x_); });
    return {v, std::abs(v)};
  }

private:
  double r_;
  const Point& x_;
  const LawTime& t_;
};

} // namespace

double size_of_rounded(const Expr& e, double r, const Point& x, const LawTime& t) {
  return RoundingOf(r, x, t)(e).size;
}

} // namespace hvi::solver
