#include "lang/check/functions.hpp"

#include "lang/check/across.hpp"
#include "lang/check/builtins.hpp"
#include "lang/check/material_use.hpp"
#include "solver/plan/tensor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::lang {

using solver::Op;
namespace slot = solver::slot;

/// Of a Bessel function.
bool Functions::is_order(const Span& place, const Symbol& order) {
  constexpr double largest = 1000.0;
  const bool number = order.is_constant();
  if (number && std::abs(order.value()) <= largest && order.value() == std::trunc(order.value()))
    return true;
  mistakes_.error("E0408", place,
                  fmt::format("the order of `bessel_j` is a whole number from -{0} to {0}{1}",
                              largest,
                              number ? fmt::format(", not {}", order.value())
                                     : ", the same everywhere and at all times"));
  return false;
}

/// Of mittag_leffler; those that change with place or time are looked at where they are used.
bool Functions::are_parameters(const ast::Call& c, const Symbol& alpha, const Symbol& beta) {
  constexpr double largest_beta = 100.0;
  const bool alpha_wrong = alpha.is_constant() && !(alpha.value() > 0.0 && alpha.value() <= 2.0);
  const bool beta_wrong = beta.is_constant() && !(std::abs(beta.value()) <= largest_beta);
  if (alpha_wrong)
    mistakes_.error(
        "E0408", c.arguments[0].value.span,
        fmt::format("alpha of `mittag_leffler` is above 0 and at most 2, not {}", alpha.value()));
  if (beta_wrong)
    mistakes_.error("E0408", c.arguments[1].value.span,
                    fmt::format("beta of `mittag_leffler` lies between -{0} and {0}, not {1}",
                                largest_beta, beta.value()));
  return !alpha_wrong && !beta_wrong;
}

Value Functions::pointwise(const ast::Expr& e, const ast::Call& c, const std::string& name,
                           const Scope& scope) {
  const bool variadic = name == "min" || name == "max";
  const bool mittag_leffler = name == "mittag_leffler";
  const std::size_t wanted = *pointwise_arity(name), given = c.arguments.size();
  const bool right_count = variadic         ? given >= 2
                           : mittag_leffler ? given == 2 || given == 3
                                            : given == wanted;
  std::vector<Field> args;
  for (const ast::Argument& argument : c.arguments) {
    if (argument.name) {
      mistakes_.error("E0304", argument.name->span,
                      fmt::format("`{}` has no named arguments", name));
      return Poison{};
    }
    auto f = evaluator_.scalar(argument.value, scope);
    if (f) args.push_back(std::move(*f));
  }
  if (!right_count) {
    const std::size_t most = variadic ? given : wanted;
    mistakes_.error(
        "E0305", given > most ? c.arguments[most].span : e.span,
        fmt::format("`{}` does not take {} argument{}", name, given, given == 1 ? "" : "s"),
        std::string(find_built_in(name)->usage));
    return Poison{};
  }
  if (args.size() != given) return Poison{};
  std::vector<const Field*> pointers;
  std::vector<Symbol> symbols;
  bool slope = false;
  for (const Field& f : args) {
    pointers.push_back(&f);
    symbols.push_back(f.scalar());
    slope = slope || f.by_slope;
  }
  if (slope) {
    mistakes_.error("E0308", e.span,
                    fmt::format("`{}` of a law given by its slope is not known", name),
                    "give that law by its potential");
    return Poison{};
  }
  Field out;
  if (!operators_.nonlinear_degrees(e.span, fmt::format("`{}`", name), pointers, out, scope))
    return Poison{};
  if (name == "pos") {
    out.components = {Symbol::make(Op::max, {symbols.front(), Symbol(0.0)})};
    return out;
  }
  if (mittag_leffler && given == 2) symbols.insert(symbols.begin() + 1, Symbol(1.0));
  if (name == "bessel_j" && !is_order(c.arguments[0].value.span, symbols[0])) return Poison{};
  if (mittag_leffler && !are_parameters(c, symbols[0], symbols[1])) return Poison{};
  if (name == "erfcx") { // the first of its kind: its derivatives are the next ones
    out.components = {Symbol::make(Op::erfcx, {Symbol(0.0), symbols.front()})};
    return operators_.check_finite(e.span, out) ? Value(out) : Value(Poison{});
  }
  Symbol result = Symbol::make(pointwise_op(name), {symbols.begin(), symbols.begin() + wanted});
  if (variadic)
    for (std::size_t i = 2; i < symbols.size(); ++i)
      result = Symbol::make(pointwise_op(name), {result, symbols[i]});
  out.components = {result};
  return operators_.check_finite(e.span, out) ? Value(out) : Value(Poison{});
}

