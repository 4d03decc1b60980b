// Numbers of a report: integrals, extremes and reactions of parts.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/parts.hpp"
#include "lang/check/states.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

/// Is the value made of integrals, extremes or reactions, which are numbers of a whole row?
bool has_probes(const Symbol& value);

class Probes {
public:
  Probes(const Context& context, Parts& parts, Pairs& pairs, States& states)
      : mistakes_(context.mistakes), names_(context.names), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator), at_hand_(context.at_hand),
        parts_(parts), pairs_(pairs), states_(states) {}

  /// integral(part, expression) in a report.
  Value integral_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  /// largest(part, expression), smallest(part, expression).
  Value extreme_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                     const Scope& scope);
  /// reaction(part), reaction(part, theta): a probe for each component of the unknown.
  Value reaction_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  /// Into the report; returns its index there.
  int add(solver::Probe probe);

private:
  std::optional<int> reported_part(const ast::Expr& e, const std::string& what);
  std::optional<solver::Probe> probe_on_part(const ast::Expr& e, const std::string& what,
                                             const ast::Expr& part, const ast::Expr& of,
                                             const Scope& scope);
  Value number_of(solver::Probe probe);
  std::optional<int> unknown_given(const ast::Expr& e, const std::string& what);

  Mistakes& mistakes_;
  const Names& names_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Parts& parts_;
  Pairs& pairs_;
  States& states_;
};

} // namespace hvi::lang
