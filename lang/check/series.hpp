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
  /// prony(weights, times) = sum_i weights[i] exp(-lag/times[i]). prony_relaxation(weights, times)
  /// is the derivative of that sum: what a relaxation modulus with these weights is as a kernel of
  /// eps(u), sigma = G(0) eps + int_0^t G'(t - s) eps(s) ds.
  Value prony_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                   const Scope& scope);
  /// derivative(a): by the lag in kernels, by t elsewhere. Of a Prony series it is one.
  Value derivative_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  /// E0423 where a table of the time alone is asked for a value outside its range at a grid time.
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
