// Sets that are symmetric about the real line, through a tape; see strip.hpp.
#include "solver/history/strip_functions.hpp"
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hvi::solver {

namespace strips {
namespace {

// Which case holds on the whole panel: 1, 0, or the answer is left to smaller panels.

Strip truth(bool yes, bool no) {
  return yes ? Strip::exactly(1) : no ? Strip::exactly(0) : nothing(State::singular);
}

Strip compare(Op op, const Strip& a, const Strip& b) {
  if (op == Op::less) return truth(a.real_high < b.real_low, a.real_low >= b.real_high);
  if (op == Op::less_equal) return truth(a.real_high <= b.real_low, a.real_low > b.real_high);
  const bool apart = a.real_high < b.real_low || a.real_low > b.real_high;
  return truth(is_number(a) && is_number(b) && a.low == b.low, apart);
}

Strip smaller(const Strip& a, const Strip& b) {
  if (a.real_high <= b.real_low) return a;
  return b.real_high <= a.real_low ? b : nothing(State::singular);
}

Strip absolute(const Strip& z) {
  if (z.real_low >= 0) return z;
  return z.real_high <= 0 ? negate(z) : nothing(State::singular);
}

Strip sign(const Strip& z) {
  if (z.real_low > 0) return Strip::exactly(1);
  return z.real_high < 0 ? Strip::exactly(-1) : nothing(State::singular);
}

Strip logic(Op op, const Strip& a, const Strip& b) {
  if (op == Op::logic_not) return Strip::exactly(scalar_not(a.low));
  return Strip::exactly(op == Op::logic_and ? scalar_and(a.low, b.low) : scalar_or(a.low, b.low));
}

Strip unary(Op op, const Strip& z) {
  switch (op) {
  case Op::neg:
    return negate(z);
  case Op::abs:
    return absolute(z);
  case Op::sign:
    return sign(z);
  case Op::exp:
    return exponential(z);
  case Op::log:
    return logarithm(z);
  case Op::sqrt:
    return z.low > 0 ? right_power(z, 0.5) : nothing(State::singular);
  case Op::sin:
    return sine(z);
  case Op::cos:
    return cosine(z);
  case Op::tan:
    return multiply(sine(z), reciprocal(cosine(z)));
  case Op::asin:
    return arcsine(z);
  case Op::acos:
    return add(Strip::exactly(std::numbers::pi / 2), negate(arcsine(z)));
  case Op::atan:
    return arctangent(z);
  case Op::sinh:
  case Op::cosh:
    return hyperbolic(z, op == Op::cosh);
  case Op::tanh:
    return tangent_hyperbolic(z);
  case Op::erf:
    return error_function(z);
  case Op::erfc:
    return error_left(z);
  default:
    return nothing(State::unknown);
  }
}

Strip binary(Op op, const Strip& a, const Strip& b) {
  switch (op) {
  case Op::add:
    return add(a, b);
  case Op::mul:
    return multiply(a, b);
  case Op::div:
    return multiply(a, reciprocal(b));
  case Op::pow:
    return power(a, b);
  case Op::min:
    return smaller(a, b);
  case Op::max:
    return negate(smaller(negate(a), negate(b)));
  case Op::less:
  case Op::less_equal:
  case Op::equal:
    return compare(op, a, b);
  case Op::logic_and:
  case Op::logic_or:
    return logic(op, a, b);
  case Op::bessel_j:
    return bessel(a, b);
  case Op::erfcx:
    return scaled_error(a, b);
  default:
    return nothing(State::unknown);
  }
}

/// The state of an operation's arguments, as far as it reads them: a case that is not taken, a
/// factor that stands behind it, may be anything.
Strip run(const Tape& tape, const Instruction& i, std::span<const Strip> inputs,
          std::span<const Strip> r) {
  const auto at = [&](std::int32_t k) -> const Strip& { return r[static_cast<std::size_t>(k)]; };
  if (i.op == Op::constant) return Strip::exactly(i.value);
  if (i.op == Op::slot) return inputs[static_cast<std::size_t>(i.a)];
  if (i.op == Op::select) {
    const Strip& c = at(i.a);
    if (c.state != State::analytic) return nothing(c.state);
    return c.low != 0 ? at(i.b) : at(i.c);
  }
  const Strip& a = at(i.a);
  if (a.state != State::analytic) return nothing(a.state);
  if (i.op == Op::table || i.op == Op::table_slope)
    return tabulated(*tape.tables[static_cast<std::size_t>(i.c)], a, i.op == Op::table_slope);
  if (i.b < 0) return i.op == Op::logic_not ? logic(i.op, a, a) : unary(i.op, a);
  const Strip& b = at(i.b);
  if (b.state != State::analytic) return nothing(b.state);
  if (i.op == Op::mittag_leffler) {
    const Strip& z = at(i.c);
    return z.state == State::analytic ? mittag_leffler(a, b, z) : nothing(z.state);
  }
  return binary(i.op, a, b);
}

} // namespace
} // namespace strips

Strip around(double low, double high) {
  const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
  const double real = 0.5 * (ellipse + 1 / ellipse), imaginary = 0.5 * (ellipse - 1 / ellipse);
  // A kink at an end of the panel, which is known to rounding only, does not lie within it.
  const double inner = half - std::min(0.5 * half, 4e-15 * (std::abs(low) + std::abs(high)));
  return {middle - real * half, middle + real * half, imaginary * half,
          middle - inner,       middle + inner,       Strip::State::analytic};
}

Strip difference(double t, const Strip& z) {
  return strips::add(Strip::exactly(t), strips::negate(z));
}

Strip raised(const Strip& z, double c) {
  return strips::checked(strips::power(z, Strip::exactly(c)));
}

Strip scaled(double c, const Strip& z) { return strips::multiply(Strip::exactly(c), z); }

Strip enclose(const Tape& tape, std::span<const Strip> inputs, std::vector<Strip>& registers) {
  registers.resize(tape.code.size());
  for (std::size_t k = 0; k < tape.code.size(); ++k)
    registers[k] = strips::checked(strips::run(tape, tape.code[k], inputs, registers));
  return registers[static_cast<std::size_t>(tape.outputs[0])];
}

} // namespace hvi::solver
