// What the terms of the inequality have to be together: an equation for each unknown, one law on a
// part, symmetry.
#pragma once

#include "lang/check/context.hpp"

#include <string>

namespace hvi::lang {

class FormChecks {
public:
  explicit FormChecks(const Context& context)
      : mistakes_(context.mistakes), model_(context.model), unknowns_(context.unknowns) {}

  void check_relation(const ast::Find& find);
  /// W0103 where the forms on one part, summed for u and for u', are not symmetric: compared at a
  /// few places and values by their second derivatives, a(w, v) against a(v, w).
  void check_symmetry();
  void check_one_law_per_part();
  /// What laws read of other laws is one number.
  void check_multipliers_read();
  /// Has each unknown an equation, and what that asks for?
  void check_clauses(const ast::Find& find);

private:
  void pairs_of_elements(const ast::Find& find);

  Mistakes& mistakes_;
  const Model& model_;
  const Unknowns& unknowns_;
};

} // namespace hvi::lang
