// See rounded_factor.hpp.
#include "solver/linear/mixed/rounded_factor.hpp"

namespace hvi::solver {

/// A factorisation that was factored again is another one. Its address may be that of one that is
/// gone only if somebody frees the factor of a matrix before he has the next one: nobody does.
bool RoundedFactor::take(const Factorisation& of) {
  const int factorisation = of.statistics().factorisations;
  if (of_ == &of && factorisation_ == factorisation) return !packed_.empty();
  of_ = &of, factorisation_ = factorisation;
  packed_.clear();
  const auto l = of.lower();
  if (!l || !packed_.pack(l->interior, l->values)) return false;
  y_.resize(static_cast<Eigen::Index>(l->permutation.size()));
  x_.resize(y_.size());
  return true;
}

void RoundedFactor::forget() {
  of_ = nullptr;
  packed_.clear();
}

void RoundedFactor::count(FactorPrecision precision) {
  ++counted_.triangular_solves;
  counted_.bytes_read += packed_.bytes_read(precision == FactorPrecision::fine);
}

void RoundedFactor::reduce(FactorPrecision precision, const Vector& b, Vector& r) {
  const auto l = of_->lower();
  const auto size = y_.size(), interior = static_cast<Eigen::Index>(l->inverse_diagonal.size());
  for (Eigen::Index position = 0; position < size; ++position)
    y_[position] = b[l->permutation[static_cast<std::size_t>(position)]];
  packed_.forward(precision == FactorPrecision::fine, y_.data());
  r = y_.tail(size - interior);
  count(precision);
}

void RoundedFactor::back(FactorPrecision precision, const Vector& c, Vector& x) {
  const auto l = of_->lower();
  x_.tail(c.size()) = c;
  packed_.backward(precision == FactorPrecision::fine, y_.data(), x_.data());
  x.resize(x_.size());
  for (Eigen::Index position = 0; position < x_.size(); ++position)
    x[l->permutation[static_cast<std::size_t>(position)]] = x_[position];
  count(precision);
}

Vector RoundedFactor::kept() const {
  const auto inverse = of_->lower()->inverse_diagonal;
  Vector out(static_cast<Eigen::Index>(inverse.size()));
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out[i] = y_[i] * (1.0 / inverse[static_cast<std::size_t>(i)]);
  return out;
}

FactorStatistics RoundedFactor::statistics() const {
  FactorStatistics out = counted_;
  out.bytes = packed_.empty() ? 0.0 : packed_.bytes();
  return out;
}

} // namespace hvi::solver
