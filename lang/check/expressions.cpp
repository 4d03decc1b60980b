#include "lang/check/expressions.hpp"

#include "lang/check/inertia.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace hvi::lang {

namespace {

using solver::Op;

} // namespace

Value Expressions::expr(const ast::Expr& e, const Scope& scope) {
  return limits_.of_expression(e.span, [&] { return expr_node(e, scope); });
}

Value Expressions::expr_node(const ast::Expr& e, const Scope& scope) {
  return std::visit(
      Overloaded{
          [&](const ast::Number& n) -> Value {
            // NaN: the lexer has complained about it.
            return std::isnan(n.value) ? Value(Poison{}) : Value(scalar_field(n.value));
          },
          [&](const ast::Quantity& q) -> Value {
            auto f = evaluator_.scalar(*q.value, scope);
            const auto unit = options_.units.find(q.unit.text);
            if (!f || unit == options_.units.end()) return Poison{}; // unknown: reported
            const UnitFactor& one = unit->second;
            const auto in_units = [&](const Symbol& s) { return s * one.times / one.over; };
            f->components.front() = in_units(f->scalar());
            if (f->series) f->series->of_place.front() = in_units(f->series->of_place.front());
            f->materials = scaled(std::move(f->materials), one.times / one.over);
            for (LawUse& use : f->laws) use.factor = in_units(use.factor);
            return *f;
          },
          [&](const ast::String& s) -> Value { return TextValue{s.text}; },
          [&](const ast::Reference& r) -> Value { return evaluator_.reference(e, r.name, scope); },
          [&](const ast::List& l) -> Value { return list(e, l, scope); },
          [&](const ast::Negate& n) -> Value {
            auto f = evaluator_.field(*n.operand, scope);
            if (!f) return Poison{};
            for (Symbol& c : f->components) c = -c;
            for (Symbol& c : f->across) c = -c;
            if (f->series) {
              for (Symbol& c : f->series->of_place) c = -c;
              f->series->materials = scaled(std::move(f->series->materials), -1.0);
            }
            f->materials = scaled(std::move(f->materials), -1.0);
            for (LawUse& use : f->laws) {
              use.factor = -use.factor;
              use.factor_span = n.op;
            }
            return *f;
          },
          [&](const ast::Binary& b) -> Value { return binary(e, b, scope); },
          [&](const ast::Cases& c) -> Value { return cases(e, c, scope); },
          [&](const ast::Member& m) -> Value { return member(e, m, scope); },
          [&](const ast::Prime& p) -> Value { return prime(e, p, scope); },
          [&](const ast::Call& c) -> Value { return calls_.call(e, c, scope); },
          [&](const ast::Clarke& c) -> Value { return applications_.clarke(e, c, scope); }},
      e.node);
}

Value Expressions::binary(const ast::Expr& e, const ast::Binary& b, const Scope& scope) {
  auto left = evaluator_.field(*b.left, scope);
  auto right = evaluator_.field(*b.right, scope);
  if (!left || !right) return Poison{};
  std::optional<Field> out;
  switch (b.op) {
  case ast::BinaryOp::add:
  case ast::BinaryOp::subtract:
    out = operators_.add(e, b, std::move(*left), std::move(*right), scope);
    break;
  case ast::BinaryOp::multiply:
    out = operators_.multiply(e, b, *left, *right, scope);
    break;
  case ast::BinaryOp::divide:
    out = operators_.divide(e, b, *left, *right, scope);
    break;
  case ast::BinaryOp::contract:
    out = operators_.contract(e, b, *left, *right, scope);
    break;
  case ast::BinaryOp::power:
    out = operators_.power(e, *left, *right, scope);
    break;
  }
  return out ? Value(std::move(*out)) : Value(Poison{});
}

