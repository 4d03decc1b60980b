// Has every step one solution? See uniqueness.hpp. Called by the Stepper at its first step.
#include "solver/time/uniqueness.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/common/numbers.hpp"
#include "solver/law/known_constants.hpp"
#include "solver/plan/couplings.hpp"
#include "solver/time/product_form.hpp"
#include "solver/time/step_weights.hpp"
#include "solver/time/time_scheme.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace hvi::solver {
namespace {

/// Up to this size the dense Schur complement and its factor (with an error of at most 8000 eps of
/// its norm) are exact enough for the verdict, and cost little beside the factor of all unknowns.
constexpr int most_judged_points = 8000;
constexpr int most_judged = 64; ///< of all unknowns; as a rule two to four suffice

} // namespace

SparseMatrix law_form(const Contact& contact, const std::vector<double>& weight, int n_unknowns) {
  Vector diagonal = Vector::Zero(contact.n_rows());
  for (const auto& term : contact.terms)
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = contact.problem.points[term.first_point + p];
      diagonal.segment(point.first_row, point.rows)
          .setConstant(weight[term.points.law_term] * point.weight);
    }
  const SparseMatrix g = contact.g.leftCols(n_unknowns);
  const SparseMatrix weighted = diagonal.asDiagonal() * g;
  return SparseMatrix(SparseMatrix(g.transpose()) * weighted);
}

std::vector<double> in_step(const Contact& contact, std::vector<double> weight,
                            const Vector& of_fields) {
  for (const auto& term : contact.terms) {
    double& sum = weight[static_cast<std::size_t>(term.points.law_term)];
    const double own = std::exchange(sum, 0.0);
    term.for_seen(0, [&](int field, double times) { sum += own * times * of_fields[field]; });
  }
  return weight;
}

Uniqueness::Uniqueness(const Problem& problem, const Operators& operators, const Contact& contact)
    : problem_(problem), operators_(operators), contact_(contact),
      shares_(present_shares(*make_scheme(problem), count_fields(problem))) {
  look_at_laws();
}

namespace {

/// The steepest descent of a law's slope at the term's points, at all times of the plan.
Bracket descent_of(const Problem& problem, const ContactTerm& term, const Law& law) {
  LawDomain domain;
  for (const Point& x : term.points.x) {
    domain.part.push_back({{x}, 1});
    if (!law.depends_on_x()) break;
  }
  if (!problem.time.is_static)
    domain.t_low = problem.time.grid.front(), domain.t_high = problem.time.grid.back();
  return steepest_descent(law, domain);
}

} // namespace

void Uniqueness::look_at_laws() {
  if (contact_.coupled) obstacle_ = "a law is coupled to another one";
  if (contact_.mixed) obstacle_ = "a law sees different fields in different components";
  if (!contact_.readings.empty()) obstacle_ = "a law reads the solution";
  if (!contact_.state_groups.empty()) obstacle_ = "laws with states are solved together with them";
  if (!operators_.changing.empty()) obstacle_ = "states change the forms";
  bool softens = false, moves = false;
  weight_.assign(problem_.law_terms.size(), 0.0);
  for (const auto& term : contact_.terms) {
    const int index = problem_.law_terms[term.points.law_term].law;
    const Law& law = *contact_.laws[index];
    moves = moves || law.depends_on_x() || law.depends_on_t();
    if (!obstacle_.empty() || term.n_points() == 0) continue;
    const Bracket m = descent_of(problem_, term, law);
    weight_[term.points.law_term] = m.value();
    softens = softens || m.value() > 0.0;
    if (std::isinf(m.value()))
      obstacle_ = fmt::format("`{}` jumps down", law.spec().name);
    else if (!m.bounded_by_proof())
      obstacle_ = fmt::format("m_J of `{}` is sampled, not proved", law.spec().name);
  }
  settled_ = !softens || !obstacle_.empty();
  if (settled_) return;
  condensed_ =
      !moves && operators_.symmetric &&
      (contact_.whole || static_cast<int>(contact_.unknowns.size()) <= most_judged_points) &&
      surely_one_matrix(problem_);
}

void Uniqueness::judge(bool convex) {
  settled_ = true;
  if (!convex)
    obstacle_ = "the laws soften faster than the body is stiff (step ratio of 1 or more)";
}

/// A Cholesky factor of sym K(c) - D; the pattern is analysed once.
bool Uniqueness::definite(const Eigen::VectorXd& c) {
  SparseMatrix rest = combine(operators_, operators_.weights.transpose() * shares_.cwiseProduct(c));
  if (!contact_.other_fields.empty())
    descent_ = law_form(contact_, in_step(contact_, weight_, c), operators_.n_unknowns);
  if (same_pattern_)
    add_scaled(rest, -1.0, descent_);
  else
    rest = SparseMatrix(rest - descent_);
  if (!contact_.of_unknown.empty())
    rest =
        ProductForm(rest, contact_.of_unknown, unknowns_with_laws(problem_)).symmetric_part(rest);
  else if (!operators_.symmetric)
    rest = SparseMatrix(0.5 * (rest + SparseMatrix(rest.transpose())));
  try {
    if (!factor_) factor_ = analyse(rest, {}, true);
    factor_->factor(rest);
  } catch (const NotFactorable&) {
    return false;
  }
  return true;
}

/// Points of laws couple unknowns of one facet, which K does as a rule.
void Uniqueness::take_over(const Factorisation* like) {
  if (like == nullptr || !operators_.symmetric || operators_.separate) return;
  SparseMatrix k = combine(operators_, Vector::Zero(operators_.n_bases()));
  try {
    add_scaled(k, 1.0, descent_);
  } catch (const std::invalid_argument&) { // an entry that K does not have
    return;
  }
  factor_ = like->another();
  same_pattern_ = true;
}

void Uniqueness::judge_all(const Factorisation* like) {
  settled_ = true;
  descent_ = law_form(contact_, weight_, operators_.n_unknowns);
  take_over(like);
  const auto worst = worst_step(
      step_weights(problem_),
      [&](const Eigen::VectorXd& c) { return definite(c) ? 0.0 : infinity; }, most_judged);
  factor_.reset();
  descent_ = {};
  if (worst.bound == 0.0) return;
  if (problem_.time.is_static)
    judge(false);
  else if (worst.ratio > 0.0)
    obstacle_ = fmt::format(
        "in step {} (t = {:.6g}) the laws soften faster than the body is stiff (step ratio of 1 or "
        "more)",
        worst.step, problem_.time.grid[worst.step]);
  else
    obstacle_ = fmt::format("it could not be shown for all {} steps in {} trials",
                            problem_.time.grid.size() - 1, most_judged);
}

} // namespace hvi::solver
