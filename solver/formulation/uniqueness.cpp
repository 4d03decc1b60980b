// Has every step one solution? See uniqueness.hpp. Called by the Stepper at its first step.
#include "solver/formulation/uniqueness.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/common/numbers.hpp"
#include "solver/discrete/product_form.hpp"
#include "solver/discrete/time_scheme.hpp"
#include "solver/formulation/step_weights.hpp"
#include "solver/law/known_constants.hpp"
#include "solver/linear/dense.hpp"
#include "solver/plan/couplings.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// sum_i weight_i M_i^T W M_i, M_i these columns of the rows of all points.
SparseMatrix law_form(const Contact& contact, const std::vector<double>& weight,
                      const SparseMatrix& g) {
  Vector diagonal = Vector::Zero(contact.n_rows());
  for (const auto& term : contact.terms)
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = contact.problem.points[term.first_point + p];
      diagonal.segment(point.first_row, point.rows)
          .setConstant(weight[term.points.law_term] * point.weight);
    }
  const SparseMatrix weighted = diagonal.asDiagonal() * g;
  return SparseMatrix(SparseMatrix(g.transpose()) * weighted);
}

} // namespace

SparseMatrix law_form(const Contact& contact, const std::vector<double>& weight, int n_unknowns) {
  return law_form(contact, weight, SparseMatrix(contact.g.leftCols(n_unknowns)));
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

namespace {

/// The steepest descent of a law's slope at the term's points, at all times of the plan.
KnownConstants descent_of(const Problem& problem, const ContactTerm& term, const Law& law) {
  LawDomain domain;
  for (const Point& x : term.points.x) {
    domain.part.push_back({{x}, 1});
    if (!law.depends_on_x()) break;
  }
  if (!problem.time.is_static)
    domain.t_low = problem.time.grid.front(), domain.t_high = problem.time.grid.back();
  return steepest_descent(law, domain);
}

/// Forms change in time and with nothing else: they read states whose rate is constant, which no
/// law reads.
bool change_by_time_alone(const Problem& problem, const Operators& operators,
                          const Contact& contact) {
  if (operators.changing.empty()) return false;
  const bool laws_read = std::ranges::any_of(contact.terms, [&](const ContactTerm& term) {
    const int law = problem.law_terms[static_cast<std::size_t>(term.points.law_term)].law;
    return term.offset_of_states || !term.first_states.empty() ||
           contact.laws[static_cast<std::size_t>(law)]->reads_states();
  });
  return !laws_read && std::ranges::all_of(problem.states, [](const StateTerm& state) {
    return state.rate.is_constant();
  });
}

} // namespace

LawDescent descent_of_laws(const Problem& problem, const Operators& operators,
                           const Contact& contact) {
  LawDescent out;
  if (contact.coupled) out.obstacle = "a law is coupled to another one";
  if (contact.mixed) out.obstacle = "a law sees different fields in different components";
  if (!contact.readings.empty()) out.obstacle = "a law reads the solution";
  const bool by_time = change_by_time_alone(problem, operators, contact);
  if (!contact.state_groups.empty() && !by_time)
    out.obstacle = "laws with states are solved together with them";
  if (!operators.changing.empty() && !by_time) out.obstacle = "states change the forms";
  for (const LoadTerm& load : problem.state_loads)
    out.obstacle =
        reads_solution(problem, load) ? "a load reads the solution" : "states change the loads";
  // The factor of each step is that of a positive definite matrix, or there is none (E0425).
  if (by_time && !operators.symmetric)
    out.obstacle =
        "the forms change in time and are not symmetric: that they are coercive at every "
        "step was not looked at";
  out.weight.assign(problem.law_terms.size(), 0.0);
  for (const auto& term : contact.terms) {
    const int index = problem.law_terms[term.points.law_term].law;
    const Law& law = *contact.laws[index];
    out.moves = out.moves || law.depends_on_x() || law.depends_on_t();
    if (!out.obstacle.empty() || term.n_points() == 0) continue;
    const KnownConstants known = descent_of(problem, term, law);
    const Bracket& m = known.m;
    out.weight[term.points.law_term] = m.value();
    out.softens = out.softens || m.value() > 0.0;
    if (std::isinf(m.value()))
      out.obstacle = fmt::format("`{}` {}", law.spec().name,
                                 known.jumps_down ? "jumps down" : "falls arbitrarily steeply");
    else if (!m.bounded_by_proof())
      out.obstacle = fmt::format("m_J of `{}` is sampled, not proved", law.spec().name);
  }
  if (by_time && out.softens && out.obstacle.empty())
    out.obstacle =
        "laws soften while the forms change in time: their descent was not compared with "
        "the matrix of every step";
  return out;
}

Uniqueness::Uniqueness(const Problem& problem, const Operators& operators, const Contact& contact)
    : problem_(problem), operators_(operators), contact_(contact),
      laws_(descent_of_laws(problem, operators, contact)),
      settled_(!laws_.obstacle.empty() || contact.none() ||
               (!laws_.softens && operators.symmetric)) {
  if (settled_) return;
  const bool small = static_cast<int>(contact_.unknowns.size()) <= most_judged_points;
  const bool one_matrix = surely_one_matrix(problem_);
  condensed_ = !laws_.moves && operators_.symmetric && (contact_.whole || small) && one_matrix;
  const auto multipliers = multipliers_of(problem_);
  unsymmetric_ = !operators_.symmetric && !contact_.whole && small && one_matrix &&
                 std::ranges::count(multipliers, 0) == std::ssize(multipliers);
}

void Uniqueness::judge(bool convex) {
  settled_ = true;
  if (!convex) laws_.obstacle = too_soft();
}

/// Two solutions differ by e with  S e_c = -G_c^T W dxi  on the contact unknowns c, and interior
/// rows of K e are 0. So sym(w (S - D_c)) decides, w the weights of the equations, D the descent of
/// the laws; it is positive definite wherever sym(w (K - D)) is.
void Uniqueness::judge_condensed(const SparseMatrix& k, const DenseMatrix& s) {
  const std::vector<double> in_increments =
      in_step(contact_, laws_.weight, step_weights(problem_).c.front());
  const SparseMatrix descent = law_form(contact_, in_increments, contact_.problem.g);
  DenseMatrix rest = s; // large: changed in its place
  for (int i = 0; i < descent.rows(); ++i)
    for (SparseMatrix::InnerIterator it(descent, i); it; ++it) rest(i, it.col()) -= it.value();
  if (!contact_.of_unknown.empty()) {
    const ProductForm form(k, contact_.of_unknown, unknowns_with_laws(problem_),
                           couplings_of(problem_));
    const auto& unknown = contact_.problem.of_unknown;
    for (Eigen::Index j = 0; j < rest.cols(); ++j)
      for (Eigen::Index i = 0; i < rest.rows(); ++i)
        rest(i, j) *=
            form.weight(unknown[static_cast<std::size_t>(i)], unknown[static_cast<std::size_t>(j)]);
  }
  for (Eigen::Index j = 0; j < rest.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i) rest(i, j) = rest(j, i) = 0.5 * (rest(i, j) + rest(j, i));
  judge(DenseCholesky(rest).positive());
}

std::string Uniqueness::too_soft() const {
  return laws_.softens ? "the laws soften faster than the body is stiff (step ratio of 1 or more)"
                       : "there are laws, and the forms are not coercive";
}

namespace {

/// Is sym K(c) - D positive definite, D the descent of the laws? By Cholesky factors whose pattern
/// is analysed once.
class DescentTest {
public:
  /// `like`: a factor of a step's K, whose analysis is taken over; or null.
  DescentTest(const Problem& problem, const Operators& operators, const Contact& contact,
              const std::vector<double>& weight, const Factorisation* like)
      : problem_(problem), operators_(operators), contact_(contact), weight_(weight),
        shares_(present_shares(*make_scheme(problem), count_fields(problem))),
        descent_(law_form(contact, weight, operators.n_unknowns)) {
    take_over(like);
  }
  bool passes(const Eigen::VectorXd& c);

private:
  void take_over(const Factorisation* like);

  const Problem& problem_;
  const Operators& operators_;
  const Contact& contact_;
  const std::vector<double>& weight_; ///< steepest descent of each law term's slope
  Vector shares_;                     ///< of the fields in a step's equation
  SparseMatrix descent_; ///< of all laws; where some act on rates, of the step that is looked at
  std::unique_ptr<Factorisation> factor_;
  bool same_pattern_ = false; ///< `factor_` is for the pattern of K
};

bool DescentTest::passes(const Eigen::VectorXd& c) {
  SparseMatrix rest = combine(operators_, operators_.weights.transpose() * shares_.cwiseProduct(c));
  if (!contact_.other_fields.empty())
    descent_ = law_form(contact_, in_step(contact_, weight_, c), operators_.n_unknowns);
  if (same_pattern_)
    add_scaled(rest, -1.0, descent_);
  else
    rest = SparseMatrix(rest - descent_);
  if (!contact_.of_unknown.empty())
    rest =
        ProductForm(rest, contact_.of_unknown, unknowns_with_laws(problem_), couplings_of(problem_))
            .symmetric_part(rest);
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
void DescentTest::take_over(const Factorisation* like) {
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

} // namespace

void Uniqueness::judge_all(const Factorisation* like) {
  settled_ = true;
  DescentTest test(problem_, operators_, contact_, laws_.weight, like);
  const auto worst = worst_step(
      step_weights(problem_),
      [&](const Eigen::VectorXd& c) { return test.passes(c) ? 0.0 : infinity; }, most_judged);
  if (worst.bound == 0.0) return;
  if (problem_.time.is_static)
    judge(false);
  else if (worst.ratio > 0.0)
    laws_.obstacle = fmt::format("in step {} (t = {:.6g}) {}", worst.step,
                                 problem_.time.grid[worst.step], too_soft());
  else
    laws_.obstacle = fmt::format("it could not be shown for all {} steps in {} trials",
                                 problem_.time.grid.size() - 1, most_judged);
}

} // namespace hvi::solver
