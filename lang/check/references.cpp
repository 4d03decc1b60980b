#include "lang/check/references.hpp"

#include "lang/check/builtins.hpp"
#include "lang/check/stress.hpp"
#include "lang/syntax/parser.hpp"

#include <fmt/format.h>

#include <numbers>
#include <utility>

namespace hvi::lang {

namespace {

std::string visible_note(const Scope& scope) {
  return scope.what.empty() ? std::string() : fmt::format(" in {}", scope.what);
}

} // namespace

std::optional<Value> References::built_in_name(const ast::Expr& e, const std::string& name,
                                               const Scope& scope) {
  auto hidden = [&](const std::string& why, const std::string& help) -> Value {
    mistakes_.error("E0309", e.span,
                    fmt::format("`{}` cannot be used{}: {}", name, visible_note(scope), why), help);
    return Poison{};
  };
  if (name == "pi") return scalar_field(std::numbers::pi);
  if (name == "x" || name == "y" || name == "z") {
    const int axis = name[0] - 'x';
    if (!scope.position) return hidden("it must be the same everywhere", "");
    if (axis >= model_.dim) {
      mistakes_.error("E0315", e.span, fmt::format("there is no `{}` in {}D", name, model_.dim));
      return Poison{};
    }
    return scalar_field(Symbol::variable(solver::slot::x(axis)));
  }
  if (name == "t") {
    if (!scope.time)
      return hidden("it does not change in time",
                    scope.lag ? "a kernel of time and past time is written `kernel q(t, s) = ...`"
                              : "");
    return scalar_field(Symbol::variable(solver::slot::t));
  }
  if (name == "lag") {
    if (!scope.lag) return hidden("only kernels have a lag", "");
    return scalar_field(Symbol::variable(solver::slot::lag));
  }
  if (name == "normal") {
    if (!scope.normal) return hidden("only integrals over the boundary have a normal", "");
    std::vector<Symbol> n;
    for (int i = 0; i < model_.dim; ++i) n.push_back(Symbol::variable(solver::slot::normal(i)));
    return vector_field(std::move(n));
  }
  if (name == "sigma") {
    if (!scope.report && !scope.load)
      return hidden("it is a result",
                    "it may stand in `report`, in rates and in loads on the right");
    at_hand_.reads_stress = true;
    return stress(model_, unknowns_);
  }
  return std::nullopt;
}

Value References::hidden_state(const Span& span, int declaration, const Scope& scope) {
  names_[declaration].used = true;
  if (scope.test && !scope.source) { // to be read again when all laws are known
    at_hand_.source = true;
    return Poison{};
  }
  mistakes_.error(
      "E0309", span,
      fmt::format("the state `{}` cannot be used{}", names_[declaration].name, visible_note(scope)),
      "it stands in superpotentials, beside the unknown in the argument of a law, in loads on its "
      "part, in forms over cells, in rates and in `report`");
  return Poison{};
}

Value References::reference(const ast::Expr& e, const std::string& name, const Scope& scope) {
  if (auto local = scope.locals.find(name); local != scope.locals.end()) return local->second;
  const int unknown = unknowns_.named(name), tested = unknowns_.tested_by(name);
  if ((unknown >= 0 || tested >= 0) && names_.find(name) < 0) {
    const bool is_test = unknown < 0;
    if (is_test ? !scope.test : !(scope.unknown || scope.law)) {
      const bool one = find_->unknowns.size() == 1;
      mistakes_.error("E0309", e.span,
                      fmt::format("`{}` is {} {} of the inequality: it cannot be used{}", name,
                                  one       ? "the"
                                  : is_test ? "a"
                                            : "an",
                                  is_test ? "test function" : "unknown", visible_note(scope)));
      return Poison{};
    }
    if (!unknowns_.known) return Poison{};
    return unknowns_.value(is_test ? tested : unknown, 0, is_test, scope);
  }
  if (auto built_in = built_in_name(e, name, scope)) return *built_in;
  const int index = names_.find(name);
  if (index >= 0) {
    if (std::holds_alternative<ast::State>(*names_[index].statement) && !scope.states)
      return hidden_state(e.span, index, scope);
    return evaluator_.value_of(index, e.span);
  }
  if (is_word(name)) return Word{name};
  if (is_function_name(name)) {
    mistakes_.error("E0306", e.span,
                    fmt::format("`{}` is a function: it is called with arguments", name),
                    fmt::format("write `{}(...)`", name));
    return Poison{};
  }
  return names_.report_unknown(e.span, name, scope);
}

} // namespace hvi::lang
