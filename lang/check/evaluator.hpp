// Whoever evaluates expressions, as it is seen by those who read one of them: a number, a list of
// constants, the arguments of a call. The one implementation is Expressions.
#pragma once

#include "lang/check/names.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

class Evaluator {
public:
  virtual Value expr(const ast::Expr& e, const Scope& scope) = 0;
  /// Of a name where it stands as an expression.
  virtual Value reference(const ast::Expr& e, const std::string& name, const Scope& scope) = 0;
  virtual std::optional<Symbol> condition(const ast::Condition& c, const Scope& scope) = 0;
  /// Of a declaration: evaluated when it is first used.
  virtual Value& value_of(int declaration, const Span& use) = 0;

  // Nothing where the expression is something else (reported).
  std::optional<Field> field(const ast::Expr& e, const Scope& scope);
  std::optional<Field> scalar(const ast::Expr& e, const Scope& scope);
  std::optional<double> constant(const ast::Expr& e, const std::string& what);
  std::optional<int> positive_integer(const ast::Expr& e, const std::string& what);
  std::optional<std::vector<double>> constant_list(const ast::Expr& e, const std::string& what);
  std::optional<std::string> word(const ast::Expr& e, const std::string& what,
                                  const std::vector<std::string>& allowed);
  /// Matches positional and named arguments with `names` (the first `required` must be there).
  std::optional<std::vector<const ast::Expr*>> match(const ast::Expr& e, const ast::Call& call,
                                                     const std::string& callee,
                                                     const std::vector<std::string>& names,
                                                     std::size_t required);

protected:
  Evaluator(Mistakes& mistakes, Names& names) : mistakes_(mistakes), names_(names) {}
  ~Evaluator() = default;

private:
  Mistakes& mistakes_;
  const Names& names_;
};

/// The place of the i-th entry of a list as written; the whole expression when it is not a list.
Span item_span(const ast::Expr& list, std::size_t i);

} // namespace hvi::lang
