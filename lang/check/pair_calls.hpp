// jump(u), mean(u) and gap(seam).
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/parts.hpp"

#include <string>

namespace hvi::lang {

class PairCalls {
public:
  PairCalls(const Context& context, Parts& parts, const Pairs& pairs)
      : mistakes_(context.mistakes), evaluator_(context.evaluator), at_hand_(context.at_hand),
        parts_(parts), pairs_(pairs) {}

  /// jump(u), jump(u'), jump(v), jump(history(q, u)), and the same of mean: of values.
  Value jump_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                  const Scope& scope);
  Value gap_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);

private:
  Mistakes& mistakes_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Parts& parts_;
  const Pairs& pairs_;
};

} // namespace hvi::lang
