// A Prony series as numbers and as an expression.
#include "solver/kernel/prony_series.hpp"

#include <cmath>

namespace hvi::solver {

double PronySeries::value(double lag) const {
  double sum = constant;
  for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * std::exp(-lag / times[i]);
  return sum;
}

Expr expression(const PronySeries& series, const Expr& lag) {
  Expr sum = series.constant;
  for (std::size_t i = 0; i < series.weights.size(); ++i)
    sum = sum + Expr(series.weights[i]) * exp(-lag / Expr(series.times[i]));
  return sum;
}

} // namespace hvi::solver
