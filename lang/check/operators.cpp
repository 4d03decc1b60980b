#include "lang/check/operators.hpp"

#include "lang/check/across.hpp"
#include "lang/check/material_use.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::lang {

namespace {

constexpr const char* forms_are_bilinear = "the forms of the inequality are bilinear; a nonlinear "
                                           "law is a superpotential, and what a load "
                                           "reads of the solution stands on the right";

bool is_zero(const Field& f) {
  for (const Symbol& c : f.components)
    if (!c.is(0.0)) return false;
  return f.laws.empty();
}

/// Degree of a sum whose summands have these degrees.
Degree sum_degree(Degree a, Degree b, bool a_zero, bool b_zero) {
  if (a_zero) return b;
  if (b_zero) return a;
  if (a == Degree::nonlinear || b == Degree::nonlinear) return Degree::nonlinear;
  if (a == b) return a;
  return Degree::affine;
}

Field shaped_like(const Field& f) {
  Field out = f;
  out.components.clear();
  out.laws.clear();
  out.series.reset();
  out.across.clear();
  out.materials.clear();
  return out;
}

bool is_of_place(const Field& f) {
  return f.test == Degree::none && f.trial == Degree::none && f.laws.empty() &&
         std::ranges::none_of(f.components, [](const Symbol& c) {
           return c.depends_on(solver::slot::t) || c.depends_on(solver::slot::lag);
         });
}

/// A Prony series times a quantity of place stays one; whatever else is made of it is an expression
/// like any other.
std::optional<SeriesTimes> series_of_product(const Field& factor, const Field& body) {
  const bool first = factor.series.has_value();
  if (first == body.series.has_value() || (body.rank != 0 && body.rank != 4) ||
      !is_of_place(first ? body : factor))
    return std::nullopt;
  SeriesTimes out = first ? *factor.series : *body.series;
  const Symbol by = first ? out.of_place.front() : factor.scalar();
  if (first) out.of_place = body.components;
  for (Symbol& c : out.of_place) c = by * c;
  out.materials = scaled(first ? body.materials : out.materials, by);
  return out;
}

/// A quantity without u and v times a sum of materials.
std::vector<MaterialUse> materials_of_product(const Field& factor, const Field& body) {
  const bool first = body.materials.empty();
  const Field &by = first ? body : factor, &sum = first ? factor : body;
  const bool plain = by.rank == 0 && by.test == Degree::none && by.trial == Degree::none &&
                     by.materials.empty() && by.laws.empty();
  return plain ? scaled(sum.materials, by.scalar()) : std::vector<MaterialUse>();
}

} // namespace

std::optional<Field> Operators::add(const ast::Expr& e, const ast::Binary& b, Field left,
                                    Field right, const Scope& scope) {
  if (left.law_vector || right.law_vector) {
    mistakes_.error("E0308", e.span,
                    "the vector argument of a superpotential enters through its norm",
                    "use `norm(...)` of it");
    return std::nullopt;
  }
  if (!same_shape(left, right)) {
    mistakes_.add(diagnose("E0307", b.op_span,
                           fmt::format("{} and {} cannot be {}", describe(left), describe(right),
                                       b.op == ast::BinaryOp::add ? "added" : "subtracted"))
                      .with_secondary(b.left->span, describe(left))
                      .with_secondary(b.right->span, describe(right)));
    return std::nullopt;
  }
  if (scope.test && left.test != right.test && !is_zero(left) && !is_zero(right) &&
      (left.test == Degree::none || right.test == Degree::none)) {
    const ast::Expr& lacking = left.test == Degree::none ? *b.left : *b.right;
    mistakes_.error(
        "E0402", lacking.span,
        fmt::format("this does not contain the test function {}", unknowns_.names_of_tests()),
        "every summand of an integral is linear in the test function");
    return std::nullopt;
  }
  const double sign = b.op == ast::BinaryOp::add ? 1.0 : -1.0;
  Field out = shaped_like(left);
  for (std::size_t i = 0; i < left.components.size(); ++i)
    out.components.push_back(sign > 0 ? left.components[i] + right.components[i]
                                      : left.components[i] - right.components[i]);
  out.test = sum_degree(left.test, right.test, is_zero(left), is_zero(right));
  out.trial = sum_degree(left.trial, right.trial, is_zero(left), is_zero(right));
  out.rate = left.rate || right.rate;
  out.memory = left.memory || right.memory;
  out.read = left.read || right.read;
  out.across = across_of_sum(left, right, sign);
  out.materials = joined(left.materials, scaled(right.materials, sign));
  out.laws = left.laws;
  for (LawUse use : right.laws) {
    use.factor = sign * use.factor;
    if (sign < 0) use.factor_span = b.op_span;
    out.laws.push_back(std::move(use));
  }
  if (left.by_slope != right.by_slope && scope.law) {
    // A slope and a potential: the sum is given by its slope.
    Field& potential = left.by_slope ? right : left;
    const Symbol slope = derivative(potential.scalar(), solver::slot::argument(0));
    out.components[0] = left.by_slope ? left.scalar() + Symbol(sign) * slope
                                      : slope + Symbol(sign) * right.scalar();
  }
  out.by_slope = left.by_slope || right.by_slope;
  return out;
}

