// Has every step one solution? See uniqueness.hpp. Called by the Stepper at its first step.
#include "solver/time/uniqueness.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/time/step_weights.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace hvi::solver {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// Up to this size a factor of the dense Schur complement is exact enough to be an answer.
constexpr int most_condensed = 1500;
constexpr int most_factors = 64; ///< of all unknowns; as a rule two to four suffice

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

Uniqueness::Uniqueness(const Plan& plan, const Operators& operators, const Contact& contact)
    : plan_(plan), operators_(operators), contact_(contact) {
  look_at_laws();
}

void Uniqueness::look_at_laws() {
  if (contact_.coupled) obstacle_ = "a law is coupled to another one";
  bool softens = false, moves = false;
  for (const auto& term : contact_.terms) {
    const int index = plan_.law_terms[term.points.law_term].law;
    const Law& law = *contact_.laws[index];
    const double m = contact_.softening[index];
    softens = softens || m > 0.0;
    moves = moves || law.depends_on_x() || law.depends_on_t();
    if (!obstacle_.empty() || term.n_points() == 0) continue;
    if (!std::isfinite(m)) obstacle_ = fmt::format("`{}` jumps down", law.spec().name);
  }
  settled_ = !softens || !obstacle_.empty();
  if (settled_) return;
  condensed_ = !moves && operators_.symmetric &&
               (contact_.whole || static_cast<int>(contact_.unknowns.size()) <= most_condensed) &&
               surely_one_matrix(plan_);
}

void Uniqueness::judge(bool convex) {
  settled_ = true;
  if (!convex)
    obstacle_ = "the laws soften faster than the body is stiff (step ratio of 1 or more)";
}

/// A Cholesky factor of sym K(c) - D; the pattern is analysed once.
bool Uniqueness::definite(const Eigen::VectorXd& c) {
  SparseMatrix rest = combine(operators_, operators_.weights.transpose() * c);
  if (same_pattern_)
    add_scaled(rest, -1.0, descent_);
  else
    rest = SparseMatrix(rest - descent_);
  if (!operators_.symmetric) rest = SparseMatrix(0.5 * (rest + SparseMatrix(rest.transpose())));
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
  std::vector<double> weight(plan_.law_terms.size(), 0.0);
  for (std::size_t l = 0; l < weight.size(); ++l)
    weight[l] = contact_.softening[plan_.law_terms[l].law];
  descent_ = law_form(contact_, weight, operators_.n_unknowns);
  take_over(like);
  const auto worst = worst_step(
      step_weights(plan_), [&](const Eigen::VectorXd& c) { return definite(c) ? 0.0 : infinity; },
      most_factors);
  factor_.reset();
  descent_ = {};
  if (worst.bound == 0.0) return;
  if (plan_.time.is_static)
    judge(false);
  else if (worst.ratio > 0.0)
    obstacle_ = fmt::format(
        "in step {} (t = {:.6g}) the laws soften faster than the body is stiff (step ratio of 1 or "
        "more)",
        worst.step, plan_.time.grid[worst.step]);
  else
    obstacle_ = fmt::format("it could not be shown for all {} steps in {} trials",
                            plan_.time.grid.size() - 1, most_factors);
}

} // namespace hvi::solver
