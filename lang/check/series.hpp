// Functions that data give: tables, Prony series, derivatives of these.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/operators.hpp"

#include <string>
#include <vector>

namespace hvi::lang {

class Series {
public:
  Series(const Context& context, Operators& operators)
      : options_(context.options), mistakes_(context.mistakes), model_(context.model),
        evaluator_(context.evaluator), operators_(operators) {}

  Value table_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  Value prony_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                   const Scope& scope);
  Value derivative_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  void check_tables();

private:
  Field prony_through(const solver::Table& table, const Symbol& at, const Span& span, bool taken);

  /// A table's argument, checked when the times of the problem are known.
  struct TableUse {
    Span span;
    std::string file;
    Symbol at;
    double first, last;
  };

  const CheckOptions& options_;
  Mistakes& mistakes_;
  Model& model_;
  Evaluator& evaluator_;
  Operators& operators_;
  std::vector<TableUse> table_uses_;
};

} // namespace hvi::lang