bool Operators::product_degrees(const Span& span, const Field& left, const Field& right, Field& out,
                                const Scope& scope) {
  if (left.test != Degree::none && right.test != Degree::none) {
    mistakes_.error("E0401", span,
                    fmt::format("this product is not linear in {}", unknowns_.names_of_tests()),
                    "the test function occurs once in every term");
    return false;
  }
  if (left.trial != Degree::none && right.trial != Degree::none && !scope.may_be_nonlinear()) {
    mistakes_.error("E0403", span,
                    fmt::format("this product is not linear in {}", unknowns_.names()),
                    forms_are_bilinear);
    return false;
  }
  out.test = left.test != Degree::none ? left.test : right.test;
  out.trial = left.trial == Degree::none    ? right.trial
              : right.trial == Degree::none ? left.trial
                                            : Degree::nonlinear;
  out.rate = left.rate || right.rate;
  out.memory = left.memory || right.memory;
  out.read = left.read || right.read;
  return true;
}

bool Operators::nonlinear_degrees(const Span& span, const std::string& what,
                                  const std::vector<const Field*>& args, Field& out,
                                  const Scope& scope) {
  for (const Field* f : args) {
    if (f->test != Degree::none) {
      mistakes_.error("E0401", span,
                      fmt::format("{} is not linear in {}", what, unknowns_.names_of_tests()),
                      "the test function enters linearly");
      return false;
    }
    if (f->trial == Degree::none) continue;
    if (!scope.may_be_nonlinear()) {
      mistakes_.error("E0403", span, fmt::format("{} is not linear in {}", what, unknowns_.names()),
                      forms_are_bilinear);
      return false;
    }
    out.trial = Degree::nonlinear;
    out.rate = out.rate || f->rate;
    out.memory = out.memory || f->memory;
  }
  return true;
}

std::optional<Field> Operators::multiply(const ast::Expr& e, const ast::Binary& b,
                                         const Field& left, const Field& right,
                                         const Scope& scope) {
  if (left.law_vector || right.law_vector) {
    mistakes_.error("E0308", e.span,
                    "the vector argument of a superpotential enters through its norm",
                    "use `norm(...)` of it");
    return std::nullopt;
  }
  if (left.rank != 0 && right.rank != 0) {
    std::string help = "use `dot(a, b)` for the product of vectors";
    if (left.rank == 4 || right.rank == 4 || (left.rank == 2 && right.rank == 2))
      help = "use `:` for the double contraction";
    else if (left.rank == 2 || right.rank == 2)
      help = "use `dot(a, b)` for a matrix times a vector";
    mistakes_.error(
        "E0308", b.op_span,
        fmt::format("`*` multiplies by a scalar, not {} by {}", describe(left), describe(right)),
        help);
    return std::nullopt;
  }
  const Field& factor = left.rank == 0 && (left.laws.empty() || right.rank != 0) ? left : right;
  const Field& body = &factor == &left ? right : left;
  Field out = shaped_like(body);
  if (!product_degrees(e.span, left, right, out, scope)) return std::nullopt;
  if (scope.law && (left.by_slope || right.by_slope)) {
    const Field& other = left.by_slope ? right : left;
    if (other.by_slope || other.scalar().depends_on(solver::slot::argument(0))) {
      mistakes_.error("E0308", e.span,
                      "a law given by its slope can be multiplied by a constant only",
                      "give it by its potential");
      return std::nullopt;
    }
  }
  out.by_slope = left.by_slope || right.by_slope;
  for (const Symbol& c : body.components) out.components.push_back(factor.scalar() * c);
  out.series = series_of_product(factor, body);
  out.across = across_of_product(factor, body);
  out.materials = materials_of_product(factor, body);
  for (LawUse use : body.laws) {
    use.factor = factor.scalar() * use.factor;
    use.factor_span = &factor == &left ? b.left->span : b.right->span;
    out.laws.push_back(std::move(use));
  }
  return check_finite(e.span, out) ? std::optional(out) : std::nullopt;
}

