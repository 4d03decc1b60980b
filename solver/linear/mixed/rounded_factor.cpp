// See rounded_factor.hpp.
#include "solver/linear/mixed/rounded_factor.hpp"

#include "solver/linear/cholesky.hpp"

namespace hvi::solver {

/// A factorisation that was factored again is another one. Its address may be that of one that is
/// gone only if somebody frees the factor of a matrix before he has the next one: nobody does.
bool RoundedFactor::take(const Factorisation& of) {
  const int factorisation = of.statistics().factorisations;
  if (of_ == &of && factorisation_ == factorisation) return !packed_.empty();
  of_ = &of, factorisation_ = factorisation;
  packed_.clear();
  const LowerFactor* l = lower_factor(of);
  return l != nullptr && packed_.pack(l->structure, l->values);
}

void RoundedFactor::forget() {
  of_ = nullptr;
  packed_.clear();
}

void RoundedFactor::count(FactorPrecision precision) {
  ++counted_.triangular_solves;
  counted_.bytes_read += packed_.bytes_read(precision == FactorPrecision::fine);
}

void RoundedFactor::forward(FactorPrecision precision, Vector& y) {
  packed_.forward(precision == FactorPrecision::fine, y.data());
  count(precision);
}

void RoundedFactor::back(FactorPrecision precision, Vector& y) {
  packed_.backward(precision == FactorPrecision::fine, y.data());
  count(precision);
}

/// y_I is over the diagonal of L.
void RoundedFactor::complete(Vector& y) const {
  const auto& inverse = lower_factor(*of_)->inverse_diagonal;
  for (std::size_t i = 0; i < inverse.size(); ++i)
    y[static_cast<Eigen::Index>(i)] *= 1.0 / inverse[i];
}

FactorStatistics RoundedFactor::statistics() const {
  FactorStatistics out = counted_;
  out.bytes = packed_.empty() ? 0.0 : packed_.bytes();
  return out;
}

} // namespace hvi::solver
