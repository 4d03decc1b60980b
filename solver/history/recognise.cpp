// Recognition of exponential sums: expressions are expanded in the algebra of the terms
// c g(t) h(s) lag^r exp(p lag + sigma t), which is closed under sums and products.
#include "solver/history/recognise.hpp"

#include "solver/history/breaks.hpp"

#include <cmath>
#include <numeric>

namespace hvi::solver {

namespace {

using Terms = ExponentialTerms;
using Maybe = std::optional<Terms>;

constexpr std::size_t max_terms = 200;
constexpr int max_power = 10;

bool close(Complex a, Complex b) { return std::abs(a - b) <= 1e-14 * (std::abs(a) + std::abs(b)); }

bool alike(const ExponentialTerm& a, const ExponentialTerm& b) {
  return a.power == b.power && close(a.lag_rate, b.lag_rate) && close(a.time_rate, b.time_rate) &&
         a.of_time == b.of_time && a.of_source == b.of_source;
}

/// Rates that cancel up to rounding are zero: exp(-t) exp(t - lag) has no rate in t.
Complex sum_of_rates(Complex a, Complex b) {
  const auto part = [](double x, double y) {
    const double z = x + y;
    return std::abs(z) <= 1e-14 * (std::abs(x) + std::abs(y)) ? 0.0 : z;
  };
  return {part(a.real(), b.real()), part(a.imag(), b.imag())};
}

ExponentialTerm constant(double c) {
  ExponentialTerm term;
  term.factor = c;
  return term;
}

Terms merged(Terms a, const Terms& b) {
  for (const ExponentialTerm& term : b) {
    bool known = false;
    for (ExponentialTerm& other : a) {
      if (!alike(term, other)) continue;
      // What cancels up to rounding is gone: cosh^2 - sinh^2 leaves no exponential.
      const double size = std::abs(other.factor) + std::abs(term.factor);
      other.factor += term.factor;
      if (std::abs(other.factor) <= 8e-16 * size) other.factor = 0.0;
      known = true;
      break;
    }
    if (!known) a.push_back(term);
  }
  std::erase_if(a, [](const ExponentialTerm& term) { return term.factor == 0.0; });
  return a;
}

Maybe added(Terms a, const Terms& b) {
  Terms sum = merged(std::move(a), b);
  if (sum.size() > max_terms) return std::nullopt;
  return sum;
}

ExponentialTerm product_of(const ExponentialTerm& a, const ExponentialTerm& b) {
  ExponentialTerm c;
  c.factor = a.factor * b.factor;
  c.power = a.power + b.power;
  c.lag_rate = sum_of_rates(a.lag_rate, b.lag_rate);
  c.time_rate = sum_of_rates(a.time_rate, b.time_rate);
  c.of_time = a.of_time * b.of_time;
  c.of_source = a.of_source * b.of_source;
  return c;
}

Maybe multiplied(const Terms& a, const Terms& b) {
  Terms sum;
  for (const ExponentialTerm& x : a) {
    for (const ExponentialTerm& y : b) {
      const ExponentialTerm term = product_of(x, y);
      if (term.power > max_power) return std::nullopt;
      Maybe next = added(std::move(sum), {term});
      if (!next) return std::nullopt;
      sum = std::move(*next);
    }
  }
  return sum;
}

/// term^exponent of a single term without powers of the lag; a fractional power of a real one only.
Maybe raised(const Terms& base, double exponent) {
  if (base.size() != 1 || base[0].power != 0) return std::nullopt;
  const ExponentialTerm& b = base[0];
  const bool whole = exponent == std::round(exponent);
  const bool real = b.lag_rate.imag() == 0 && b.time_rate.imag() == 0 && b.factor.imag() == 0 &&
                    b.factor.real() > 0;
  const bool bare = b.of_time.is(1) && b.of_source.is(1);
  if (!whole && (!real || !bare)) return std::nullopt;
  ExponentialTerm term;
  term.factor = std::pow(b.factor, exponent);
  term.lag_rate = exponent * b.lag_rate;
  term.time_rate = exponent * b.time_rate;
  term.of_time = bare ? Expr(1.0) : pow(b.of_time, Expr(exponent));
  term.of_source = bare ? Expr(1.0) : pow(b.of_source, Expr(exponent));
  return Terms{term};
}

/// The expression as a function of s = t - lag, if t and the lag appear in it only as t - lag.
std::optional<Expr> in_source(const Expr& e) {
  if (const auto a = affine_form(e)) {
    if (a->lag != -a->time) return std::nullopt;
    return Expr(a->time) * Expr::variable(source_slot) + Expr(a->constant);
  }
  if (e.op() == Op::slot) return std::nullopt;
  std::vector<Expr> args;
  for (const Expr& arg : e.args()) {
    const auto changed = in_source(arg);
    if (!changed) return std::nullopt;
    args.push_back(*changed);
  }
  if (e.op() == Op::table || e.op() == Op::table_slope) {
    return Expr::tabulated(e.table(), args[0], e.op() == Op::table_slope);
  }
  return Expr::make(e.op(), std::move(args));
}

Maybe exponential(const Expr& argument);
Maybe expanded(const Expr& e);

/// exp(factor * argument) for an affine argument.
ExponentialTerm exponential_of(const AffineForm& a, Complex factor) {
  ExponentialTerm term;
  term.factor = std::exp(factor * a.constant);
  term.lag_rate = factor * a.lag;
  term.time_rate = factor * a.time;
  return term;
}

/// exp(a + b) = exp(a) exp(b): each addend may be affine, of t only, or of s only.
Maybe exponential(const Expr& argument) {
  if (const auto a = affine_form(argument)) return Terms{exponential_of(*a, 1.0)};
  ExponentialTerm term;
  if (!argument.depends_on(slot::lag)) {
    term.of_time = exp(argument);
    return Terms{term};
  }
  if (const auto source = in_source(argument)) {
    term.of_source = exp(*source);
    return Terms{term};
  }
  if (argument.op() == Op::neg) {
    const auto inner = exponential(argument.args()[0]);
    return inner ? raised(*inner, -1) : std::nullopt;
  }
  if (argument.op() != Op::add) return std::nullopt;
  const auto a = exponential(argument.args()[0]), b = exponential(argument.args()[1]);
  return a && b ? multiplied(*a, *b) : std::nullopt;
}

/// cos, sin, cosh, sinh of an affine argument by Euler's formulas.
Maybe oscillation(const Expr& e) {
  const auto a = affine_form(e.args()[0]);
  if (!a) return std::nullopt;
  const bool circular = e.op() == Op::cos || e.op() == Op::sin;
  const Complex unit = circular ? Complex(0, 1) : Complex(1, 0);
  ExponentialTerm plus = exponential_of(*a, unit), minus = exponential_of(*a, -unit);
  plus.factor *= 0.5;
  minus.factor *= 0.5;
  if (e.op() == Op::sinh || e.op() == Op::sin) minus.factor = -minus.factor;
  if (e.op() == Op::sin) {
    plus.factor *= Complex(0, -1);
    minus.factor *= Complex(0, -1);
  }
  return added({plus}, {minus});
}

Maybe power(const Expr& e) {
  const Expr &base = e.args()[0], &exponent = e.args()[1];
  if (base.is_constant() && base.value() > 0) {
    return exponential(Expr(std::log(base.value())) * exponent);
  }
  if (!exponent.is_constant()) return std::nullopt;
  const auto b = expanded(base);
  if (!b) return std::nullopt;
  const double n = exponent.value();
  if (const auto single = raised(*b, n)) return single;
  if (n != std::round(n) || n < 0 || n > max_power) return std::nullopt;
  Maybe result = Terms{constant(1)};
  for (int i = 0; i < static_cast<int>(n) && result; ++i) result = multiplied(*result, *b);
  return result;
}

/// An affine function of t and the lag: of s if it is one, else split.
Terms affine_terms(const AffineForm& a) {
  if (a.time != 0 && a.lag == -a.time) {
    ExponentialTerm term;
    term.of_source = Expr(a.time) * Expr::variable(source_slot) + Expr(a.constant);
    return {term};
  }
  Terms terms;
  if (a.lag != 0) {
    terms.push_back(constant(a.lag));
    terms.back().power = 1;
  }
  if (a.time != 0) {
    terms.push_back(constant(1));
    terms.back().of_time = Expr(a.time) * Expr::variable(slot::t) + Expr(a.constant);
  } else if (a.constant != 0) {
    terms.push_back(constant(a.constant));
  }
  return terms;
}

/// By structure: sums, products, quotients, powers, exponentials.
Maybe expand_structure(const Expr& e) {
  const auto arg = [&](std::size_t i) { return expanded(e.args()[i]); };
  switch (e.op()) {
  case Op::neg: {
    const auto a = arg(0);
    return a ? multiplied(*a, {constant(-1)}) : std::nullopt;
  }
  case Op::add: {
    const auto a = arg(0), b = arg(1);
    return a && b ? added(*a, *b) : std::nullopt;
  }
  case Op::mul: {
    const auto a = arg(0), b = arg(1);
    return a && b ? multiplied(*a, *b) : std::nullopt;
  }
  case Op::div: {
    const auto a = arg(0), b = arg(1);
    const auto inverse = b ? raised(*b, -1) : std::nullopt;
    return a && inverse ? multiplied(*a, *inverse) : std::nullopt;
  }
  case Op::pow:
    return power(e);
  case Op::sqrt: {
    const auto a = arg(0);
    return a ? raised(*a, 0.5) : std::nullopt;
  }
  case Op::exp:
    return exponential(e.args()[0]);
  case Op::cos:
  case Op::sin:
  case Op::cosh:
  case Op::sinh:
    return oscillation(e);
  default:
    return std::nullopt;
  }
}

Maybe expanded(const Expr& e) {
  if (const auto a = affine_form(e)) return affine_terms(*a);
  // exp(-t) stays an exponential, to meet exp(s); other functions of t alone are not opened.
  const bool opens = e.op() == Op::exp || e.op() == Op::mul || e.op() == Op::add ||
                     e.op() == Op::neg || e.op() == Op::div || e.op() == Op::pow;
  ExponentialTerm term;
  if (!e.depends_on(slot::lag) && !opens) {
    term.of_time = e;
    return Terms{term};
  }
  if (const auto terms = expand_structure(e)) return terms;
  if (!e.depends_on(slot::lag)) {
    term.of_time = e;
    return Terms{term};
  }
  if (const auto source = in_source(e)) {
    term.of_source = *source;
    return Terms{term};
  }
  return std::nullopt;
}

/// Numbers in front of g and h belong to the factor, so that like terms are seen as such.
void pull_numbers(ExponentialTerm& term) {
  for (Expr* e : {&term.of_time, &term.of_source}) {
    if (!e->is_constant()) continue;
    term.factor *= e->value();
    *e = Expr(1.0);
  }
}

} // namespace

std::optional<ExponentialTerms> exponential_terms(const Expr& kernel) {
  auto terms = expanded(kernel);
  if (!terms) return std::nullopt;
  for (ExponentialTerm& term : *terms) pull_numbers(term);
  return added({}, *terms);
}

ExponentialTerms exponential_terms(const PronySeries& series) {
  Terms terms{constant(series.constant)};
  for (std::size_t i = 0; i < series.weights.size(); ++i) {
    terms.push_back(constant(series.weights[i]));
    terms.back().lag_rate = -1.0 / series.times[i];
  }
  return merged({}, terms);
}

double evaluate(const ExponentialTerms& terms, double t, double lag) {
  double sum = 0;
  for (const ExponentialTerm& term : terms) {
    const auto value_of = [&](Slot s) { return s == source_slot ? t - lag : t; };
    const auto number = [&](const Expr& e) {
      return e.is_constant() ? e.value() : evaluate(e, value_of);
    };
    const double g = number(term.of_time), h = number(term.of_source);
    sum += g * h * std::pow(lag, term.power) *
           (term.factor * std::exp(term.lag_rate * lag + term.time_rate * t)).real();
  }
  return sum;
}

} // namespace hvi::solver
