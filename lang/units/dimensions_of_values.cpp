#include "lang/units/dimensions_of_values.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace hvi::lang::units {

namespace {

constexpr long most_evaluations = 4'000'000; // the checker has refused what would need more

} // namespace

Measured DimensionsOfValues::value(const ast::Expr& e, const Locals& locals) {
  if (++evaluations_ > most_evaluations) return {};
  return value_of_node(e, locals);
}

Measured DimensionsOfValues::value_of_node(const ast::Expr& e, const Locals& locals) {
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
                 [&](const ast::Call& c) { return calls_.call(e, c, locals); },
                 [&](const ast::Clarke& c) { return calls_.clarke(c, locals); }},
      e.node);
}

/// Zero is zero in every unit, and what stands for infinity is infinite in every one.
Measured DimensionsOfValues::literal(double number) {
  constexpr double infinite = 1e300;
  const bool any = number == 0 || std::abs(number) >= infinite;
  return {any ? inference_.fresh() : Dimension{}, number};
}

Measured DimensionsOfValues::quantity(const ast::Quantity& q, const Locals& locals) {
  const Measured of = value(*q.value, locals);
  const auto unit = units_.read.find(q.unit.text);
  if (unit == units_.read.end()) return {};
  if (of.dimension && !inference_.unify(*of.dimension, Dimension{})) {
    mistakes_.report(
        diagnose("E0331", q.unit.span,
                 fmt::format("a unit behind what is in {} already", mistakes_.shown(*of.dimension)))
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

Measured DimensionsOfValues::reference(const std::string& name, const Locals& locals) {
  if (const auto local = locals.find(name); local != locals.end()) return local->second;
  NamedDimensions& names = names_;
  MeasuredDeclaration* declaration = names.declaration(name);
  if (declaration == nullptr && names.find != nullptr)
    for (std::size_t b = 0; b < names.find->unknowns.size(); ++b) {
      if (names.find->unknowns[b].unknown.text == name) return {names.of_unknown[b], {}};
      if (names.find->unknowns[b].test.text == name) return {names.of_test[b], {}};
    }
  if (const Measured own = built_in_name(name); own.dimension) return own;
  return declaration == nullptr ? Measured{} : declared(*declaration);
}

Measured DimensionsOfValues::built_in_name(const std::string& name) {
  if (name == "pi") return {Dimension{}, std::numbers::pi};
  if (name == "x" || name == "y" || name == "z") return {length(), {}};
  if (name == "t" || name == "lag") return {duration(), {}};
  if (name == "normal") return {Dimension{}, {}};
  if (name == "sigma") return {names_.stress(), {}};
  return {};
}

Measured DimensionsOfValues::declared(MeasuredDeclaration& named) {
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
    out.dimension = names_.state(s->name.text);
  }
  named.busy = false;
  named.value = out;
  return out;
}

Measured DimensionsOfValues::list(const ast::List& l, const Locals& locals) {
  Measured first;
  const ast::Expr* place = nullptr;
  for (const ast::Expr& item : l.items) {
    const Measured now = value(item, locals);
    if (!now.dimension) continue;
    if (place == nullptr)
      first = now, place = &item;
    else if (!mistakes_.same({&first, place}, {&now, &item}, "the entries of a list"))
      return {};
  }
  return {first.dimension, {}};
}

Measured DimensionsOfValues::binary(const ast::Binary& b, const Locals& locals) {
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
    if (!mistakes_.same({&left, &*b.left}, {&right, &*b.right},
                        adds ? "the sum" : "the difference"))
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

Measured DimensionsOfValues::power(const ast::Binary& b, const Measured& base,
                                   const Measured& exponent) {
  if (!mistakes_.wants_number(*b.right, exponent, "an exponent")) return {};
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
  if (!mistakes_.wants_number(*b.left, base, "what is raised to a power that changes")) return {};
  out.dimension = Dimension{};
  return out;
}

Measured DimensionsOfValues::member(const ast::Member& m, const Locals& locals) {
  if (const auto* r = std::get_if<ast::Reference>(&m.object->node)) {
    const bool law = names_.declared_as<ast::Superpotential>(r->name) != nullptr;
    if (law && !locals.contains(r->name)) return {names_.multiplier(r->name), {}};
  }
  return {value(*m.object, locals).dimension, {}};
}

Measured DimensionsOfValues::cases(const ast::Cases& c, const Locals& locals) {
  const Measured otherwise = value(*c.otherwise, locals);
  Measured out{otherwise.dimension, {}};
  for (const ast::Case& one : c.cases) {
    condition(one.condition, locals);
    const Measured now = value(one.value, locals);
    if (!out.dimension)
      out.dimension = now.dimension;
    else if (now.dimension && otherwise.dimension &&
             !mistakes_.same({&now, &one.value}, {&otherwise, &*c.otherwise}, "the cases"))
      return {};
  }
  return out;
}

void DimensionsOfValues::condition(const ast::Condition& c, const Locals& locals) {
  const auto all = [&](const std::vector<ast::Condition>& operands) {
    for (const ast::Condition& one : operands) condition(one, locals);
  };
  std::visit(
      Overloaded{
          [&](const ast::Compare& compare) {
            const Measured left = value(compare.left, locals);
            const Measured right = value(compare.right, locals);
            if (left.dimension && right.dimension)
              mistakes_.same({&left, &compare.left}, {&right, &compare.right}, "the comparison");
          },
          [&](const ast::Inside&) {}, [&](const ast::Not& n) { condition(*n.operand, locals); },
          [&](const ast::And& a) { all(a.operands); }, [&](const ast::Or& o) { all(o.operands); }},
      c.node);
}

void DimensionsOfValues::settle_powers() {
  for (std::size_t round = 0; round < powers_.size(); ++round)
    for (const auto& [base, power] : powers_)
      if (inference_.resolved(base).is_one() || inference_.resolved(power).is_one())
        inference_.unify(base, {}), inference_.unify(power, {});
  powers_.clear();
}

} // namespace hvi::lang::units
