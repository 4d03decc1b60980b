// The matrices of a problem on one mesh and their constants; see numbers.hpp.
#include "solver/hypotheses/numbers.hpp"

#include "solver/common/numbers.hpp"
#include "solver/discrete/body_states.hpp"
#include "solver/discrete/time_scheme.hpp"
#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hvi::solver {
Numbers::Numbers(const Plan& plan, const Discretisation& d)
    : problem_(plan.problem), discretisation_(d), layout_(make_layout(d.space, d.dofs)),
      operators_(assemble_operators(problem_, d, layout_, plan.options.threads)),
      contact_(make_contact(problem_, d, layout_)), motions_(motions_of_unknowns(d)),
      free_(find_free_body(motions_, combine(operators_, Vector::Ones(operators_.n_bases())),
                           layout_)),
      gram_(gram_on_unknowns(d, layout_)),
      shares_(present_shares(*make_scheme(problem_), count_fields(problem_))),
      laws_(law_constants(problem_, d, contact_)) {
  // By the rule of the steps, at the points of the states.
  ChangingForms(problem_, d, contact_, operators_).take(contact_, layout_, operators_);
}

TraceNorms Numbers::traces() const {
  return trace_norms(problem_, discretisation_, layout_, gram_);
}

std::optional<ProductForm> Numbers::product_form(const SparseMatrix& k) const {
  if (!has_several_unknowns()) return std::nullopt;
  return ProductForm(k, contact_.of_unknown, unknowns_with_laws(problem_), couplings_of(problem_));
}

SparseMatrix Numbers::definite_part(const SparseMatrix& k) const {
  if (const auto form = product_form(k)) return form->symmetric_part(k);
  return 0.5 * (k + SparseMatrix(k.transpose()));
}

std::optional<InfSup> Numbers::inf_sup(int unknown, bool at_rest) const {
  return hvi::solver::inf_sup(
      {problem_, discretisation_, layout_, operators_, contact_, gram_.matrix()}, unknown, at_rest);
}

SparseMatrix Numbers::of_field(int field) const {
  return combine(operators_, operators_.weights.row(field).transpose());
}

