// Expressions: from the tree to symbolic values.
#include "lang/check/builtins.hpp"
#include "lang/check/checker.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::lang {

namespace {

using solver::Op;

/// Index 0..2 of x, y, z; nothing for other words.
std::optional<int> axis_of(const std::string& member) {
  if (member.size() != 1 || member[0] < 'x' || member[0] > 'z') return std::nullopt;
  return member[0] - 'x';
}

} // namespace

Value Checker::expr(const ast::Expr& e, const Scope& scope) {
  if (evaluations_ >= most_evaluations_) return Poison{};
  if (++evaluations_ == most_evaluations_ && !too_deep_) {
    error("E0607", e.span, fmt::format("more than {} expressions are evaluated", most_evaluations_),
          "functions that call each other several times multiply: give results a name");
    return Poison{};
  }
  if (!may_go_deeper(e.span, depth_)) return Poison{};
  ++depth_;
  const int outer = std::exchange(built_, 0);
  Value value = expr_node(e, scope);
  --depth_;
  if (auto* f = std::get_if<Field>(&value)) {
    f->depth = std::max(f->depth, built_ + 1);
    if (f->depth > 1000 && is_constant(*f)) f->depth = 0; // folded: nothing is left of it
    built_ = std::max(outer, f->depth);
    if (!may_go_deeper(e.span, f->depth)) return Poison{};
  } else {
    built_ = outer;
  }
  return value;
}

/// False (reported once) for what is so deep that recursive functions would exhaust the stack:
/// chains of declarations, and functions of functions, which build deep expressions from shallow
/// ones.
bool Checker::may_go_deeper(const Span& span, int depth) {
  constexpr int deepest = 2000;
  if (depth < deepest) return true;
  if (!std::exchange(too_deep_, true))
    error("E0216", span, fmt::format("more than {} values stand inside each other", deepest),
          "shorten the chain of names or functions that leads here");
  return false;
}

