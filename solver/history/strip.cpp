// Arithmetic of sets that are symmetric about the real line; see strip.hpp.
//
// Ends are not rounded outwards: the bounds decide how a panel is cut, and a factor does not
// matter.
#include "solver/history/strip.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/scalar.hpp"
#include "solver/kernel/table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hvi::solver {

namespace {

using State = Strip::State;
constexpr double pi = std::numbers::pi;

struct Range {
  double low, high;
};

Range product(Range a, Range b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  return {std::min({p, q, r, s}), std::max({p, q, r, s})};
}

double largest(const Strip& z) { return std::max(std::abs(z.low), std::abs(z.high)); }
double least(const Strip& z) { return z.low > 0 ? z.low : z.high < 0 ? -z.high : 0.0; }

State worse(State a, State b) { return std::max(a, b); }

/// Nothing is known but that the function may not be analytic. A set that is not finite means the
/// same.
Strip nothing(State state) { return {-infinity, infinity, infinity, -infinity, infinity, state}; }

Strip checked(const Strip& z) {
  const bool finite = std::isfinite(z.low) && std::isfinite(z.high) && std::isfinite(z.imaginary) &&
                      std::isfinite(z.real_low) && std::isfinite(z.real_high);
  return finite ? z : nothing(worse(z.state, State::singular));
}

Strip add(const Strip& a, const Strip& b) {
  return {a.low + b.low,           a.high + b.high,           a.imaginary + b.imaginary,
          a.real_low + b.real_low, a.real_high + b.real_high, State::analytic};
}

Strip negate(const Strip& a) {
  return {-a.high, -a.low, a.imaginary, -a.real_high, -a.real_low, State::analytic};
}

Strip multiply(const Strip& a, const Strip& b) {
  const Range re = product({a.low, a.high}, {b.low, b.high});
  const Range on_line = product({a.real_low, a.real_high}, {b.real_low, b.real_high});
  const double im = a.imaginary * b.imaginary;
  return {re.low - im, re.high + im, largest(a) * b.imaginary + largest(b) * a.imaginary,
          on_line.low, on_line.high, State::analytic};
}

/// x / (x^2 + y^2) and y / (x^2 + y^2) for x > 0.
Strip reciprocal(const Strip& z) {
  if (z.high < 0) return negate(reciprocal(negate(z)));
  if (!(z.low > 0)) return nothing(State::singular);
  const double y = z.imaginary;
  const auto part = [&](double x) { return 1 / (x + y * (y / x)); };
  const double im = y <= z.low ? (y / z.low) * part(z.low) : 0.5 / z.low;
  return {std::min(part(z.low), part(z.high)),
          1 / z.low,
          im,
          1 / z.real_high,
          1 / z.real_low,
          State::analytic};
}

/// modulus in [r.low, r.high], |argument| <= angle.
Strip polar(Range r, double angle, Range on_line) {
  const double c = std::cos(std::min(angle, pi));
  return {c >= 0 ? r.low * c : r.high * c,
          r.high,
          r.high * (angle < pi / 2 ? std::sin(angle) : 1.0),
          on_line.low,
          on_line.high,
          State::analytic};
}

Range ordered(double a, double b) { return {std::min(a, b), std::max(a, b)}; }

/// z^c in the right half plane.
Strip right_power(const Strip& z, double c) {
  const Range modulus = ordered(std::pow(z.low, c), std::pow(std::hypot(z.high, z.imaginary), c));
  return polar(modulus, std::abs(c) * std::atan2(z.imaginary, z.low),
               ordered(std::pow(z.real_low, c), std::pow(z.real_high, c)));
}

Strip square(const Strip& z) {
  const double big = largest(z), small = least(z), y = z.imaginary;
  const double line = std::max(std::abs(z.real_low), std::abs(z.real_high));
  const double near = z.real_low > 0 ? z.real_low : z.real_high < 0 ? -z.real_high : 0.0;
  return {small * small - y * y, big * big, 2 * big * y, near * near, line * line, State::analytic};
}

Strip whole_power(const Strip& z, int n) {
  if (n < 0) return checked(reciprocal(whole_power(z, -n)));
  if (n == 0) return Strip::exactly(1);
  if (n == 1) return z;
  if (z.low > 0) return right_power(z, n);
  if (z.high < 0) {
    const Strip p = right_power(negate(z), n);
    return n % 2 == 0 ? p : negate(p);
  }
  const Strip half = whole_power(z, n / 2), even = square(half);
  return n % 2 == 0 ? even : multiply(even, z);
}

Strip exponential(const Strip& z) {
  const double small = std::exp(z.low), big = std::exp(z.high);
  return polar({small, big}, z.imaginary, {std::exp(z.real_low), std::exp(z.real_high)});
}

Strip logarithm(const Strip& z) {
  if (!(z.low > 0)) return nothing(State::singular);
  return {std::log(z.low),
          std::log(std::hypot(z.high, z.imaginary)),
          std::atan2(z.imaginary, z.low),
          std::log(z.real_low),
          std::log(z.real_high),
          State::analytic};
}

Strip power(const Strip& base, const Strip& exponent) {
  if (exponent.low == exponent.high && exponent.imaginary == 0) {
    const double c = exponent.low;
    if (is_multiplied_power(c)) return whole_power(base, static_cast<int>(c));
    return base.low > 0 ? right_power(base, c) : nothing(State::singular);
  }
  if (!(base.low > 0)) return nothing(State::singular);
  return exponential(multiply(exponent, logarithm(base)));
}

/// Range of cos over [a, b].
Range cosine(double a, double b) {
  if (!(b - a < 2 * pi)) return {-1, 1};
  Range r = ordered(std::cos(a), std::cos(b));
  if (std::floor(b / (2 * pi)) > std::floor(a / (2 * pi))) r.high = 1;
  if (std::floor((b - pi) / (2 * pi)) > std::floor((a - pi) / (2 * pi))) r.low = -1;
  return r;
}

/// cos(x + i y) = cos x cosh y - i sin x sinh y.
Strip cosine(const Strip& z) {
  const double grow = std::cosh(z.imaginary);
  const Range c = cosine(z.low, z.high), line = cosine(z.real_low, z.real_high);
  const Range re = product(c, {1, grow});
  return {re.low, re.high, std::sinh(z.imaginary), line.low, line.high, State::analytic};
}

Strip sine(const Strip& z) { return cosine(add(z, Strip::exactly(-pi / 2))); }

Strip hyperbolic(const Strip& z, bool even) {
  const Strip plus = exponential(z), minus = exponential(negate(z));
  return multiply(Strip::exactly(0.5), add(plus, even ? minus : negate(minus)));
}

/// f(c) + f'(Z) (Z - c) with c real: holds for each of the two parts.
template <class F>
Strip mean_value(const Strip& z, const Strip& slope, const F& f) {
  if (slope.state != State::analytic) return slope;
  const double c = 0.5 * (z.real_low + z.real_high);
  return add(Strip::exactly(f(c)), multiply(slope, add(z, Strip::exactly(-c))));
}

/// side + a disc of radius `off`.
Strip beside(double side, double off) {
  return {side - off, side + off, off, side - off, side + off, State::analytic};
}

/// tanh z = 1 - 2 / (exp(2 z) + 1).
Strip tangent_hyperbolic(const Strip& z) {
  const double decay = std::exp(-2 * least(z)), off = 2 * decay / (1 - decay);
  if (off < 0.5) return beside(z.low > 0 ? 1.0 : -1.0, off);
  if (!(z.imaginary < 1.5)) return nothing(State::singular);
  const Strip slope = reciprocal(square(hyperbolic(z, true)));
  return mean_value(z, slope, [](double x) { return std::tanh(x); });
}

Strip arctangent(const Strip& z) {
  const Strip slope = reciprocal(add(Strip::exactly(1), square(z)));
  return mean_value(z, slope, [](double x) { return std::atan(x); });
}

Strip error_function(const Strip& z) {
  // Where the real part is large erf is 1 - erfc, |erfc(z)| <= |exp(-z^2)| for Re z >= 0.
  const Strip gauss = exponential(negate(square(z)));
  if (least(z) > 0) {
    const double off = gauss.modulus(), side = z.low > 0 ? 1.0 : -1.0;
    if (off < 0.1) return beside(side, off);
  }
  const Strip slope = multiply(Strip::exactly(2 / std::sqrt(pi)), gauss);
  return mean_value(z, slope, [](double x) { return std::erf(x); });
}

Strip arcsine(const Strip& z) {
  const Strip inside = add(Strip::exactly(1), negate(square(z)));
  if (!(inside.low > 0)) return nothing(State::singular);
  return mean_value(z, right_power(inside, -0.5), [](double x) { return std::asin(x); });
}

Strip ball(double radius) { return {-radius, radius, radius, -radius, radius, State::analytic}; }

bool is_number(const Strip& z) { return z.low == z.high && z.imaginary == 0; }

/// E_{a,b}(-x) is completely monotone for 0 < a <= 1, b >= a, a mixture of exp(-x u), u >= 0
/// (W. R. Schneider's theorem; see T. Simon, Mittag-Leffler functions and complete
/// monotonicity, arXiv:1312.4513, 2013): |E(z)| <= E(Re z).
Strip mittag_leffler(const Strip& a, const Strip& b, const Strip& z) {
  if (!is_number(a) || !is_number(b)) return nothing(State::unknown);
  if (!(a.low > 0 && a.low <= 1 && b.low >= a.low)) return nothing(State::unknown);
  const auto value = [&](double x) { return hvi::solver::mittag_leffler(a.low, b.low, x); };
  Strip out = ball(value(z.high));
  out.real_low = value(z.real_low); // it increases with x
  out.real_high = value(z.real_high);
  return out;
}

/// |J_n(z)| <= exp(|Im z|) for whole n (from Bessel's integral).
Strip bessel(const Strip& order, const Strip& z) {
  if (!is_number(order) || order.low != std::round(order.low)) return nothing(State::unknown);
  Strip out = ball(std::exp(z.imaginary));
  const double middle = 0.5 * (z.real_low + z.real_high), half = z.real_high - middle;
  const double value = hvi::solver::bessel_j(order.low, middle); // its slope is at most 1
  out.real_low = value - half;
  out.real_high = value + half;
  return out;
}

/// Within one piece of the table a polynomial of degree at most 3: on the ellipse it exceeds its
/// largest value on the piece by less than ellipse^3.
Strip tabulated(const Table& table, const Strip& z, bool slope) {
  const auto& x = table.abscissae();
  const double low = std::max(z.real_low, x.front()), high = std::min(z.real_high, x.back());
  if (!(low <= high)) return nothing(State::singular);
  const double slack = 1e-13 * std::max(std::abs(x.front()), std::abs(x.back()));
  const auto next = std::upper_bound(x.begin(), x.end(), low + slack);
  if (next != x.end() && *next < high - slack) return nothing(State::singular);
  const auto [least_value, largest_value] = table.range(low, high, slope);
  Strip out = ball(16 * std::max(std::abs(least_value), std::abs(largest_value)));
  out.real_low = least_value;
  out.real_high = largest_value;
  return out;
}

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
    return add(Strip::exactly(pi / 2), negate(arcsine(z)));
  case Op::atan:
    return arctangent(z);
  case Op::sinh:
  case Op::cosh:
    return hyperbolic(z, op == Op::cosh);
  case Op::tanh:
    return tangent_hyperbolic(z);
  case Op::erf:
    return error_function(z);
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

double Strip::modulus() const {
  return state == State::analytic ? std::hypot(largest(*this), imaginary) : infinity;
}

Strip around(double low, double high) {
  const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
  const double real = 0.5 * (ellipse + 1 / ellipse), imaginary = 0.5 * (ellipse - 1 / ellipse);
  // A kink at an end of the panel, which is known to rounding only, does not lie within it.
  const double inner = half - std::min(0.5 * half, 4e-15 * (std::abs(low) + std::abs(high)));
  return {middle - real * half, middle + real * half, imaginary * half,
          middle - inner,       middle + inner,       State::analytic};
}

Strip difference(double t, const Strip& z) { return add(Strip::exactly(t), negate(z)); }

Strip raised(const Strip& z, double c) { return checked(power(z, Strip::exactly(c))); }

Strip scaled(double c, const Strip& z) { return multiply(Strip::exactly(c), z); }

Strip enclose(const Tape& tape, std::span<const Strip> inputs, std::vector<Strip>& registers) {
  registers.resize(tape.code.size());
  for (std::size_t k = 0; k < tape.code.size(); ++k)
    registers[k] = checked(run(tape, tape.code[k], inputs, registers));
  return registers[static_cast<std::size_t>(tape.outputs[0])];
}

} // namespace hvi::solver