/// d f_i / d x_j for every component: the chain rule over x, and values of functions of x.
std::optional<Field> Functions::total_gradient(const Span& span, const Field& f) {
  const int d = model_.dim;
  const int n = static_cast<int>(f.components.size());
  Field out = matrix_field(n, d, {});
  for (const Symbol& c : f.components)
    for (int j = 0; j < d; ++j) {
      Symbol sum = derivative(c, slot::x(j));
      for (solver::Slot s : solver::slots_of(c)) {
        int index = 0;
        if (slot::is_field(s))
          index = slot::derivative_of(s);
        else if (slot::is_test(s))
          index = s - slot::test(0);
        else
          continue;
        if (!slot::is_value(index)) {
          mistakes_.error("E0421", span, "second derivatives are not available",
                          "elements of order 1 and 2 have one weak derivative; integrate by parts");
          return std::nullopt;
        }
        const int component = index % slot::own_derivatives;
        sum =
            sum + derivative(c, s) * Symbol::variable(s - component + slot::gradient(component, j));
      }
      out.components.push_back(sum);
    }
  out.test = f.test;
  out.trial = f.trial;
  out.rate = f.rate;
  out.memory = f.memory;
  return out;
}

/// The gradient of a vector on an axisymmetric mesh, on (e_r, e_axis, e_hoop): with f_x/x as its
/// entry zz, on the axis its limit d f_x/dx. In functions of V it is an entry of their own.
Field Functions::with_hoop(const Field& gradient, const Field& f) const {
  const Symbol x = Symbol::variable(slot::x(0)), &radial = f.components[0];
  Symbol along = 0.0, rest = radial;
  for (solver::Slot s : solver::slots_of(radial)) {
    const int index = slot::is_test(s)    ? s - slot::test(0)
                      : slot::is_field(s) ? slot::derivative_of(s)
                                          : -1;
    if (index < 0 || index % slot::own_derivatives != slot::value(0)) continue;
    const Symbol slope = derivative(radial, s);
    if (slope.depends_on(s)) continue;
    along = along + slope * Symbol::variable(s + slot::hoop);
    rest = substitute(rest, std::vector<std::pair<solver::Slot, Symbol>>{{s, Symbol(0.0)}});
  }
  const std::vector<Symbol>& g = gradient.components;
  if (!rest.is(0.0)) along = select(less(Symbol(0.0), x), along + rest / x, g[0]);
  Field out = gradient;
  out.rows = out.columns = 3;
  out.components = {g[0], g[1], 0.0, g[2], g[3], 0.0, 0.0, 0.0, along};
  return out;
}

Value Functions::differential(const ast::Expr& e, const ast::Call& c, const std::string& name,
                              const Scope& scope) {
  auto args = evaluator_.match(e, c, name, {"u"}, 1);
  if (!args) return Poison{};
  auto f = evaluator_.field(*(*args)[0], scope);
  if (!f) return Poison{};
  const int d = model_.dim;
  const bool wants_vector = name != "grad";
  if (f->law_vector || !f->laws.empty() || (wants_vector && (f->rank != 1 || f->rows != d)) ||
      f->rank > 1) {
    const std::string what = fmt::format(
        "`{}` takes {}, not {}", name,
        wants_vector ? fmt::format("a vector of {}", d) : "a scalar or a vector", describe(*f));
    if (name == "eps" && f->rank == 0) // a space that is not one of vectors is one mistake
      mistakes_.error_once("eps of a scalar", "E0308", (*args)[0]->span, what,
                           "use `grad` of a scalar; a displacement is of a space of vectors, "
                           "`space V = vector P1 on ...`");
    else
      mistakes_.error("E0308", (*args)[0]->span, what);
    return Poison{};
  }
  auto g = total_gradient(e.span, *f);
  if (!g) return Poison{};
  if (model_.mesh.axisymmetric && f->rank == 1) g = with_hoop(*g, *f);
  const int n = g->columns;
  if (name == "grad") {
    if (f->rank == 0) {
      g->rank = 1;
      g->rows = d;
      g->columns = 1;
    }
    return *g;
  }
  Field out = *g;
  if (d == 2 && n == 2) out.across = across_of_strain(*f);
  if (name == "div") {
    Symbol sum = 0.0;
    for (int i = 0; i < n; ++i) sum = sum + g->components[i * n + i];
    out.rank = 0;
    out.rows = out.columns = 1;
    out.components = {sum};
    return out;
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (i != j)
        out.components[i * n + j] =
            Symbol(0.5) * (g->components[i * n + j] + g->components[j * n + i]);
  out.materials = strains_of(*f);
  return out;
}

Value Functions::identity_call(const ast::Expr& e, const ast::Call& c) {
  if (!evaluator_.match(e, c, "identity", {}, 0)) return Poison{};
  const int d = tensor_dim(model_);
  std::vector<Symbol> unit;
  for (int i = 0; i < d * d; ++i) unit.push_back(i % (d + 1) == 0 ? 1.0 : 0.0);
  return matrix_field(d, d, unit);
}

Value Functions::dot_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  auto args = evaluator_.match(e, c, "dot", {"a", "b"}, 2);
  if (!args) return Poison{};
  auto a = evaluator_.field(*(*args)[0], scope), b = evaluator_.field(*(*args)[1], scope);
  if (!a || !b) return Poison{};
  auto out = operators_.dot(e.span, *a, *b, scope);
  return out ? Value(*out) : Value(Poison{});
}

