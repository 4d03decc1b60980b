#include "lang/check/calls.hpp"

#include "lang/check/builtins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace {

constexpr std::size_t deepest_call = 100;

} // namespace

Value Calls::call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  const auto* r = std::get_if<ast::Reference>(&c.callee->node);
  if (!r) {
    mistakes_.error("E0310", c.callee->span, "only names are called",
                    "parts are declared: `part roof = slab.group(\"roof\")`");
    return Poison{};
  }
  if (auto local = scope.locals.find(r->name); local != scope.locals.end()) {
    if (!is_poison(local->second))
      mistakes_.error(
          "E0310", c.callee->span,
          fmt::format("`{}` is {} and cannot be called", r->name, describe(local->second)));
    return Poison{};
  }
  const int index = names_.find(r->name);
  if (index < 0) {
    if (is_function_name(r->name)) return call_built_in(e, c, r->name, scope);
    if (unknowns_.named(r->name) >= 0 || unknowns_.tested_by(r->name) >= 0) {
      mistakes_.error("E0310", c.callee->span,
                      fmt::format("`{}` is not a function to be called", r->name),
                      "a value at a point stands in `report`: `u.y at [1, 0]`");
      return Poison{};
    }
    return names_.report_unknown(c.callee->span, r->name, scope);
  }
  Value value = evaluator_.value_of(index, c.callee->span);
  if (const auto* fn = std::get_if<FunctionValue>(&value))
    return call_function(e, c, fn->declaration, scope);
  if (const auto* law = std::get_if<LawValue>(&value)) {
    if (find_built_in(r->name) == nullptr) return laws_.call(e, c, law->declaration, scope);
    const auto built_in = leaves_meaning(c, scope);
    if (!built_in) return Poison{};
    return *built_in ? call_built_in(e, c, r->name, scope)
                     : laws_.call(e, c, law->declaration, scope);
  }
  if (is_poison(value)) return Poison{};
  std::string help;
  if (std::holds_alternative<KernelValue>(value)) help = "a kernel stands in `history(C, eps(u))`";
  mistakes_.error("E0310", c.callee->span,
                  fmt::format("`{}` is {} and cannot be called", r->name, describe(value)), help);
  return Poison{};
}

/// A superpotential called `jump`, as in the module `contact`, leaves jump(u) its meaning, also in
/// the body of another law, which calls it with what is made of its argument. Nothing: reported.
std::optional<bool> Calls::leaves_meaning(const ast::Call& c, const Scope& scope) {
  if (!scope.law) return true;
  if (c.arguments.size() != 1 || c.arguments[0].name) return false;
  const auto of = evaluator_.field(c.arguments[0].value, scope);
  if (!of) return std::nullopt;
  return of->read && std::ranges::none_of(of->components, [](const Symbol& component) {
           return component.depends_on(solver::slot::argument(0));
         });
}

Value Calls::call_function(const ast::Expr& e, const ast::Call& c, int declaration,
                           const Scope& scope) {
  const auto& fn = std::get<ast::Fn>(*names_[declaration].statement);
  std::vector<std::string> names;
  for (const ast::Name& p : fn.parameters) names.push_back(p.text);
  auto args = evaluator_.match(e, c, fn.name.text, names, names.size());
  if (!args) return Poison{};
  Scope inner = scope.without_locals();
  for (std::size_t i = 0; i < names.size(); ++i) {
    Value v = evaluator_.expr(*(*args)[i], scope);
    if (is_poison(v)) return Poison{};
    inner.locals[names[i]] = std::move(v);
  }
  if (functions_at_hand_.size() >= deepest_call) {
    const auto& at_hand = functions_at_hand_;
    if (std::find(at_hand.begin(), at_hand.end(), declaration) != at_hand.end())
      mistakes_.error("E0313", c.callee->span, fmt::format("`{}` calls itself", fn.name.text));
    else if (!limits_.complained())
      mistakes_.error(
          "E0216", c.callee->span,
          fmt::format("functions call one another more than {} levels deep", deepest_call));
    return Poison{};
  }
  functions_at_hand_.push_back(declaration);
  mistakes_.enter_call(e.span, fn.value.span);
  Value out = evaluator_.expr(fn.value, inner);
  mistakes_.leave_call();
  functions_at_hand_.pop_back();
  return out;
}

Value Calls::call_built_in(const ast::Expr& e, const ast::Call& c, const std::string& name,
                           const Scope& scope) {
  switch (find_built_in(name)->kind) {
  case BuiltInKind::pointwise:
    return functions_.pointwise(e, c, name, scope);
  case BuiltInKind::differential:
    return functions_.differential(e, c, name, scope);
  case BuiltInKind::algebraic:
    return functions_.algebraic(e, c, name, scope);
  case BuiltInKind::tensor:
    if (name == "table") return series_.table_call(e, c, scope);
    if (name == "prony" || name == "prony_relaxation") return series_.prony_call(e, c, name, scope);
    if (name == "derivative") return series_.derivative_call(e, c, scope);
    return tensors_.tensor_call(e, c, name, scope);
  case BuiltInKind::memory:
    return memories_.history_call(e, c, scope);
  case BuiltInKind::interface:
    if (name == "jump" || name == "mean") return pair_calls_.jump_call(e, c, name, scope);
    if (name == "gap") return pair_calls_.gap_call(e, c, scope);
    mistakes_.error("E0306", e.span, "a pair is declared as a part",
                    "`part seam = pair(a.bottom, b.top)`");
    return Poison{};
  case BuiltInKind::mesh:
    mistakes_.error("E0306", e.span, "a mesh is declared by itself",
                    fmt::format("`mesh m = {}(...)`", name));
    return Poison{};
  case BuiltInKind::region:
    if (name == "integral") return probes_.integral_call(e, c, scope);
    if (name == "reaction") return probes_.reaction_call(e, c, scope);
    if (name == "largest" || name == "smallest") return probes_.extreme_call(e, c, name, scope);
    mistakes_.error("E0306", e.span,
                    name == "point" ? "a point is declared as a part" : "`inside` is a condition",
                    name == "point" ? "`part p = point(mesh, [0, 0])`" : "`| inside(part) -> ...`");
    return Poison{};
  }
  return Poison{};
}

} // namespace hvi::lang