namespace {

SparseMatrix on_rows(const SparseMatrix& matrix, const std::vector<int>& rows) {
  std::vector<int> place(static_cast<std::size_t>(matrix.rows()), -1);
  for (std::size_t k = 0; k < rows.size(); ++k)
    place[static_cast<std::size_t>(rows[k])] = static_cast<int>(k);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (SparseMatrix::InnerIterator it(matrix, rows[k]); it; ++it)
      if (const int column = place[static_cast<std::size_t>(it.col())]; column >= 0)
        entries.emplace_back(static_cast<int>(k), column, it.value());
  const auto n = static_cast<Eigen::Index>(rows.size());
  SparseMatrix out(n, n);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

} // namespace

/// Multipliers that the definite part does not see have a diagonal there that stands for nothing.
Numbers::DefinitePart Numbers::definite_part_of(int field) const {
  const SparseMatrix k = of_field(field);
  const auto of_product = product_form(k);
  DefinitePart out{of_product ? of_product->symmetric_part(k) : definite_part(k), {}};
  out.rows.resize(of_product ? static_cast<std::size_t>(n_unknowns(discretisation_.space)) : 1);
  for (int i = 0; i < layout_.n_unknowns; ++i) {
    const std::size_t unknown = contact_.unknown_of(i);
    if (of_product && of_product->is_multiplier(static_cast<int>(unknown)) &&
        out.form.coeff(i, i) != 0.0)
      continue;
    out.rows[unknown].push_back(i);
    for (SparseMatrix::InnerIterator it(out.form, i); it; ++it)
      out.couples = out.couples || (it.value() != 0.0 &&
                                    contact_.unknown_of(static_cast<int>(it.col())) != unknown);
  }
  return out;
}

/// Where unknowns are not coupled it is the least of their own, of which none is measured by the
/// units of another.
double Numbers::coercivity(int field, double pointwise) const {
  if (!acts_on(field)) return 0.0;
  const DefinitePart part = definite_part_of(field);
  const auto on = [&](const std::vector<int>& rows) {
    if (std::ssize(rows) == layout_.n_unknowns) return least(part.form, gram_, rows, pointwise);
    const GramForm gram(on_rows(gram_.matrix(), rows));
    return least(on_rows(part.form, rows), gram, rows, pointwise);
  };
  std::vector<int> all;
  double out = infinity;
  for (const auto& rows : part.rows) {
    if (rows.empty()) continue;
    all.insert(all.end(), rows.begin(), rows.end());
    if (!part.couples) out = std::min(out, on(rows));
  }
  std::ranges::sort(all);
  return part.couples ? on(all) : out;
}

std::vector<double> Numbers::own_coercivities(int field) const {
  const double size = bounding_box(discretisation_.mesh).diagonal();
  const auto masses = masses_in_gram(discretisation_);
  const SparseMatrix mass_of_all =
      restrict_rows(mass(discretisation_.space), layout_).leftCols(layout_.n_unknowns);
  const DefinitePart part = definite_part_of(field);
  std::vector<double> out;
  for (std::size_t b = 0; b < part.rows.size(); ++b) {
    const auto& rows = part.rows[b];
    SparseMatrix gram = on_rows(gram_.matrix(), rows);
    if (masses[b] != 0) gram += (1.0 / (size * size) - 1.0) * on_rows(mass_of_all, rows);
    out.push_back(rows.empty() ? infinity
                               : least(on_rows(part.form, rows), GramForm(std::move(gram)), rows,
                                       not_a_number));
  }
  return out;
}

namespace {

/// Is the least eigenvalue rounding of the largest one? A rigid motion says that it is not above,
/// and one factorisation that it is not below. Both beside the form's own entries: beside the Gram
/// matrix, of which such a motion has the mass alone, they would depend on units.
bool least_is_zero(const SparseMatrix& form, const std::vector<DenseMatrix>& motions) {
  constexpr double rounding = 1e-10;
  const auto not_below = [&] {
    const SparseMatrix diagonal(form.diagonal().asDiagonal());
    try {
      GramForm(form + rounding * diagonal);
      return true;
    } catch (const NotFactorable&) {
      return false;
    }
  };
  for (const DenseMatrix& of : motions)
    for (Eigen::Index i = 0; i < of.cols(); ++i) {
      const Vector v = of.col(i), size = v.cwiseAbs();
      if (v.dot(form * v) <= rounding * size.dot(form.cwiseAbs() * size)) return not_below();
    }
  return false;
}

} // namespace

double Numbers::least(const SparseMatrix& form, const GramForm& gram, const std::vector<int>& rows,
                      double pointwise) const {
  std::vector<std::int32_t> dofs;
  for (const int i : rows) dofs.push_back(layout_.dof_of[static_cast<std::size_t>(i)]);
  std::vector<DenseMatrix> motions;
  for (const RigidMotions& of : motions_)
    if (DenseMatrix on = of.on(dofs); !on.isZero(0.0)) motions.push_back(std::move(on));
  // A body that nothing holds has rigid motions, which strains do not see: no iteration is needed.
  if (least_is_zero(form, motions)) return 0.0;
  const double below = std::isfinite(pointwise) ? std::max(0.0, pointwise) : 0.0;
  const double value = gram.least(form, below).value_or(not_a_number);
  const bool held = discretisation_.dofs.held() && motions.empty();
  const double rounding = held ? 0.0 : 1e-10 * gram.norm(form).value_or(0.0);
  return std::abs(value) <= rounding ? 0.0 : value;
}

double Numbers::coercivity_in_h(int field) const {
  if (!acts_on(field)) return 0.0;
  const SparseMatrix l2 =
      restrict_rows(mass(discretisation_.space), layout_).leftCols(layout_.n_unknowns);
  // As it is stated: a scheme may take mass off some nodes.
  const SparseMatrix form =
      field == field_of_u(2)
          ? SparseMatrix(restrict_rows(matrix_of_field(problem_, discretisation_, field), layout_)
                             .leftCols(layout_.n_unknowns))
          : of_field(field);
  // Beside a displacement with mass a temperature has none, nor is it asked to have.
  const bool some = field == field_of_u(2) && has_several_unknowns();
  if (!some) return GramForm(l2).least(form).value_or(not_a_number);
  const std::vector<int> orders = orders_in_time(problem_);
  std::vector<int> rows;
  for (int i = 0; i < layout_.n_unknowns; ++i)
    if (orders[contact_.unknown_of(i)] >= field) rows.push_back(i);
  return GramForm(on_rows(l2, rows)).least(on_rows(form, rows)).value_or(not_a_number);
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
    const double factor =
        factor_of_row(problem_.law_terms[law.term], 0, [&](int field) { return factors[field]; });
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
    const auto of_product = product_form(k);
    const GramForm against(of_product ? of_product->symmetric_part(k) : definite_part(k));
    return 1.0 -
           against.largest(of_product ? of_product->weighted(*form) : *form).value_or(not_a_number);
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
  if (operators.symmetric) return true;
  const auto of_product = numbers_.product_form(all);
  if (of_product) descent_ = of_product->weighted(descent_), taken_ = false;
  k = of_product ? of_product->symmetric_part(k) : numbers_.definite_part(k);
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