Value Expressions::list(const ast::Expr& e, const ast::List& l, const Scope& scope) {
  std::vector<Field> items;
  bool good = true;
  for (const ast::Expr& item : l.items) {
    auto f = evaluator_.field(item, scope);
    if (f) items.push_back(std::move(*f));
    good = good && f;
  }
  if (!good || items.empty()) return Poison{};
  Field out;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Field& item = items[i];
    if (!same_shape(item, items[0]) || item.law_vector || !item.laws.empty()) {
      mistakes_.error("E0307", l.items[i].span,
                      fmt::format("the entries of a list have one shape: {} beside {}",
                                  describe(item), describe(items[0])));
      return Poison{};
    }
    out.components.insert(out.components.end(), item.components.begin(), item.components.end());
    if (item.test != Degree::none) out.test = item.test;
    if (item.trial != Degree::none) out.trial = item.trial;
    out.rate = out.rate || item.rate;
    out.acceleration = out.acceleration || item.acceleration;
    out.memory = out.memory || item.memory;
  }
  const int n = static_cast<int>(items.size());
  out.rank = items[0].rank + 1;
  out.rows = n;
  out.columns = items[0].rank == 1 ? items[0].rows : 1;
  if (items[0].rank == 2) out.rank = 3; // three of four levels of a full tensor
  if (items[0].rank == 3) {
    out.rank = 4;
    const std::size_t wanted = std::size_t(n) * n * n * n;
    if (out.components.size() != wanted || n != tensor_dim(model_)) {
      mistakes_.error("E0307", e.span,
                      fmt::format("a fourth-order tensor {0} is a {1} x {1} x {1} x {1} list",
                                  model_.mesh.axisymmetric ? std::string("in a body of revolution")
                                                           : fmt::format("in {}D", model_.dim),
                                  tensor_dim(model_)));
      return Poison{};
    }
    out.columns = n;
    if (tensors_.twists(e.span, out)) return Poison{};
  }
  return out;
}

Value Expressions::cases(const ast::Expr& e, const ast::Cases& c, const Scope& scope) {
  // A law is looked at case by case, on both sides of each: the work grows with their square.
  constexpr std::size_t most_cases_of_law = 256;
  if (scope.law && c.cases.size() > most_cases_of_law) {
    mistakes_.error("E0216", e.span,
                    fmt::format("a superpotential with {} cases; {} are the most", c.cases.size(),
                                most_cases_of_law),
                    "a slope with many pieces is a table: `table(\"slope.csv\", r)`");
    return Poison{};
  }
  auto otherwise = evaluator_.field(*c.otherwise, scope);
  std::vector<std::pair<std::optional<Symbol>, std::optional<Field>>> rows;
  for (const ast::Case& row : c.cases)
    rows.emplace_back(condition(row.condition, scope), evaluator_.field(row.value, scope));
  if (!otherwise) return Poison{};
  if (scope.law) {
    LawCases here;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!rows[i].first) break;
      here.conditions.push_back(*rows[i].first);
      here.places.push_back(c.cases[i].condition.span);
      here.values.push_back(c.cases[i].value.span);
    }
    here.values.push_back(c.otherwise->span);
    if (here.conditions.size() == rows.size()) laws_.note_cases(std::move(here));
  }
  Field out = *otherwise;
  out.series.reset();
  out.materials.clear();
  for (std::size_t i = rows.size(); i-- > 0;) {
    auto& [when, value] = rows[i];
    if (!when || !value) return Poison{};
    if (!same_shape(*value, out)) {
      mistakes_.error(
          "E0307", c.cases[i].value.span,
          fmt::format("all cases have one shape: {} beside {}", describe(*value), describe(out)));
      return Poison{};
    }
    if (!value->laws.empty() || !out.laws.empty() || value->by_slope || out.by_slope) {
      mistakes_.error("E0306", e.span, "superpotentials cannot be chosen by cases",
                      "put the cases into the superpotential itself");
      return Poison{};
    }
    for (std::size_t k = 0; k < out.components.size(); ++k)
      out.components[k] = select(*when, value->components[k], out.components[k]);
    if (value->across.size() != out.across.size()) out.across.clear();
    for (std::size_t k = 0; k < out.across.size(); ++k)
      out.across[k] = select(*when, value->across[k], out.across[k]);
    if (value->test != Degree::none) out.test = value->test;
    if (value->trial != Degree::none) out.trial = value->trial;
    out.rate = out.rate || value->rate;
    out.acceleration = out.acceleration || value->acceleration;
    out.memory = out.memory || value->memory;
  }
  return out;
}

