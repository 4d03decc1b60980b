// What the terms of the inequality have to be together: an equation for each unknown, one law on a
// part, symmetry.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/pairs.hpp"

#include <string>

namespace hvi::lang {

class FormChecks {
public:
  FormChecks(const Context& context, Pairs& pairs)
      : mistakes_(context.mistakes), model_(context.model), unknowns_(context.unknowns),
        pairs_(pairs) {}

  void check_relation(const ast::Find& find);
  void check_symmetry();
  void check_one_law_per_part();
  void check_clauses(const ast::Find& find);

private:
  void pairs_of_elements(const ast::Find& find);
  void of_one_unknown();

  Mistakes& mistakes_;
  Model& model_;
  Unknowns& unknowns_;
  Pairs& pairs_;
};

} // namespace hvi::lang
