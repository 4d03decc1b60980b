// Dimensions of expressions, except calls.
#include "lang/check/builtins.hpp"
#include "lang/units/dimension_checker.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace hvi::lang::units {

namespace {

constexpr long most_evaluations = 4'000'000; // the checker has refused what would need more

} // namespace

Measured DimensionChecker::value(const ast::Expr& e, const Locals& locals) {
  if (++evaluations_ > most_evaluations) return {};
  return value_of_node(e, locals);
}

Measured DimensionChecker::value_of_node(const ast::Expr& e, const Locals& locals) {
  return std::visit(
      Overloaded{[&](const ast::Number& n) { return literal(n.value); },
                 [&](const ast::Quantity& q) { return quantity(q, locals); },
                 [&](const ast::String&) { return Measured{}; },
                 [&](const ast::Reference& r) { return reference(r.name, locals); },
                 [&](const ast::List& l) { return list(l, locals); },
                 [&](const ast::Negate& n) {
                   Measured out = value(*n.operand, locals);
                   if (out.number) out.number = -*out.number;
                   return out;
                 },
                 [&](const ast::Binary& b) { return binary(b, locals); },
                 [&](const ast::Cases& c) { return cases(c, locals); },
                 [&](const ast::Member& m) { return member(m, locals); },
                 [&](const ast::Prime& p) {
                   const Measured of = value(*p.operand, locals);
                   return of.dimension ? Measured{*of.dimension / duration(), {}} : Measured{};
                 },
                 [&](const ast::Call& c) { return call(e, c, locals); },
                 [&](const ast::Clarke& c) { return clarke(c, locals); }},
      e.node);
}

/// Zero is zero in every unit, and what stands for infinity is infinite in every one.
Measured DimensionChecker::literal(double number) {
  constexpr double infinite = 1e300;
  const bool any = number == 0 || std::abs(number) >= infinite;
  return {any ? inference_.fresh() : Dimension{}, number};
}

Measured DimensionChecker::quantity(const ast::Quantity& q, const Locals& locals) {
  const Measured of = value(*q.value, locals);
  const auto unit = units_.read.find(q.unit.text);
  if (unit == units_.read.end()) return {};
  if (of.dimension && !inference_.unify(*of.dimension, Dimension{})) {
    report_mistake(
        diagnose("E0331", q.unit.span,
                 fmt::format("a unit behind what is in {} already", shown(*of.dimension)))
            .with_secondary(q.value->span, "this has a unit")
            .with_help("units stand behind numbers; multiply by `1 [" + q.unit.text +
                       "]` where the product is meant"));
    return {};
  }
  const UnitFactor factor = units_.system.factor(unit->second);
  Measured out{unit->second.dimension, {}};
  if (of.number) out.number = *of.number * factor.times / factor.over;
  return out;
}

std::optional<std::size_t> DimensionChecker::unknown_named(const std::string& name) const {
  for (std::size_t b = 0; find_ != nullptr && b < find_->unknowns.size(); ++b)
    if (find_->unknowns[b].unknown.text == name) return b;
  return std::nullopt;
}

Measured DimensionChecker::reference(const std::string& name, const Locals& locals) {
  if (const auto local = locals.find(name); local != locals.end()) return local->second;
  const auto found = named_.find(name);
  if (found == named_.end() && find_ != nullptr)
    for (std::size_t b = 0; b < find_->unknowns.size(); ++b) {
      if (find_->unknowns[b].unknown.text == name) return {of_unknown_[b], {}};
      if (find_->unknowns[b].test.text == name) return {of_test_[b], {}};
    }
  if (const Measured own = built_in_name(name); own.dimension) return own;
  return found == named_.end() ? Measured{} : declared(found->second);
}

Measured DimensionChecker::built_in_name(const std::string& name) {
  if (name == "pi") return {Dimension{}, std::numbers::pi};
  if (name == "x" || name == "y" || name == "z") return {length(), {}};
  if (name == "t" || name == "lag") return {duration(), {}};
  if (name == "normal") return {Dimension{}, {}};
  if (name == "sigma" && !of_unknown_.empty()) {
    // Force over v is sigma : eps(v) over the cells.
    std::size_t vector = 0;
    const auto unknowns = solver::unknowns_of(model_.space);
    while (vector + 1 < unknowns.size() && !unknowns[vector].vector) ++vector;
    return {force(vector) * length() / measure_of({}), {}};
  }
  return {};
}

/// Of a parameter, tensor or state.
Measured DimensionChecker::declared(Named& named) {
  if (named.value) return *named.value;
  if (named.busy) return {};
  named.busy = true;
  Measured out;
  if (const auto* p = std::get_if<ast::Param>(named.statement)) {
    out = value(p->value, {});
    out.number.reset();
    for (const ModelParam& known : model_.params)
      if (const auto* number = std::get_if<double>(&known.value);
          known.name == p->name.text && number)
        out.number = *number;
  } else if (const auto* t = std::get_if<ast::Tensor>(named.statement)) {
    out = value(t->value, {});
  } else if (const auto* s = std::get_if<ast::State>(named.statement)) {
    out.dimension = of_state_.try_emplace(s->name.text, inference_.fresh()).first->second;
  }
  named.busy = false;
  named.value = out;
  return out;
}

Measured DimensionChecker::list(const ast::List& l, const Locals& locals) {
  Measured first;
  const ast::Expr* place = nullptr;
  for (const ast::Expr& item : l.items) {
    const Measured now = value(item, locals);
    if (!now.dimension) continue;
    if (place == nullptr)
      first = now, place = &item;
    else if (!same({&first, place}, {&now, &item}, "the entries of a list"))
      return {};
  }
  return {first.dimension, {}};
}

