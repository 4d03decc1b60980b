#include "lang/check/pair_calls.hpp"

#include <fmt/format.h>

#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;
using slot::is_field, slot::is_test;

Value PairCalls::jump_call(const ast::Expr& e, const ast::Call& c, const std::string& name,
                           const Scope& scope) {
  const auto args = evaluator_.match(e, c, name, {"u"}, 1);
  if (!args) return Poison{};
  auto f = evaluator_.field(*(*args)[0], scope);
  if (!f) return Poison{};
  const auto is_value = [](solver::Slot s) {
    return is_test(s) ? slot::is_value(s - slot::test(0))
                      : is_field(s) && !is_jump(s) && !slot::is_field_gradient(s);
  };
  std::vector<std::pair<solver::Slot, Symbol>> rename;
  bool good = f->rank <= 1 && !f->law_vector && f->laws.empty();
  for (const Symbol& component : f->components)
    for (const solver::Slot s : solver::slots_of(component)) {
      good = good && is_value(s);
      if (good) rename.emplace_back(s, Symbol::variable(name == "jump" ? jump_of(s) : mean_of(s)));
    }
  if (!good || rename.empty()) {
    mistakes_.error(
        "E0441", (*args)[0]->span,
        fmt::format("a {} is that of the unknown, its rate, a memory or the test function", name),
        fmt::format("`{0}(u).nu`, `{0}(u').tau`, `{0}(history(q, u)).nu`", name));
    return Poison{};
  }
  for (Symbol& component : f->components) component = substitute(component, rename);
  f->materials.clear();
  return *f;
}

Value PairCalls::gap_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  const auto args = evaluator_.match(e, c, "gap", {"pair"}, 1);
  if (!args) return Poison{};
  const auto* name = std::get_if<ast::Reference>(&(*args)[0]->node);
  const auto part = name ? parts_.index_of({name->name, (*args)[0]->span}) : std::nullopt;
  if (name && !part) return Poison{};
  if (part && !pairs_.is_pair(*part)) {
    pairs_.refuse_no_pair((*args)[0]->span, "a gap", *part);
    return Poison{};
  }
  if (!part) {
    mistakes_.error("E0441", (*args)[0]->span, "a gap is that of a pair, by its name",
                    "`part seam = pair(upper.bottom, lower.top)`, then `gap(seam)`");
    return Poison{};
  }
  if (scope.law || !(scope.test || scope.report)) {
    mistakes_.error(
        "E0441", e.span, fmt::format("a gap cannot be used in {}", scope.what),
        "it stands in the argument of a law: `wall^0(jump(u).nu - gap(seam); jump(v).nu)`, and in "
        "reports");
    return Poison{};
  }
  if (at_hand_.gap >= 0 && at_hand_.gap != *part) {
    mistakes_.error("E0441", e.span, "the gaps of two pairs in one place",
                    "on a pair its own gap is known only");
    return Poison{};
  }
  at_hand_.gap = *part;
  return scalar_field(Symbol::variable(slot::gap));
}

} // namespace hvi::lang
