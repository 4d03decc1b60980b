#include "lang/check/multipliers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

bool Multipliers::take_on_part(const Span& span, int part, Symbol& expression) {
  std::vector<std::pair<std::string, int>> applications; // law, part
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) applications.emplace_back(use.name, term.part);
  std::vector<std::pair<solver::Slot, Symbol>> rename;
  for (const solver::Slot s : solver::slots_of(expression)) {
    if (!slot::is_multiplier(s)) continue;
    const auto& [law, where] = applications[static_cast<std::size_t>(slot::term_of(s))];
    if (where == part) continue;
    const auto here = std::find(applications.begin(), applications.end(), std::pair(law, part));
    if (here == applications.end()) {
      mistakes_.error("E0428", span,
                      fmt::format("`{}` does not act on `{}`, where this is asked", law,
                                  model_.parts[part].name),
                      "a multiplier is known on the part of its law only");
      return false;
    }
    rename.emplace_back(s, Symbol::variable(slot::multiplier(
                               static_cast<int>(here - applications.begin()), slot::row_of(s))));
  }
  expression = substitute(expression, rename);
  return true;
}

} // namespace hvi::lang
