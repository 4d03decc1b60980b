// The matrices of a problem on one mesh and their constants; see numbers.hpp.
#include "solver/hypotheses/numbers.hpp"

#include "solver/common/numbers.hpp"
#include "solver/time/time_scheme.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
Numbers::Numbers(const Plan& plan, const Discretisation& d)
    : problem_(plan.problem), discretisation_(d), layout_(make_layout(d.space, d.dofs)),
      operators_(assemble_operators(problem_, d, layout_, plan.options.threads)),
      contact_(make_contact(problem_, d, layout_)), motions_(d),
      free_(find_free_body(motions_, combine(operators_, Vector::Ones(operators_.n_bases())),
                           layout_)),
      gram_(restrict_rows(gram_v(d.space, !d.dofs.held || motions_.count() > 0), layout_)
                .leftCols(layout_.n_unknowns)),
      shares_(present_shares(*make_scheme(problem_), count_fields(problem_))),
      laws_(law_constants(problem_, d, contact_)),
      traces_(trace_norms(problem_, d, layout_, gram_)) {}

SparseMatrix Numbers::of_field(int field) const {
  return combine(operators_, operators_.weights.row(field).transpose());
}

double Numbers::coercivity(int field, double pointwise) const {
  if (!acts_on(field)) return 0.0;
  const double below = std::isfinite(pointwise) ? std::max(0.0, pointwise) : 0.0;
  const SparseMatrix form = of_field(field);
  const double least = gram_.least(form, below).value_or(not_a_number);
  // A body that nothing holds has rigid motions, which strains do not see.
  const bool held = discretisation_.dofs.held && motions_.count() == 0;
  const double rounding = held ? 0.0 : 1e-10 * gram_.norm(form).value_or(0.0);
  return std::abs(least) <= rounding ? 0.0 : least;
}

double Numbers::coercivity_in_h(int field) const {
  if (!acts_on(field)) return 0.0;
  const GramForm gram(
      restrict_rows(mass(discretisation_.space), layout_).leftCols(layout_.n_unknowns));
  // As it is stated: a scheme may take mass off some nodes.
  const SparseMatrix form =
      field == field_of_u(2)
          ? SparseMatrix(restrict_rows(matrix_of_field(problem_, discretisation_, field), layout_)
                             .leftCols(layout_.n_unknowns))
          : of_field(field);
  return gram.least(form).value_or(not_a_number);
}

double Numbers::memory_norm(int m) const {
  return gram_.norm(of_field(field_of_memory(m))).value_or(not_a_number);
}

double Numbers::asymmetry(int field) const {
  const SparseMatrix k = of_field(field);
  const SparseMatrix skew = SparseMatrix(k - SparseMatrix(k.transpose()));
  double largest = 0.0, off = 0.0;
  for (int e = 0; e < k.nonZeros(); ++e) largest = std::max(largest, std::abs(k.valuePtr()[e]));
  for (int e = 0; e < skew.nonZeros(); ++e) off = std::max(off, std::abs(skew.valuePtr()[e]));
  return largest > 0.0 ? off / largest : 0.0;
}

Vector Numbers::only(int field) const { return Vector::Unit(count_fields(problem_), field); }

std::optional<SparseMatrix> Numbers::descent(const Vector& factors) const {
  std::vector<double> weight(problem_.law_terms.size(), 0.0);
  for (const auto& law : laws_) {
    const double factor = factors[problem_.law_terms[law.term].field];
    if (factor == 0.0) continue;
    if (!std::isfinite(law.m.value())) return std::nullopt;
    weight[law.term] = law.m.value() * factor;
  }
  const bool softens = std::any_of(weight.begin(), weight.end(), [](double m) { return m > 0.0; });
  if (!softens) return SparseMatrix(layout_.n_unknowns, layout_.n_unknowns);
  return law_form(contact_, weight, layout_.n_unknowns);
}

double Numbers::margin_against(int field) const {
  const auto form = descent(only(field));
  if (!form) return -infinity;
  if (free_) return -infinity;
  if (form->nonZeros() == 0) return 1.0;
  const SparseMatrix k = of_field(field);
  try {
    const GramForm against(SparseMatrix(0.5 * (k + SparseMatrix(k.transpose()))));
    return 1.0 - against.largest(*form).value_or(not_a_number);
  } catch (const Failure&) {
    return -infinity;
  }
}

double Numbers::script_norm(int field) const {
  const std::vector<double> ones(problem_.law_terms.size(), 1.0);
  const SparseMatrix form =
      law_form(contact_, in_step(contact_, ones, only(field)), layout_.n_unknowns);
  return gram_.largest(form).value_or(not_a_number);
}

double Numbers::margin_split(int field, double m) const {
  const auto form = descent(only(field));
  return form ? m - gram_.largest(*form).value_or(not_a_number) : -infinity;
}

bool StepRatio::take(const Vector& c, SparseMatrix& k) {
  if (numbers_.free_body() != nullptr) return false;
  if (!taken_ || numbers_.has_laws_on_rates()) {
    auto form = numbers_.descent(c);
    if (!form) return false;
    descent_.swap(*form);
    taken_ = true;
  }
  const auto& operators = numbers_.operators();
  const SparseMatrix all =
      combine(operators, operators.weights.transpose() * numbers_.shares().cwiseProduct(c));
  // With the pattern of the laws' form, so that one analysis serves all combinations.
  k = all + 0.0 * descent_;
  if (!operators.symmetric) k = SparseMatrix(0.5 * (k + SparseMatrix(k.transpose())));
  return true;
}

double StepRatio::operator()(const Vector& c) {
  SparseMatrix k;
  if (!take(c, k)) return infinity;
  try {
    if (against_)
      against_->replace(k);
    else
      against_ = std::make_unique<GramForm>(k);
  } catch (const NotFactorable&) {
    return infinity;
  }
  if (descent_.nonZeros() == 0) return 0.0;
  const auto ratio = against_->largest(descent_);
  return ratio ? *ratio : by_factors(k);
}

/// Is ratio K - descent positive definite?
bool StepRatio::exceeds(const SparseMatrix& k, double ratio) {
  const SparseMatrix rest = ratio * k - descent_;
  try {
    if (trial_)
      trial_->replace(rest);
    else
      trial_ = std::make_unique<GramForm>(rest);
  } catch (const NotFactorable&) {
    return false;
  }
  return true;
}

bool StepRatio::below_one(const Vector& c) {
  SparseMatrix k;
  return take(c, k) && exceeds(k, 1.0);
}

/// A bound from above, where the iteration for the eigenvalue does not converge.
double StepRatio::by_factors(const SparseMatrix& k) {
  constexpr int halvings = 10;
  double low = 0.0, high = 1.0;
  if (!exceeds(k, high)) return infinity;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (exceeds(k, middle) ? high : low) = middle;
  }
  return high;
}

} // namespace hvi::solver