Value Functions::algebraic(const ast::Expr& e, const ast::Call& c, const std::string& name,
                           const Scope& scope) {
  if (name == "identity") return identity_call(e, c);
  if (name == "dot") return dot_call(e, c, scope);
  auto args = evaluator_.match(e, c, name, {"a"}, 1);
  if (!args) return Poison{};
  auto f = evaluator_.field(*(*args)[0], scope);
  if (!f) return Poison{};
  if (name == "norm") {
    Field out;
    if (f->law_vector) {
      out.components = {Symbol::variable(slot::argument(0))};
      return out;
    }
    if (!operators_.nonlinear_degrees(e.span, "`norm`", {&*f}, out, scope)) return Poison{};
    Symbol sum = 0.0;
    for (const Symbol& component : f->components) sum = sum + component * component;
    out.components = {f->rank == 0 ? abs(f->scalar()) : sqrt(sum)};
    return out;
  }
  if (f->rank != 2 || (name != "transpose" && f->rows != f->columns)) {
    mistakes_.error("E0308", (*args)[0]->span,
                    fmt::format("`{}` takes a square matrix, not {}", name, describe(*f)));
    return Poison{};
  }
  Field out = *f;
  out.materials.clear();
  const int n = f->rows;
  if (name == "transpose") {
    out.rows = f->columns;
    out.columns = f->rows;
    for (int i = 0; i < out.rows; ++i)
      for (int j = 0; j < out.columns; ++j)
        out.components[i * out.columns + j] = f->components[j * f->columns + i];
    return out;
  }
  if (name == "mises") return mises_call(e, (*args)[0]->span, *f, scope);
  Symbol trace = 0.0;
  for (int i = 0; i < n; ++i) trace = trace + f->components[i * n + i];
  if (name == "dev" || f->test == Degree::none) out.across.clear();
  if (name == "tr") {
    out.rank = 0;
    out.rows = out.columns = 1;
    out.components = {trace};
    return out;
  }
  for (int i = 0; i < n; ++i)
    out.components[i * n + i] = out.components[i * n + i] - trace / Symbol(double(n));
  return out;
}

/// sqrt(3/2 s : s), s the deviator of the stress with all its entries in space.
Value Functions::mises_call(const ast::Expr& e, const Span& span, const Field& f,
                            const Scope& scope) {
  Field out;
  if (!operators_.nonlinear_degrees(e.span, "`mises`", {&f}, out, scope)) return Poison{};
  const int n = f.rows;
  if (n == 1 || (n == 2 && f.across.empty())) {
    mistakes_.error(
        "E0448", span,
        n == 1 ? "in 1D the stresses across the bar are not known: `mises` would guess them"
               : "the stress across the plane is not known here, and `mises` needs it",
        n == 1 ? "of a bar under uniaxial stress it is `abs(sigma.xx)`"
               : "it is known of `isotropic`, `orthotropic` and `transverse` tensors on `eps(u)`, "
                 "of sums of such stresses, and of `p*div(v)`");
    return Poison{};
  }
  const auto entry = [&](int i, int j) -> Symbol {
    if (n == 3 || (i < 2 && j < 2))
      return Symbol(0.5) * (f.components[i * n + j] + f.components[j * n + i]);
    return i == j ? normal_across(f.across[0]) : shear_across(f.across[0], std::min(i, j));
  };
  Symbol sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Symbol difference = entry(i, i) - entry(j, j), shear = entry(i, j);
    sum = sum + Symbol(0.5) * difference * difference + Symbol(3.0) * shear * shear;
  }
  out.components = {sqrt(sum)};
  return out;
}

} // namespace hvi::lang
