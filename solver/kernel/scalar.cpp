// Values of operations on numbers (scalar.hpp).
#include "solver/kernel/scalar.hpp"

#include <stdexcept>

namespace hvi::solver {

double apply(Op op, double a, double b, double c) {
  switch (op) {
  case Op::add:
    return a + b;
  case Op::mul:
    return a * b;
  case Op::div:
    return a / b;
  case Op::neg:
    return -a;
  case Op::pow:
    return scalar_power(a, b);
  case Op::min:
    return scalar_min(a, b);
  case Op::max:
    return scalar_max(a, b);
  case Op::abs:
    return std::abs(a);
  case Op::sign:
    return scalar_sign(a);
  case Op::exp:
    return std::exp(a);
  case Op::log:
    return std::log(a);
  case Op::sqrt:
    return std::sqrt(a);
  case Op::sin:
    return std::sin(a);
  case Op::cos:
    return std::cos(a);
  case Op::tan:
    return std::tan(a);
  case Op::asin:
    return std::asin(a);
  case Op::acos:
    return std::acos(a);
  case Op::atan:
    return std::atan(a);
  case Op::atan2:
    return std::atan2(a, b);
  case Op::sinh:
    return std::sinh(a);
  case Op::cosh:
    return std::cosh(a);
  case Op::tanh:
    return std::tanh(a);
  case Op::erf:
    return std::erf(a);
  case Op::erfc:
    return std::erfc(a);
  case Op::gamma:
    return std::tgamma(a);
  case Op::bessel_j:
    return bessel_j(a, b);
  case Op::erfcx:
    return erfcx(a, b);
  case Op::mittag_leffler:
    return mittag_leffler(a, b, c);
  case Op::less:
    return scalar_less(a, b);
  case Op::less_equal:
    return scalar_less_equal(a, b);
  case Op::equal:
    return scalar_equal(a, b);
  case Op::logic_and:
    return scalar_and(a, b);
  case Op::logic_or:
    return scalar_or(a, b);
  case Op::logic_not:
    return scalar_not(a);
  case Op::select:
    return scalar_select(a, b, c);
  case Op::polygamma:
    return polygamma(a, b);
  case Op::constant:
  case Op::slot:
  case Op::table:
  case Op::table_slope:
    break;
  }
  throw std::logic_error("apply: this operation is not a function of numbers alone");
}

} // namespace hvi::solver
