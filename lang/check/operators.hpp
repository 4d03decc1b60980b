// Operators on symbolic values: shapes, and how each operation carries linearity in u and v.
#pragma once

#include "lang/check/context.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

class Operators {
public:
  explicit Operators(const Context& context)
      : mistakes_(context.mistakes), model_(context.model), unknowns_(context.unknowns) {}

  std::optional<Field> add(const ast::Expr& e, const ast::Binary& b, Field left, Field right,
                           const Scope& scope);
  /// Degrees of f(a, b, ...): must not contain v, nor u outside reports.
  bool nonlinear_degrees(const Span& span, const std::string& what,
                         const std::vector<const Field*>& args, Field& out, const Scope& scope);
  std::optional<Field> multiply(const ast::Expr& e, const ast::Binary& b, const Field& left,
                                const Field& right, const Scope& scope);
  std::optional<Field> divide(const ast::Expr& e, const ast::Binary& b, const Field& left,
                              const Field& right, const Scope& scope);
  std::optional<Field> contract(const ast::Expr& e, const ast::Binary& b, const Field& left,
                                const Field& right, const Scope& scope);
  std::optional<Field> power(const ast::Expr& e, const Field& left, const Field& right,
                             const Scope& scope);
  std::optional<Field> dot(const Span& span, const Field& left, const Field& right,
                           const Scope& scope);
  /// False (reported) for a constant that is not a finite number.
  bool check_finite(const Span& span, const Field& result);

private:
  /// Degrees of a product; false (reported) when it is not linear.
  bool product_degrees(const Span& span, const Field& left, const Field& right, Field& out,
                       const Scope& scope);
  std::optional<Field> dot_in_section(const Span& span, const Field& left, const Field& right,
                                      const Scope& scope);

  Mistakes& mistakes_;
  const Model& model_;
  const Unknowns& unknowns_;
};

} // namespace hvi::lang
