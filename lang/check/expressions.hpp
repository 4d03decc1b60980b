// Expressions: from the tree to symbolic values.
#pragma once

#include "lang/check/calls.hpp"
#include "lang/check/context.hpp"
#include "lang/check/law_applications.hpp"
#include "lang/check/laws.hpp"
#include "lang/check/limits.hpp"
#include "lang/check/operators.hpp"
#include "lang/check/parts.hpp"
#include "lang/check/tensors.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

class Expressions {
public:
  Expressions(const Context& context, Limits& limits, Parts& parts, Operators& operators,
              Tensors& tensors, Laws& laws, LawApplications& applications, Calls& calls)
      : options_(context.options), mistakes_(context.mistakes), names_(context.names),
        find_(context.find), model_(context.model), unknowns_(context.unknowns),
        evaluator_(context.evaluator), at_hand_(context.at_hand), limits_(limits), parts_(parts),
        operators_(operators), tensors_(tensors), laws_(laws), applications_(applications),
        calls_(calls) {}

  Value expr(const ast::Expr& e, const Scope& scope);
  std::optional<Symbol> condition(const ast::Condition& c, const Scope& scope);

private:
  Value expr_node(const ast::Expr& e, const Scope& scope);
  Value binary(const ast::Expr& e, const ast::Binary& binary, const Scope& scope);
  Value list(const ast::Expr& e, const ast::List& list, const Scope& scope);
  Value cases(const ast::Expr& e, const ast::Cases& cases, const Scope& scope);
  std::optional<Symbol> compare(const ast::Compare& c, const Scope& scope);
  Value prime(const ast::Expr& e, const ast::Prime& prime, const Scope& scope);
  Value member(const ast::Expr& e, const ast::Member& member, const Scope& scope);
  Value field_member(const ast::Expr& e, const ast::Member& member, const Field& object,
                     const Scope& scope);
  Value part_along_normal(const ast::Member& m, const Field& f, const Scope& scope);

  const CheckOptions& options_;
  Mistakes& mistakes_;
  const Names& names_;
  const ast::Find* const find_;
  const Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Limits& limits_;
  Parts& parts_;
  Operators& operators_;
  Tensors& tensors_;
  Laws& laws_;
  LawApplications& applications_;
  Calls& calls_;
};

} // namespace hvi::lang
