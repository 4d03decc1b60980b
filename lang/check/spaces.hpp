// Spaces as they are declared, and the space of the problem that the find statement makes of them.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/parts.hpp"

#include <optional>
#include <vector>

namespace hvi::lang {

/// Which component of a vector in this dimension is called so.
std::optional<int> component_index(const ast::Name& name, int dim);

class Spaces {
public:
  Spaces(const Context& context, Parts& parts, Pairs& pairs)
      : mistakes_(context.mistakes), names_(context.names), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator), parts_(parts), pairs_(pairs) {}

  /// Its index in spaces_.
  std::optional<int> space(const ast::Space& space);
  /// Into the model: the space of the unknown, or the product of those of all.
  void take_unknowns(const ast::Find& find);

private:
  std::optional<solver::DirichletSpec> zero_condition(const ast::ZeroCondition& zero, bool vector);
  std::optional<int> component_of_space(const std::optional<ast::Name>& written, bool vector);
  std::optional<solver::PeriodicSpec> periodic_condition(const ast::PeriodicCondition& periodic,
                                                         bool vector);
  void refuse_again(const char* what, solver::Origin now, solver::Origin before);
  bool space_domain(const ast::Name& written, int declaration, solver::SpaceSpec& spec);

  Mistakes& mistakes_;
  Names& names_;
  Model& model_;
  Unknowns& unknowns_;
  Evaluator& evaluator_;
  Parts& parts_;
  Pairs& pairs_;
  std::vector<solver::SpaceSpec> declared_; ///< as declared; SpaceValue is an index
};

} // namespace hvi::lang
