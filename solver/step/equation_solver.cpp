// See equation_solver.hpp.
#include "solver/step/equation_solver.hpp"

#include "solver/common/numbers.hpp"
#include "solver/inequality/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace hvi::solver {
namespace {

constexpr int most_changes = 40;
/// A factor of another matrix (q(t, s) changes it) is kept while it gains three digits a
/// correction.
constexpr double slow_contraction = 1e-3;
/// A body that laws alone hold (held_by_laws.hpp) is corrected while that gains anything.
constexpr double slow_when_free = 0.9;
/// Where T^T K T joins bodies, rounding of the one is all that a correction leaves in another one
/// that hardly moves. Each correction takes 16 digits off it, but a row's error is by its own size.
constexpr int corrections_of_joined = 4;
/// With such a factor corrections go on until what it does not know is rounding: that error would
/// pile up over the steps.
constexpr double refined = 1e-13;
/// A factor of singles leaves up to a hundredth of an error, laws more of it.
constexpr double slow_of_singles = 0.5;
/// With it corrections go on to what a factor of doubles leaves at once, rounding of the products,
/// or until the next one would move less than the tolerance, where the equation holds to this part
/// of it.
constexpr double left_by_doubles = 1e-14;
constexpr double well_within = 1e-2;

/// How far the next correction of a step with a factor of singles would move the increment, in
/// parts of it. Each leaves of an error about what the last one left of the one before.
class NextChange {
public:
  explicit NextChange(const StepMatrix& matrix)
      : least_(matrix.factorisation()->statistics().left) {}
  void note(double change) {
    const double left = last_ > 0.0 ? change / last_ : slow_of_singles;
    next_ = std::max(left, least_) * change;
    last_ = change;
  }
  double next() const { return next_; }

private:
  double least_; ///< that is left, by the factor alone: laws may have moved first
  double last_ = 0.0, next_ = infinity;
};

/// What the corrections of a step did together; of the rest the last one tells.
class Together {
public:
  void add(const InequalityReport& of, std::vector<double>& branch_ends) {
    sum_.iterations += of.iterations;
    sum_.events += of.events, sum_.reattached += of.reattached;
    sum_.inner_steps += of.inner_steps;
    if (of.least_gap >= 0.0) sum_.least_gap = of.least_gap;
    sum_.not_followed = sum_.not_followed || of.not_followed;
    branch_ends.insert(branch_ends.end(), of.branch_ends.begin(), of.branch_ends.end());
  }
  void tell(InequalityReport& last) const {
    last.iterations = sum_.iterations;
    last.events = sum_.events, last.reattached = sum_.reattached;
    last.inner_steps = sum_.inner_steps;
    last.least_gap = sum_.least_gap;
    last.not_followed = sum_.not_followed;
  }

private:
  InequalityReport sum_;
};

} // namespace

EquationSolver::EquationSolver(const Plan& plan, const Discretisation& discretisation,
                               Formulation& formulation, const Evolution& evolution,
                               Balance& balance, std::unique_ptr<CorrectionSolves> solves_)
    : laws(plan.problem, plan.options.tolerance, evolution, formulation.contact()),
      matrices(plan, discretisation, formulation, evolution.scheme()),
      warm_start(evolution, formulation.contact()),
      corrector(formulation.contact(), formulation.operators().separate.has_value()),
      solves(std::move(solves_)), tolerance_(plan.options.tolerance), formulation_(formulation),
      evolution_(evolution), balance_(balance) {}