std::optional<Field> Operators::divide(const ast::Expr& e, const ast::Binary& b, const Field& left,
                                       const Field& right, const Scope& scope) {
  if (right.rank != 0 || right.law_vector || left.law_vector) {
    mistakes_.error("E0308", b.op_span,
                    fmt::format("{} cannot be divided by {}", describe(left), describe(right)),
                    "only a scalar can divide");
    return std::nullopt;
  }
  if (right.scalar().is(0.0)) {
    mistakes_.error("E0407", b.right->span, "division by zero");
    return std::nullopt;
  }
  Field out = shaped_like(left);
  out.test = left.test;
  out.trial = left.trial;
  if (!nonlinear_degrees(b.right->span, "division by this", {&right}, out, scope))
    return std::nullopt;
  for (const Symbol& c : left.components) out.components.push_back(c / right.scalar());
  for (const Symbol& c : left.across) out.across.push_back(c / right.scalar());
  if (right.trial == Degree::none) out.materials = scaled(left.materials, 1.0 / right.scalar());
  for (LawUse use : left.laws) {
    use.factor = use.factor / right.scalar();
    use.factor_span = b.right->span;
    out.laws.push_back(std::move(use));
  }
  return check_finite(e.span, out) ? std::optional(out) : std::nullopt;
}

std::optional<Field> Operators::power(const ast::Expr& e, const Field& left, const Field& right,
                                      const Scope& scope) {
  if (left.rank != 0 || right.rank != 0 || left.law_vector) {
    mistakes_.error(
        "E0308", e.span,
        fmt::format("`^` takes scalars, not {} and {}", describe(left), describe(right)),
        left.law_vector ? "write `norm(xi)^2`" : "");
    return std::nullopt;
  }
  Field out = shaped_like(left);
  out.test = out.trial = Degree::none;
  if (!nonlinear_degrees(e.span, "this power", {&left, &right}, out, scope)) return std::nullopt;
  out.components = {pow(left.scalar(), right.scalar())};
  return check_finite(e.span, out) ? std::optional(out) : std::nullopt;
}

std::optional<Field> Operators::contract(const ast::Expr& e, const ast::Binary& b,
                                         const Field& left, const Field& right,
                                         const Scope& scope) {
  auto wrong = [&](const std::string& help) {
    mistakes_.error(
        "E0308", b.op_span,
        fmt::format("`:` does not contract {} with {}", describe(left), describe(right)), help);
    return std::nullopt;
  };
  if (left.rank <= 1 && right.rank <= 1)
    return wrong(left.rank == 1 && right.rank == 1 ? "use `dot(a, b)` for the product of vectors"
                                                   : "use `*` to multiply by a scalar");
  if (left.rank <= 1 || right.rank <= 1)
    return wrong(left.rank == 0 || right.rank == 0
                     ? "use `*` to multiply by a scalar"
                     : "a vector is contracted with `dot`; a strain is `eps(u)`");
  const char* const sizes =
      model_.mesh.axisymmetric
          ? "matrices of a body of revolution are 3 x 3, with zz along the circles"
          : "";
  if (left.rank == 2 && right.rank == 2 && !same_shape(left, right)) return wrong(sizes);
  if (left.rank != right.rank && (left.rows != right.rows || left.columns != right.columns))
    return wrong(sizes);
  Field out;
  if (!product_degrees(e.span, left, right, out, scope)) return std::nullopt;
  const int d = left.rows;
  const int n =
      left.rank == 2 && right.rank == 2 ? static_cast<int>(left.components.size()) : d * d;
  const int rows = left.rank == 4 ? n : 1;
  const int columns = right.rank == 4 ? n : 1;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      Symbol sum = 0.0;
      for (int k = 0; k < n; ++k)
        sum = sum + left.components[i * n + k] * right.components[k * columns + j];
      out.components.push_back(sum);
    }
  out.rank = left.rank + right.rank - 4;
  if (left.rank == 4 && right.rank == 4) out.rank = 4;
  if (out.rank >= 2) out.rows = out.columns = d;
  out.across = across_of_contraction(left, right);
  out.materials = contracted(left, right, model_.tensors);
  return out;
}