Value Checker::expr_node(const ast::Expr& e, const Scope& scope) {
  return std::visit(
      Overloaded{[&](const ast::Number& n) -> Value {
                   // NaN: the lexer has complained about it.
                   return std::isnan(n.value) ? Value(Poison{}) : Value(scalar_field(n.value));
                 },
                 [&](const ast::Quantity& q) -> Value {
                   auto f = scalar(*q.value, scope);
                   const auto unit = options_.units.find(q.unit.text);
                   if (!f || unit == options_.units.end()) return Poison{}; // unknown: reported
                   const UnitFactor& one = unit->second;
                   const auto in_units = [&](const Symbol& s) { return s * one.times / one.over; };
                   f->components.front() = in_units(f->scalar());
                   if (f->series)
                     f->series->of_place.front() = in_units(f->series->of_place.front());
                   f->materials = scaled(std::move(f->materials), one.times / one.over);
                   for (LawUse& use : f->laws) use.factor = in_units(use.factor);
                   return *f;
                 },
                 [&](const ast::String& s) -> Value { return TextValue{s.text}; },
                 [&](const ast::Reference& r) -> Value { return reference(e, r.name, scope); },
                 [&](const ast::List& l) -> Value { return list(e, l, scope); },
                 [&](const ast::Negate& n) -> Value {
                   auto f = field(*n.operand, scope);
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
                 [&](const ast::Call& c) -> Value { return call(e, c, scope); },
                 [&](const ast::Clarke& c) -> Value { return clarke(e, c, scope); }},
      e.node);
}

std::optional<Field> Checker::field(const ast::Expr& e, const Scope& scope) {
  Value value = expr(e, scope);
  if (auto* f = std::get_if<Field>(&value)) return std::move(*f);
  if (is_poison(value)) return std::nullopt;
  std::string help;
  if (std::holds_alternative<FunctionValue>(value))
    help = "call it: write its arguments in `(...)`";
  if (std::holds_alternative<LawValue>(value))
    help = "a superpotential stands as `j^0(u.nu; v.nu)`";
  if (std::holds_alternative<KernelValue>(value)) help = "a kernel stands in `history(C, eps(u))`";
  error("E0306", e.span,
        fmt::format("a number or tensor is expected here, not {}", describe(value)), help);
  return std::nullopt;
}

std::optional<Field> Checker::scalar(const ast::Expr& e, const Scope& scope) {
  auto f = field(e, scope);
  if (!f) return std::nullopt;
  if (f->rank == 0 && !f->law_vector) return f;
  error("E0306", e.span, fmt::format("a scalar is expected here, not {}", describe(*f)));
  return std::nullopt;
}

Value Checker::binary(const ast::Expr& e, const ast::Binary& b, const Scope& scope) {
  auto left = field(*b.left, scope);
  auto right = field(*b.right, scope);
  if (!left || !right) return Poison{};
  std::optional<Field> out;
  switch (b.op) {
  case ast::BinaryOp::add:
  case ast::BinaryOp::subtract:
    out = add(e, b, std::move(*left), std::move(*right), scope);
    break;
  case ast::BinaryOp::multiply:
    out = multiply(e, b, *left, *right, scope);
    break;
  case ast::BinaryOp::divide:
    out = divide(e, b, *left, *right, scope);
    break;
  case ast::BinaryOp::contract:
    out = contract(e, b, *left, *right, scope);
    break;
  case ast::BinaryOp::power:
    out = power(e, *left, *right, scope);
    break;
  }
  return out ? Value(std::move(*out)) : Value(Poison{});
}

Value Checker::list(const ast::Expr& e, const ast::List& l, const Scope& scope) {
  std::vector<Field> items;
  bool good = true;
  for (const ast::Expr& item : l.items) {
    auto f = field(item, scope);
    if (f) items.push_back(std::move(*f));
    good = good && f;
  }
  if (!good || items.empty()) return Poison{};
  Field out;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Field& item = items[i];
    if (!same_shape(item, items[0]) || item.law_vector || !item.laws.empty()) {
      error("E0307", l.items[i].span,
            fmt::format("the entries of a list have one shape: {} beside {}", describe(item),
                        describe(items[0])));
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
    if (out.components.size() != wanted || n != tensor_dim()) {
      error("E0307", e.span,
            fmt::format("a fourth-order tensor {0} is a {1} x {1} x {1} x {1} list",
                        model_.mesh.axisymmetric ? std::string("in a body of revolution")
                                                 : fmt::format("in {}D", model_.dim),
                        tensor_dim()));
      return Poison{};
    }
    out.columns = n;
    if (twists(e.span, out)) return Poison{};
  }
  return out;
}

Value Checker::cases(const ast::Expr& e, const ast::Cases& c, const Scope& scope) {
  // A law is looked at case by case, on both sides of each: the work grows with their square.
  constexpr std::size_t most_cases_of_law = 256;
  if (scope.law && c.cases.size() > most_cases_of_law) {
    error("E0216", e.span,
          fmt::format("a superpotential with {} cases; {} are the most", c.cases.size(),
                      most_cases_of_law),
          "a slope with many pieces is a table: `table(\"slope.csv\", r)`");
    return Poison{};
  }
  auto otherwise = field(*c.otherwise, scope);
  std::vector<std::pair<std::optional<Symbol>, std::optional<Field>>> rows;
  for (const ast::Case& row : c.cases)
    rows.emplace_back(condition(row.condition, scope), field(row.value, scope));
  if (!otherwise) return Poison{};
  if (scope.law && laws_at_hand_.size() == 1) {
    LawCases here;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!rows[i].first) break;
      here.conditions.push_back(*rows[i].first);
      here.places.push_back(c.cases[i].condition.span);
      here.values.push_back(c.cases[i].value.span);
    }
    here.values.push_back(c.otherwise->span);
    if (here.conditions.size() == rows.size()) law_cases_.push_back(std::move(here));
  }
  Field out = *otherwise;
  out.series.reset();
  out.materials.clear();
  for (std::size_t i = rows.size(); i-- > 0;) {
    auto& [when, value] = rows[i];
    if (!when || !value) return Poison{};
    if (!same_shape(*value, out)) {
      error("E0307", c.cases[i].value.span,
            fmt::format("all cases have one shape: {} beside {}", describe(*value), describe(out)));
      return Poison{};
    }
    if (!value->laws.empty() || !out.laws.empty() || value->by_slope || out.by_slope) {
      error("E0306", e.span, "superpotentials cannot be chosen by cases",
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

std::optional<Symbol> Checker::condition(const ast::Condition& c, const Scope& scope) {
  return std::visit(
      Overloaded{
          [&](const ast::Compare& cmp) { return compare(cmp, scope); },
          [&](const ast::Inside& in) -> std::optional<Symbol> {
            if (!scope.position) {
              error("E0309", c.span, fmt::format("`inside` cannot be used in {}", scope.what));
              return std::nullopt;
            }
            auto part = part_index(in.part);
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

std::optional<Symbol> Checker::compare(const ast::Compare& c, const Scope& scope) {
  auto word_of = [&](const ast::Expr& e) -> std::optional<std::string> {
    const auto* r = std::get_if<ast::Reference>(&e.node);
    if (!r) return std::nullopt;
    Value v = reference(e, r->name, scope);
    if (auto* w = std::get_if<Word>(&v)) return w->text;
    return std::nullopt;
  };
  if (c.op == ast::CompareOp::equal || c.op == ast::CompareOp::not_equal) {
    auto left = word_of(c.left);
    auto right = left ? word_of(c.right) : std::nullopt;
    if (left && right)
      return Symbol((*left == *right) == (c.op == ast::CompareOp::equal) ? 1.0 : 0.0);
  }
  auto left = scalar(c.left, scope);
  auto right = scalar(c.right, scope);
  if (!left || !right) return std::nullopt;
  Field degrees;
  const Span whole = join(c.left.span, c.right.span);
  if (!nonlinear_degrees(whole, "this comparison", {&*left, &*right}, degrees, scope))
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

Value Checker::prime(const ast::Expr& e, const ast::Prime& p, const Scope& scope) {
  const auto* inner = std::get_if<ast::Prime>(&p.operand->node);
  const ast::Expr& operand = inner ? *inner->operand : *p.operand;
  const int order = inner ? 2 : 1;
  const auto* r = std::get_if<ast::Reference>(&operand.node);
  const int unknown = r ? unknown_named(r->name) : -1;
  if (unknown < 0) {
    if (is_poison(expr(operand, scope))) return Poison{};
    error("E0303", p.op,
          fmt::format("only the unknown{} has a time derivative",
                      find_ ? fmt::format(" {}", names_of_unknowns()) : ""),
          "write `u'` and take `eps(u')` of it");
    return Poison{};
  }
  if (is_poison(reference(operand, r->name, scope))) return Poison{};
  if (!find_->time) {
    error(
        "E0412", e.span,
        fmt::format("`{}{}` needs a problem in time", r->name, order == 2 ? "''" : "'"),
        "add `for t in [0, T] by N steps from u = 0` to the find statement, or leave the term out");
    return Poison{};
  }
  if (order == 2 && scope.report && !has_second_derivative()) {
    error("E0431", e.span, fmt::format("`{}''` in a problem without inertia", r->name),
          "it is known where a form has it: `integral(body, rho*dot(u'', v))`");
    return Poison{};
  }
  return value_of_unknown(unknown, order, false, scope);
}

Value Checker::member(const ast::Expr& e, const ast::Member& m, const Scope& scope) {
  if (const auto* r = std::get_if<ast::Reference>(&m.object->node)) {
    const int index = find_declaration(r->name);
    if (index >= 0 && !scope.locals.count(r->name)) {
      const ast::Statement& statement = *declarations_[index].statement;
      if (std::holds_alternative<ast::Superpotential>(statement)) {
        value_of(index, m.object->span);
        return law_member(m, index, scope);
      }
    }
  }
  Value object = expr(*m.object, scope);
  if (is_poison(object)) return Poison{};
  if (auto* f = std::get_if<Field>(&object)) return field_member(e, m, *f, scope);
  if (std::holds_alternative<MeshValue>(object) || std::holds_alternative<PartValue>(object)) {
    auto spec = region_path(e);
    if (!spec) return Poison{};
    error("E0306", e.span, "a part is used by its name", "declare it: `part p = ...`");
    return Poison{};
  }
  error("E0303", m.member.span,
        fmt::format("{} has no member `{}`", describe(object), m.member.text));
  return Poison{};
}

namespace {

/// A number without components yet, of the same functions as f.
Field number_like(const Field& f) {
  Field out;
  out.test = f.test;
  out.trial = f.trial;
  out.rate = f.rate;
  out.acceleration = f.acceleration;
  out.memory = f.memory;
  out.read = f.read;
  return out;
}

} // namespace

Value Checker::field_member(const ast::Expr&, const ast::Member& m, const Field& f,
                            const Scope& scope) {
  const std::string& name = m.member.text;
  auto no_member = [&](const std::vector<std::string>& members) -> Value {
    error("E0303", m.member.span, fmt::format("{} has no member `{}`", describe(f), name),
          members.empty()
              ? (f.rank == 0 && f.rows == 1 && name.size() == 1 ? "products are `*`, `:` and `dot`"
                                                                : "")
              : did_you_mean(name, members));
    return Poison{};
  };
  if (f.law_vector || f.rank == 0 || f.rank > 2) return no_member({});
  Field out = number_like(f);
  if (f.rank == 2) { // sigma.xy
    if (name.size() != 2) return no_member({"xx", "yy", "xy"});
    const auto i = axis_of(name.substr(0, 1)), j = axis_of(name.substr(1, 1));
    if (!i || !j) return no_member({"xx", "yy", "xy"});
    if (*i == 2 && *j == 2 && f.rows == 2 && f.test == Degree::none && !f.across.empty()) {
      out.components = f.across; // in plane strain
      return out;
    }
    if (*i >= f.rows || *j >= f.columns) {
      error("E0315", m.member.span, fmt::format("{} has no component `{}`", describe(f), name));
      return Poison{};
    }
    out.components = {f.components[*i * f.columns + *j]};
    return out;
  }
  if (const auto i = axis_of(name)) {
    if (*i >= f.rows) {
      error("E0315", m.member.span, fmt::format("{} has no component `{}`", describe(f), name));
      return Poison{};
    }
    out.components = {f.components[*i]};
    return out;
  }
  if (name != "nu" && name != "tau") return no_member({"nu", "tau", "x", "y", "z"});
  if (f.rows != model_.dim) return no_member({"x", "y", "z"});
  return part_along_normal(m, f, scope);
}

/// `f.nu` and `f.tau`.
Value Checker::part_along_normal(const ast::Member& m, const Field& f, const Scope& scope) {
  const std::string& name = m.member.text;
  const bool on_pair = has_jumps(f.components.front()); // where that is, there is a normal
  const bool read = on_pair || f.read; // the part that the law acts on has one, or it is said
  if (!scope.normal && !read) {
    // One wrong part makes every `.nu` of its integral wrong: one error says it.
    if (scope.test && std::exchange(normal_missed_, true)) return Poison{};
    error("E0309", m.member.span,
          fmt::format("`.{}` cannot be used in {}: there is no normal", name, scope.what),
          "normal and tangential parts belong to integrals over parts of the boundary");
    return Poison{};
  }
  std::vector<Symbol> n;
  Symbol along = 0.0;
  for (int i = 0; i < model_.dim; ++i) {
    n.push_back(Symbol::variable(solver::slot::normal(i)));
    along = along + f.components[i] * n[i];
  }
  Field out = number_like(f);
  if (name == "nu") {
    out.components = {along};
    return out;
  }
  out.rank = 1;
  out.rows = f.rows;
  for (int i = 0; i < model_.dim; ++i) out.components.push_back(f.components[i] - along * n[i]);
  return out;
}

std::optional<double> Checker::constant(const ast::Expr& e, const std::string& what) {
  Scope scope;
  scope.what = what;
  auto f = scalar(e, scope);
  if (!f) return std::nullopt;
  if (f->scalar().is_constant() && std::isfinite(f->scalar().value())) return f->scalar().value();
  error("E0407", e.span, fmt::format("{} must be a finite number", what));
  return std::nullopt;
}

std::optional<int> Checker::positive_integer(const ast::Expr& e, const std::string& what) {
  auto v = constant(e, what);
  if (!v) return std::nullopt;
  if (*v >= 1 && *v == std::floor(*v) && *v <= 1e9) return static_cast<int>(*v);
  error("E0406", e.span, fmt::format("{} must be a positive whole number, not {}", what, *v));
  return std::nullopt;
}

std::optional<std::vector<double>> Checker::constant_list(const ast::Expr& e,
                                                          const std::string& what) {
  const auto* l = std::get_if<ast::List>(&e.node);
  if (!l) {
    Scope scope;
    scope.what = what;
    Value v = expr(e, scope);
    const auto* f = std::get_if<Field>(&v);
    if (f && f->rank == 1 && is_constant(*f)) {
      std::vector<double> out;
      for (const Symbol& c : f->components) out.push_back(c.value());
      return out;
    }
    if (!is_poison(v)) error("E0306", e.span, fmt::format("{} is a list `[...]`", what));
    return std::nullopt;
  }
  std::vector<double> out;
  bool good = true;
  for (const ast::Expr& item : l->items) {
    auto v = constant(item, what);
    good = good && v;
    if (v) out.push_back(*v);
  }
  return good ? std::optional(out) : std::nullopt;
}

Span item_span(const ast::Expr& list, std::size_t i) {
  const auto* l = std::get_if<ast::List>(&list.node);
  return l && i < l->items.size() ? l->items[i].span : list.span;
}

std::optional<std::string> Checker::word(const ast::Expr& e, const std::string& what,
                                         const std::vector<std::string>& allowed) {
  std::string text;
  if (const auto* r = std::get_if<ast::Reference>(&e.node)) {
    const int index = find_declaration(r->name);
    text = r->name;
    if (index >= 0) {
      const Value& value = value_of(index, e.span);
      if (const auto* w = std::get_if<Word>(&value)) text = w->text;
      if (is_poison(value)) return std::nullopt;
    }
  } else if (const auto* s = std::get_if<ast::String>(&e.node)) {
    text = s->text;
  } else {
    error("E0316", e.span, fmt::format("{} is one of: {}", what, fmt::join(allowed, ", ")));
    return std::nullopt;
  }
  if (std::find(allowed.begin(), allowed.end(), text) != allowed.end()) return text;
  const std::string near = did_you_mean(text, allowed);
  error("E0316", e.span, fmt::format("unknown {} `{}`", what, text),
        near.empty() ? fmt::format("one of: {}", fmt::join(allowed, ", ")) : near);
  return std::nullopt;
}

void Checker::error(std::string_view code, const Span& span, std::string message, std::string help,
                    std::string label) {
  // What goes wrong within the library is a mistake of the script's call.
  const auto in_library = [&](const Span& place) {
    return std::any_of(programs_.begin(), programs_.end(),
                       [&](const auto& p) { return p.library && p.file == place.file; });
  };
  Span place = span;
  if (in_library(span))
    for (const Span& call : calls_)
      if (!in_library(call)) place = call;
  Diagnostic d = diagnose(code, place, std::move(message));
  if (place.file != span.file) d.secondary.push_back({span, "met here"});
  d.help = std::move(help);
  d.label = std::move(label);
  diagnostics_.add(std::move(d));
}

} // namespace hvi::lang
