// What a name stands for where it is used.
#pragma once

#include "lang/check/context.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

class References {
public:
  explicit References(const Context& context)
      : mistakes_(context.mistakes), names_(context.names), find_(context.find),
        model_(context.model), unknowns_(context.unknowns), evaluator_(context.evaluator),
        at_hand_(context.at_hand) {}

  Value reference(const ast::Expr& expr, const std::string& name, const Scope& scope);

private:
  std::optional<Value> built_in_name(const ast::Expr& expr, const std::string& name,
                                     const Scope& scope);
  Value hidden_state(const Span& span, int declaration, const Scope& scope);

  Mistakes& mistakes_;
  Names& names_;
  const ast::Find* const find_;
  const Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
};

} // namespace hvi::lang