StepResult EquationSolver::solve(StepMatrix& matrix, CorrectionStart start, StepEquation& equation,
                                 Trial& trial) {
  StepResult out;
  Contact& contact = formulation_.contact();
  auto& now = laws.now;
  if (start != CorrectionStart::predicted) warm_start.begin_at(trial.d, now);
  const bool guessed =
      start != CorrectionStart::predicted || warm_start.predict(matrix, equation, trial, now);
  const bool singles = matrix.in_singles();
  const double target =
      std::min(solves->begin(matrix.k(), guessed), singles ? left_by_doubles : infinity);
  const bool with_bounds = start == CorrectionStart::again_with_bounds;
  now.c.setZero(); // the path to the new state starts at the last one
  const Vector* const right = equation.exact() ? &equation.rhs : nullptr;
  Together together;
  std::optional<NextChange> of_singles;
  if (singles) of_singles.emplace(matrix);
  double last = infinity;
  while (out.corrections < most_changes) {
    matrices.before_iteration();
    const bool first = out.corrections++ == 0;
    Correction made;
    if (first && !guessed)
      made.report = corrector.start(matrix, equation.rhs, now, trial.d);
    else
      made = corrector.correct(matrix, trial.gap, right, with_bounds, *solves, now, trial.d);
    warm_start.drop_guess(now);
    out.inequality = std::move(made.report);
    together.add(out.inequality, out.branch_ends);
    const auto left = judge(matrix, equation, trial, out);
    solves->judge(made.moved, out.equilibrium, equation.exact());
    const bool exact = equation.exact() || left.mismatch <= refined;
    if (!out.inequality.converged || (exact && out.equilibrium <= target)) break;
    if (of_singles) of_singles->note(made.change);
    if (of_singles && exact && out.equilibrium <= well_within * tolerance_ &&
        of_singles->next() <= tolerance_)
      break;
    const bool free = matrix.free_body() != nullptr;
    const bool early = contact.change && out.corrections <= corrections_of_joined;
    const double least_gain = free ? slow_when_free : singles ? slow_of_singles : slow_contraction;
    const bool slow = !early && out.equilibrium > least_gain * last;
    if (slow && equation.exact()) {
      if (out.equilibrium > tolerance_ && !free)
        out.equilibrium =
            balance_.error_beside_rounding(equation, matrix, now.xi, trial, tolerance_);
      break;
    }
    if (slow && out.equilibrium <= tolerance_) break; // at the rounding of the products
    last = out.equilibrium;
    if (!slow) continue;
    take_back_change(formulation_.operators(), equation);
    matrices.factor(equation.n, evolution_.factors(equation.n), matrix);
    if (of_singles) of_singles.emplace(matrix);
    // The error is measured anew: what was moved with the change may have been most of its scale.
    last = infinity;
  }
  together.tell(out.inequality);
  return out;
}

/// What is left of the equation, and out.equilibrium: on the rows that hold, or would without what
/// is rounding; of a body that laws alone hold on its motions, too.
EquationResidual EquationSolver::judge(StepMatrix& matrix, const StepEquation& equation,
                                       Trial& trial, StepResult& out) {
  Contact& contact = formulation_.contact();
  const Vector& xi = laws.now.xi;
  const FreeBody* const body = matrix.free_body();
  auto left = balance_.residual(equation, matrix, xi, trial);
  if (contact.change && left.error > tolerance_ && body == nullptr &&
      put_at_rest(matrix.k(), contact, equation.rhs, xi, trial.d))
    left = balance_.residual(equation, matrix, xi, trial);
  if (left.error > tolerance_ && out.inequality.converged && body == nullptr)
    left = without_rounding(matrix, equation, trial, left);
  out.equilibrium = left.error;
  if (body != nullptr)
    out.equilibrium = std::max(left.error, balance_error(*body, contact, equation.rhs, xi));
  if (!contact.none())
    find_reach(matrix.contact_diagonal(), trial.kd, trial.d, equation.rhs, contact);
  return left;
}

/// Where bodies only just touch, what they press is rounding of the forces elsewhere, which nothing
/// can balance: without it, where the equation holds so. The laws are asked at the end of the step.
EquationResidual EquationSolver::without_rounding(StepMatrix& matrix, const StepEquation& equation,
                                                  Trial& trial, const EquationResidual& left) {
  const Contact& contact = formulation_.contact();
  Vector& xi = laws.now.xi;
  const Vector before = xi, d = trial.d;
  ByUnknown most{}; // of terms, which may cancel in sums
  const auto note = [&](int i, double force) {
    double& of = most[contact.unknown_of(i)];
    of = std::max(of, rounding_of_tolerance * tolerance_ * std::abs(force));
  };
  for (int i = 0; i < equation.rhs.size(); ++i) note(i, equation.rhs[i]);
  for (Eigen::Index c = 0; c < matrix.contact_diagonal().size(); ++c)
    note(contact.loaded[c], matrix.contact_diagonal()[c] * d[contact.loaded[c]]);
  if (!drop_rounding(contact.problem, most, xi)) return left;
  if (matrix.dealt() != nullptr)
    put_at_rest(matrix.dealt()->pieces(), contact, equation.rhs, xi, trial.d);
  else
    put_at_rest(matrix.k(), contact, equation.rhs, xi, trial.d);
  const auto without = balance_.residual(equation, matrix, xi, trial);
  if (without.error <= tolerance_) return without;
  xi = before, trial.d = d;
  return balance_.residual(equation, matrix, xi, trial);
}

void EquationSolver::account(WorkCounters& work, Timing& timing) const {
  matrices.account(work, timing);
  charge(solves->statistics(), work, timing);
  timing.inequality += corrector.seconds_inequality;
  timing.triangular_solves += corrector.seconds_triangular;
}

void EquationSolver::save(std::ostream& out) const {
  StateWriter w(out);
  laws.save(w);
  matrices.save(out);
  warm_start.save(out);
  solves->save(out, matrices.all());
}

void EquationSolver::restore(std::istream& in) {
  StateReader r(in, {});
  laws.restore(r);
  matrices.restore(in);
  warm_start.restore(in, formulation_.layout().n_unknowns);
  solves->restore(in, matrices.all());
}

} // namespace hvi::solver