Measured DimensionChecker::binary(const ast::Binary& b, const Locals& locals) {
  const Measured left = value(*b.left, locals), right = value(*b.right, locals);
  if (!left.dimension || !right.dimension) return {};
  const bool numbers = left.number && right.number;
  const double l = left.number.value_or(0), r = right.number.value_or(0);
  const auto with = [&](Dimension d, double number) {
    return Measured{std::move(d), numbers ? std::optional(number) : std::nullopt};
  };
  switch (b.op) {
  case ast::BinaryOp::add:
  case ast::BinaryOp::subtract: {
    const bool adds = b.op == ast::BinaryOp::add;
    if (!same({&left, &*b.left}, {&right, &*b.right}, adds ? "the sum" : "the difference"))
      return {};
    return with(*left.dimension, adds ? l + r : l - r);
  }
  case ast::BinaryOp::multiply:
  case ast::BinaryOp::contract:
    return with(*left.dimension * *right.dimension, l * r);
  case ast::BinaryOp::divide:
    return with(*left.dimension / *right.dimension, l / r);
  case ast::BinaryOp::power:
    return power(b, left, right);
  }
  return {};
}

Measured DimensionChecker::power(const ast::Binary& b, const Measured& base,
                                 const Measured& exponent) {
  if (!wants_number(*b.right, exponent, "an exponent")) return {};
  Measured out;
  if (base.number && exponent.number) out.number = std::pow(*base.number, *exponent.number);
  const auto rational = exponent.number ? rational_near(*exponent.number) : std::nullopt;
  if (rational) {
    out.dimension = base.dimension->to(*rational);
    return out;
  }
  if (general_ && !exponent.number) {
    out.dimension = inference_.fresh();
    powers_.emplace_back(*base.dimension, *out.dimension);
    return out;
  }
  // An exponent that is no known fraction has a number below it.
  if (!wants_number(*b.left, base, "what is raised to a power that changes")) return {};
  out.dimension = Dimension{};
  return out;
}

Measured DimensionChecker::member(const ast::Member& m, const Locals& locals) {
  if (const auto* r = std::get_if<ast::Reference>(&m.object->node)) {
    const auto found = named_.find(r->name);
    const bool law = found != named_.end() &&
                     std::holds_alternative<ast::Superpotential>(*found->second.statement);
    if (law && !locals.contains(r->name))
      return {of_multiplier_.try_emplace(r->name, inference_.fresh()).first->second, {}};
  }
  return {value(*m.object, locals).dimension, {}};
}

Measured DimensionChecker::cases(const ast::Cases& c, const Locals& locals) {
  const Measured otherwise = value(*c.otherwise, locals);
  Measured out{otherwise.dimension, {}};
  for (const ast::Case& one : c.cases) {
    condition(one.condition, locals);
    const Measured now = value(one.value, locals);
    if (!out.dimension)
      out.dimension = now.dimension;
    else if (now.dimension && otherwise.dimension &&
             !same({&now, &one.value}, {&otherwise, &*c.otherwise}, "the cases"))
      return {};
  }
  return out;
}

void DimensionChecker::condition(const ast::Condition& c, const Locals& locals) {
  const auto all = [&](const std::vector<ast::Condition>& operands) {
    for (const ast::Condition& one : operands) condition(one, locals);
  };
  std::visit(
      Overloaded{
          [&](const ast::Compare& compare) {
            const Measured left = value(compare.left, locals);
            const Measured right = value(compare.right, locals);
            if (left.dimension && right.dimension)
              same({&left, &compare.left}, {&right, &compare.right}, "the comparison");
          },
          [&](const ast::Inside&) {}, [&](const ast::Not& n) { condition(*n.operand, locals); },
          [&](const ast::And& a) { all(a.operands); }, [&](const ast::Or& o) { all(o.operands); }},
      c.node);
}

/// j^0(r; s) is the potential's change along s: of the dimension j s/r.
Measured DimensionChecker::clarke(const ast::Clarke& c, const Locals& locals) {
  const Measured at = value(*c.at, locals), direction = value(*c.direction, locals);
  const auto* r = std::get_if<ast::Reference>(&c.law->node);
  const auto found = r ? named_.find(r->name) : named_.end();
  if (found == named_.end() || !at.dimension || !direction.dimension) return {};
  const auto* law = std::get_if<ast::Superpotential>(found->second.statement);
  if (law == nullptr) return {};
  calls_.push_back(c.law->span);
  Locals parameters;
  for (const ast::LawParameter& p : law->parameters)
    if (p.value) parameters[p.name.text] = value(*p.value, parameters);
  const Dimension slope = potential(*law, at, std::move(parameters)) / *at.dimension;
  calls_.pop_back();
  const Dimension multiplier =
      of_multiplier_.try_emplace(r->name, inference_.fresh()).first->second;
  inference_.unify(multiplier, slope);
  of_argument_[r->name] = *at.dimension;
  return {slope * *direction.dimension, {}};
}

/// Of a law's potential: its body, or its slope times its argument.
Dimension DimensionChecker::potential(const ast::Superpotential& law, const Measured& argument,
                                      Locals parameters) {
  parameters[law.argument.text] = {argument.dimension, {}};
  const bool outer = reads_law_;
  reads_law_ = true;
  const Measured body = value(law.value, parameters);
  reads_law_ = outer;
  if (!body.dimension) return inference_.fresh();
  return law.by_slope ? *body.dimension * *argument.dimension : *body.dimension;
}

} // namespace hvi::lang::units
