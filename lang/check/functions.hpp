// Built-in functions of values: pointwise ones, derivatives in place, algebra of vectors and
// matrices.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/operators.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

class Functions {
public:
  Functions(const Context& context, Operators& operators)
      : mistakes_(context.mistakes), model_(context.model), evaluator_(context.evaluator),
        operators_(operators) {}

  Value pointwise(const ast::Expr& e, const ast::Call& call, const std::string& name,
                  const Scope& scope);
  Value differential(const ast::Expr& e, const ast::Call& call, const std::string& name,
                     const Scope& scope);
  Value algebraic(const ast::Expr& e, const ast::Call& call, const std::string& name,
                  const Scope& scope);

private:
  bool is_order(const Span& place, const Symbol& order);
  bool are_parameters(const ast::Call& call, const Symbol& alpha, const Symbol& beta);
  std::optional<Field> total_gradient(const Span& span, const Field& f);
  Field with_hoop(const Field& gradient, const Field& f) const;
  Value identity_call(const ast::Expr& e, const ast::Call& call);
  Value dot_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  Value mises_call(const ast::Expr& e, const Span& span, const Field& f, const Scope& scope);

  Mistakes& mistakes_;
  const Model& model_;
  Evaluator& evaluator_;
  Operators& operators_;
};

} // namespace hvi::lang
