// j^0(at; direction) in the inequality: what it sees, its rows, and whether its law can stand
// there.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/laws.hpp"
#include "lang/check/pairs.hpp"

#include <optional>
#include <set>
#include <string>

namespace hvi::lang {

class LawApplications {
public:
  LawApplications(const Context& context, Pairs& pairs, Laws& laws)
      : mistakes_(context.mistakes), names_(context.names), find_(context.find),
        model_(context.model), unknowns_(context.unknowns), evaluator_(context.evaluator),
        at_hand_(context.at_hand), pairs_(pairs), laws_(laws) {}

  Value clarke(const ast::Expr& e, const ast::Clarke& clarke, const Scope& scope);

private:
  std::optional<std::set<int>> law_fields(const ast::Clarke& clarke, const Field& at);
  std::optional<int> law_unknown(const ast::Clarke& clarke, const Field& at,
                                 const Field& direction);
  bool stands_before(const ast::Clarke& clarke, const Symbol& own, int field, int unknown);
  bool law_rows_of_sums(const ast::Clarke& clarke, const Field& at, const Field& direction,
                        const std::set<int>& fields, LawUse& use);
  bool law_rows(const ast::Clarke& clarke, const Field& at, const Field& direction, LawUse& use);
  std::optional<int> superpotential_of(const ast::Clarke& clarke, const Scope& scope);
  bool is_pair_of_law(const ast::Clarke& clarke, const std::string& law, const Field& at,
                      const Field& direction);
  std::optional<LawUse> law_use(const ast::Clarke& clarke, const Field& at, const Field& direction);
  bool can_stand_here(const ast::Clarke& clarke, int law, const Scope& scope);
  bool is_of_no_mean(const ast::Clarke& c, const Field& at, const Field& direction);

  Mistakes& mistakes_;
  const Names& names_;
  const ast::Find* const find_;
  const Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Pairs& pairs_;
  Laws& laws_;
};

} // namespace hvi::lang
