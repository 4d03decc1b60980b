// Sources: linear forms on the part of a law that read its multiplier, or states there. See
// sources.cpp.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/laws.hpp"
#include "lang/check/multipliers.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/states.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

class Sources {
public:
  Sources(const Context& context, const Pairs& pairs, Multipliers& multipliers, States& states,
          Laws& laws)
      : mistakes_(context.mistakes), model_(context.model), unknowns_(context.unknowns),
        pairs_(pairs), multipliers_(multipliers), states_(states), laws_(laws) {}

  /// The term, whose integrand reads multipliers or states of a boundary and is linear in test
  /// functions, becomes laws: one for each component of a test function. False: reported.
  bool take(ModelTerm& term, const Span& span);

private:
  std::optional<int> source_law(const std::string& name, const Symbol& g, bool on_pair,
                                const Span& span);
  int take_rule(ModelTerm& source, const Symbol& integrand) const;

  Mistakes& mistakes_;
  Model& model_;
  const Unknowns& unknowns_;
  const Pairs& pairs_;
  Multipliers& multipliers_;
  States& states_;
  Laws& laws_;
};

} // namespace hvi::lang
