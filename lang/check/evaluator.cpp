#include "lang/check/evaluator.hpp"

#include "lang/diag/suggest.hpp"
#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::lang {

std::optional<Field> Evaluator::field(const ast::Expr& e, const Scope& scope) {
  Value value = expr(e, scope);
  if (auto* f = std::get_if<Field>(&value)) return std::move(*f);
  if (is_poison(value)) return std::nullopt;
  std::string help;
  if (std::holds_alternative<FunctionValue>(value))
    help = "call it: write its arguments in `(...)`";
  if (std::holds_alternative<LawValue>(value))
    help = "a superpotential stands as `j^0(u.nu; v.nu)`";
  if (std::holds_alternative<KernelValue>(value)) help = "a kernel stands in `history(C, eps(u))`";
  mistakes_.error("E0306", e.span,
                  fmt::format("a number or tensor is expected here, not {}", describe(value)),
                  help);
  return std::nullopt;
}

std::optional<Field> Evaluator::scalar(const ast::Expr& e, const Scope& scope) {
  auto f = field(e, scope);
  if (!f) return std::nullopt;
  if (f->rank == 0 && !f->law_vector) return f;
  mistakes_.error("E0306", e.span, fmt::format("a scalar is expected here, not {}", describe(*f)));
  return std::nullopt;
}

std::optional<double> Evaluator::constant(const ast::Expr& e, const std::string& what) {
  Scope scope;
  scope.what = what;
  auto f = scalar(e, scope);
  if (!f) return std::nullopt;
  if (f->scalar().is_constant() && std::isfinite(f->scalar().value())) return f->scalar().value();
  mistakes_.error("E0407", e.span, fmt::format("{} must be a finite number", what));
  return std::nullopt;
}

std::optional<int> Evaluator::positive_integer(const ast::Expr& e, const std::string& what) {
  auto v = constant(e, what);
  if (!v) return std::nullopt;
  if (*v >= 1 && *v == std::floor(*v) && *v <= 1e9) return static_cast<int>(*v);
  mistakes_.error("E0406", e.span,
                  fmt::format("{} must be a positive whole number, not {}", what, *v));
  return std::nullopt;
}

std::optional<std::vector<double>> Evaluator::constant_list(const ast::Expr& e,
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
    if (!is_poison(v))
      mistakes_.error("E0306", e.span, fmt::format("expected a list `[...]` for {}", what));
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

std::optional<std::string> Evaluator::word(const ast::Expr& e, const std::string& what,
                                           const std::vector<std::string>& allowed) {
  std::string text, declared_as;
  if (const auto* r = std::get_if<ast::Reference>(&e.node)) {
    const int index = names_.find(r->name);
    text = r->name;
    if (index >= 0) {
      const Value& value = value_of(index, e.span);
      if (is_poison(value)) return std::nullopt;
      if (const auto* w = std::get_if<Word>(&value))
        text = w->text;
      else
        declared_as = ", which is " + describe_with_number(value);
    }
  } else if (const auto* s = std::get_if<ast::String>(&e.node)) {
    text = s->text;
  } else {
    mistakes_.error("E0316", e.span,
                    fmt::format("{} is one of: {}", what, solver::joined(allowed)));
    return std::nullopt;
  }
  if (std::find(allowed.begin(), allowed.end(), text) != allowed.end()) return text;
  const std::string near = did_you_mean(text, allowed);
  mistakes_.error("E0316", e.span, fmt::format("unknown {} `{}`{}", what, text, declared_as),
                  near.empty() ? fmt::format("one of: {}", solver::joined(allowed)) : near);
  return std::nullopt;
}

std::optional<std::vector<const ast::Expr*>>
Evaluator::match(const ast::Expr& e, const ast::Call& call, const std::string& callee,
                 const std::vector<std::string>& names, std::size_t required) {
  std::vector<const ast::Expr*> out(names.size(), nullptr);
  std::size_t position = 0;
  bool good = true;
  for (const ast::Argument& argument : call.arguments) {
    std::size_t place = names.size();
    if (argument.name) {
      place = std::find(names.begin(), names.end(), argument.name->text) - names.begin();
      if (place == names.size()) {
        if (names_.is_silent(argument.name->text)) return std::nullopt;
        const std::string near = did_you_mean(argument.name->text, names);
        mistakes_.error("E0304", argument.name->span,
                        fmt::format("`{}` has no argument `{}`", callee, argument.name->text),
                        near.empty() ? fmt::format("its arguments: {}", solver::joined(names))
                                     : near);
        good = false;
        continue;
      }
    } else {
      place = position++;
      if (place >= names.size()) {
        mistakes_.error("E0305", argument.span,
                        fmt::format("`{}` takes {} argument{}", callee, names.size(),
                                    names.size() == 1 ? "" : "s"),
                        fmt::format("its arguments: {}", solver::joined(names)));
        return std::nullopt;
      }
    }
    if (out[place]) {
      mistakes_.error("E0305", argument.span,
                      fmt::format("argument `{}` of `{}` is given twice", names[place], callee));
      good = false;
      continue;
    }
    out[place] = &argument.value;
  }
  if (!good) return std::nullopt;
  for (std::size_t i = 0; i < required; ++i)
    if (!out[i]) {
      mistakes_.error("E0305", e.span,
                      fmt::format("`{}` needs its argument `{}`", callee, names[i]));
      return std::nullopt;
    }
  return out;
}

Span item_span(const ast::Expr& list, std::size_t i) {
  const auto* l = std::get_if<ast::List>(&list.node);
  return l && i < l->items.size() ? l->items[i].span : list.span;
}

} // namespace hvi::lang