std::optional<Symbol> Expressions::condition(const ast::Condition& c, const Scope& scope) {
  return std::visit(
      Overloaded{
          [&](const ast::Compare& cmp) { return compare(cmp, scope); },
          [&](const ast::Inside& in) -> std::optional<Symbol> {
            if (!scope.position) {
              mistakes_.error("E0309", c.span,
                              fmt::format("`inside` cannot be used in {}", scope.what));
              return std::nullopt;
            }
            auto part = parts_.index_of(in.part);
            if (!part) return std::nullopt;
            return Symbol::variable(solver::slot::inside(*part));
          },
          [&](const ast::Not& n) -> std::optional<Symbol> {
            auto operand = condition(*n.operand, scope);
            if (!operand) return std::nullopt;
            return Symbol::make(Op::logic_not, {*operand});
          },
          [&](const auto& junction) -> std::optional<Symbol> {
            constexpr bool is_and = std::is_same_v<std::decay_t<decltype(junction)>, ast::And>;
            std::optional<Symbol> out;
            bool good = true;
            for (const ast::Condition& operand : junction.operands) {
              auto s = condition(operand, scope);
              good = good && s;
              if (s)
                out = out ? Symbol::make(is_and ? Op::logic_and : Op::logic_or, {*out, *s}) : *s;
            }
            return good ? out : std::nullopt;
          }},
      c.node);
}

std::optional<Symbol> Expressions::compare(const ast::Compare& c, const Scope& scope) {
  auto word_of = [&](const ast::Expr& e) -> std::optional<std::string> {
    const auto* r = std::get_if<ast::Reference>(&e.node);
    if (!r) return std::nullopt;
    Value v = evaluator_.reference(e, r->name, scope);
    if (auto* w = std::get_if<Word>(&v)) return w->text;
    return std::nullopt;
  };
  if (c.op == ast::CompareOp::equal || c.op == ast::CompareOp::not_equal) {
    auto left = word_of(c.left);
    auto right = left ? word_of(c.right) : std::nullopt;
    if (left && right)
      return Symbol((*left == *right) == (c.op == ast::CompareOp::equal) ? 1.0 : 0.0);
  }
  auto left = evaluator_.scalar(c.left, scope);
  auto right = evaluator_.scalar(c.right, scope);
  if (!left || !right) return std::nullopt;
  Field degrees;
  const Span whole = join(c.left.span, c.right.span);
  if (!operators_.nonlinear_degrees(whole, "this comparison", {&*left, &*right}, degrees, scope))
    return std::nullopt;
  const Symbol &a = left->scalar(), &b = right->scalar();
  switch (c.op) {
  case ast::CompareOp::less:
    return Symbol::make(Op::less, {a, b});
  case ast::CompareOp::less_equal:
    return Symbol::make(Op::less_equal, {a, b});
  case ast::CompareOp::greater:
    return Symbol::make(Op::less, {b, a});
  case ast::CompareOp::greater_equal:
    return Symbol::make(Op::less_equal, {b, a});
  case ast::CompareOp::equal:
    return Symbol::make(Op::equal, {a, b});
  case ast::CompareOp::not_equal:
    return Symbol::make(Op::logic_not, {Symbol::make(Op::equal, {a, b})});
  }
  return std::nullopt;
}

Value Expressions::prime(const ast::Expr& e, const ast::Prime& p, const Scope& scope) {
  const auto* inner = std::get_if<ast::Prime>(&p.operand->node);
  const ast::Expr& operand = inner ? *inner->operand : *p.operand;
  const int order = inner ? 2 : 1;
  const auto* r = std::get_if<ast::Reference>(&operand.node);
  const int unknown = r ? unknowns_.named(r->name) : -1;
  if (unknown < 0) {
    if (is_poison(expr(operand, scope))) return Poison{};
    mistakes_.error("E0303", p.op,
                    fmt::format("only the unknown{} has a time derivative",
                                find_ ? fmt::format(" {}", unknowns_.names()) : ""),
                    "write `u'` and take `eps(u')` of it");
    return Poison{};
  }
  if (is_poison(evaluator_.reference(operand, r->name, scope))) return Poison{};
  if (!find_->time) {
    mistakes_.error(
        "E0412", e.span,
        fmt::format("`{}{}` needs a problem in time", r->name, order == 2 ? "''" : "'"),
        "add `for t in [0, T] by N steps from u = 0` to the find statement, or leave the term out");
    return Poison{};
  }
  if (order == 2 && scope.report && !has_second_derivative(model_)) {
    mistakes_.error("E0431", e.span, fmt::format("`{}''` in a problem without inertia", r->name),
                    "it is known where a form has it: `integral(body, rho*dot(u'', v))`");
    return Poison{};
  }
  return unknowns_.value(unknown, order, false, scope);
}

} // namespace hvi::lang