std::optional<Field> Operators::dot(const Span& span, const Field& left, const Field& right,
                                    const Scope& scope) {
  auto wrong = [&](const std::string& help) {
    mistakes_.error("E0308", span,
                    fmt::format("dot does not take {} and {}", describe(left), describe(right)),
                    help);
    return std::nullopt;
  };
  if (left.law_vector || right.law_vector) return wrong("use `norm(xi)`");
  if (left.rank == 4 || right.rank == 4) return wrong("use `:`");
  if (left.rank == 0 || right.rank == 0) return wrong("use `*` to multiply by a scalar");
  const auto in_section = [&](const Field& f) {
    return model_.mesh.axisymmetric && f.rank == 1 && f.rows == 2;
  };
  if (left.rank == 2 && left.columns == 3 && in_section(right))
    return dot_in_section(span, left, right, scope);
  if (right.rank == 2 && right.rows == 3 && in_section(left)) {
    Field turned = right;
    for (int i = 0; i < right.rows; ++i)
      for (int j = 0; j < right.columns; ++j)
        turned.components[j * right.rows + i] = right.components[i * right.columns + j];
    std::swap(turned.rows, turned.columns);
    return dot_in_section(span, turned, left, scope);
  }
  const int inner_left = left.rank == 1 ? left.rows : left.columns;
  if (inner_left != right.rows)
    return wrong(fmt::format("the sizes {} and {} do not match", inner_left, right.rows));
  Field out;
  if (!product_degrees(span, left, right, out, scope)) return std::nullopt;
  const int rows = left.rank == 1 ? 1 : left.rows;
  const int columns = right.rank == 1 ? 1 : right.columns;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      Symbol sum = 0.0;
      for (int k = 0; k < inner_left; ++k)
        sum = sum + left.components[i * inner_left + k] * right.components[k * columns + j];
      out.components.push_back(sum);
    }
  out.rank = left.rank + right.rank - 2;
  out.rows = out.rank == 0 ? 1 : (out.rank == 2 ? rows : rows * columns);
  out.columns = out.rank == 2 ? columns : 1;
  return out;
}

/// A matrix of a body of revolution times a vector of its section, which has no part along the
/// circles; neither has the product.
std::optional<Field> Operators::dot_in_section(const Span& span, const Field& left,
                                               const Field& right, const Scope& scope) {
  Field out;
  if (!product_degrees(span, left, right, out, scope)) return std::nullopt;
  const auto product = [&](int i) {
    return left.components[i * 3] * right.components[0] +
           left.components[i * 3 + 1] * right.components[1];
  };
  out.rank = 1;
  out.rows = left.rows == 3 ? 2 : left.rows;
  for (int i = 0; i < out.rows; ++i) out.components.push_back(product(i));
  if (left.rows != 3 || product(2).is(0.0)) return out;
  mistakes_.error("E0442", span, "this vector has a part along the circles of a body of revolution",
                  "matrices that turn vectors out of the section are not axisymmetric here");
  return std::nullopt;
}

bool Operators::check_finite(const Span& span, const Field& result) {
  for (const Symbol& c : result.components) {
    bool constant_args = !c.is_constant();
    for (const Symbol& arg : c.args()) constant_args = constant_args && arg.is_constant();
    if (c.op() == solver::Op::slot) constant_args = false;
    const bool infinite = c.is_constant() && !std::isfinite(c.value());
    if (!infinite && !(constant_args && !c.args().empty())) continue;
    mistakes_.error("E0407", span, "this constant is not a finite number");
    return false;
  }
  return true;
}

} // namespace hvi::lang
