// The solution of one step; see step_solver.hpp. Called by the Stepper.
#include "solver/time/step_solver.hpp"

#include "solver/common/numbers.hpp"
#include "solver/time/saved_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hvi::solver {
namespace {

constexpr int most_changes = 40;
/// The fixed point of coupled bounds goes on while so many passes make its error so much smaller.
constexpr int passes_to_judge = 8;
constexpr double contracts = 0.1;
/// A factor of another matrix (q(t, s) changes it) is kept while it gains three digits a
/// correction.
constexpr double slow_contraction = 1e-3;
/// With such a factor corrections go on until what it does not know is rounding: that error would
/// pile up over the steps.
constexpr double refined = 1e-13;

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

StepSolver::StepSolver(const Plan& plan, const Discretisation& discretisation,
                       const Evolution& evolution, Formulation& formulation, Balance& balance,
                       std::unique_ptr<CorrectionSolves> solves)
    : plan_(plan), evolution_(evolution), formulation_(formulation),
      contact_(formulation.contact()), balance_(balance),
      matrices_(plan, discretisation, formulation, evolution.scheme()), solves_(std::move(solves)),
      refinement_(plan.problem, evolution, balance, contact_) {
  laws_.xi = Vector::Zero(contact_.n_rows());
  laws_.c = Vector::Zero(static_cast<Eigen::Index>(contact_.unknowns.size()));
  accepted_ = laws_;
}

StepMatrix& StepSolver::matrix_for(int n) {
  const auto [matrix, fresh] = matrices_.find(n, evolution_.factors(n));
  if (fresh && !formulation_.reduced() && refinement_.begins_with(matrix)) {
    solves_->stop();
    predictor_.clear();
  }
  return matrix;
}

/// The difference between K_n and the factored matrix, and the expected increment with which that
/// difference is moved to the right-hand side: the predictor's, else the one that continues the
/// last two. The difference is small, so that the error of the expected increment needs no second
/// pair of triangular solves.
void StepSolver::find_change(int n, const StepMatrix& matrix, StepEquation& equation,
                             Trial& trial) const {
  const Vector gamma = balance_.coefficients(n);
  equation.change = gamma - matrix.gamma();
  for (Eigen::Index b = 0; b < gamma.size(); ++b)
    if (std::abs(equation.change[b]) <= 8e-16 * std::abs(gamma[b])) equation.change[b] = 0.0;
  if (equation.exact()) return;
  equation.expected.setZero(evolution_.u().size());
  if (n < 2) return;
  const auto n_unknowns = trial.d.size();
  auto expected = equation.expected.head(n_unknowns);
  if (predictor_.ready() && continues(n, matrix)) {
    predictor_.predict(trial.d);
    expected = trial.d;
    return;
  }
  const auto& grid = evolution_.grid();
  const Vector &last = evolution_.scheme().last(), &before = evolution_.scheme().before();
  expected = grid.length(n) / grid.length(n - 1) * last.head(n_unknowns);
  const bool even =
      n > 2 && grid.length(n) == grid.length(n - 1) && grid.length(n) == grid.length(n - 2);
  if (even) expected += (last - before).head(n_unknowns);
}

/// Has step n the matrix and the length of the steps that the predictor knows?
bool StepSolver::continues(int n, const StepMatrix& matrix) const {
  const auto& grid = evolution_.grid();
  return n > 1 && grid.length(n) == grid.length(n - 1) && predictor_.knows(matrix.gamma());
}

/// Extrapolates from the last steps, if they had this factor: d and gap = rhs - K_n d, for d is
/// then what the change of K_n was moved with.
bool StepSolver::predict(int n, const StepMatrix& matrix, const StepEquation& equation,
                         Trial& trial) {
  if (!predictor_.ready() || !continues(n, matrix)) return false;
  predictor_.predict(trial.d);
  predictor_.predict_gap(equation.rhs, trial.gap);
  if (contact_.none()) return true;
  laws_.xi_guess.swap(xi_guess_);
  predictor_.predict_multipliers(laws_.xi_guess);
  guess_from(trial.d);
  return true;
}

/// The search for the contact unknowns begins at those of d.
void StepSolver::guess_from(const Vector& d) {
  auto& guess = laws_.c_guess;
  guess.swap(c_guess_);
  guess.resize(static_cast<Eigen::Index>(contact_.unknowns.size()));
  for (Eigen::Index i = 0; i < guess.size(); ++i) guess[i] = d[contact_.unknowns[i]];
}

/// The memory of a guess is kept for the next step.
void StepSolver::drop_guess() {
  if (laws_.c_guess.size() > 0) laws_.c_guess.swap(c_guess_);
  if (laws_.xi_guess.size() > 0) laws_.xi_guess.swap(xi_guess_);
  laws_.c_guess.resize(0), laws_.xi_guess.resize(0);
}

/// Solves the equation from a prediction, or as `start` says.
StepResult StepSolver::correct(StepMatrix& matrix, Start start, StepEquation& equation,
                               Trial& trial) {
  StepResult out;
  const int n = equation.n;
  const double tolerance = plan_.options.tolerance;
  if (start != Start::predicted) {
    laws_.xi_guess = laws_.xi;
    guess_from(trial.d);
  }
  const bool predicted = start != Start::predicted || predict(n, matrix, equation, trial);
  const double target = solves_->begin(matrix.k(), predicted);
  const bool with_bounds = start == Start::again_with_bounds;
  laws_.c.setZero(); // the path to the new state starts at the last one
  const Vector* const right = equation.exact() ? &equation.rhs : nullptr;
  Together together;
  double last = infinity;
  while (out.corrections < most_changes) {
    const bool first = out.corrections++ == 0;
    Correction made;
    if (first && !predicted)
      made.report = matrix.start(equation.rhs, laws_, trial.d);
    else
      made = matrix.correct(trial.gap, right, with_bounds, *solves_, laws_, trial.d);
    drop_guess();
    out.inequality = std::move(made.report);
    together.add(out.inequality, out.branch_ends);
    const auto left = balance_.residual(equation, matrix, laws_.xi, trial);
    out.equilibrium = left.error;
    if (!contact_.none())
      find_reach(matrix.contact_diagonal(), trial.kd, trial.d, equation.rhs, contact_);
    solves_->judge(made.moved, out.equilibrium, equation.exact());
    const bool exact = equation.exact() || left.mismatch <= refined;
    if (!out.inequality.converged || (exact && out.equilibrium <= target)) break;
    const bool slow = out.equilibrium > slow_contraction * last;
    if (slow && equation.exact()) break;
    if (slow && out.equilibrium <= tolerance) break; // at the rounding of the products
    last = out.equilibrium;
    if (!slow) continue;
    balance_.take_back_change(equation);
    matrices_.factor(n, evolution_.factors(n), matrix);
    // The error is measured anew: what was moved with the change may have been most of its scale.
    last = infinity;
  }
  together.tell(out.inequality);
  return out;
}

/// Prepares the laws with the multipliers of the trial itself; the error of their inclusion then.
double StepSolver::bounds_error(const StepEquation& equation, Trial& trial) {
  prepare(contact_, plan_.problem, evolution_.grid().t(equation.n),
          law_fields(equation.n, equation.known, nullptr), laws_.xi);
  state_ = equation.known;
  state_.head(trial.d.size()) += trial.d;
  return inclusion_error(contact_, law_fields(equation.n, state_, &trial.d), laws_.xi,
                         plan_.options.tolerance, trial.z)
      .worst;
}

/// Coulomb's bound depends on the normal multiplier: the step is solved again with the bounds of
/// its own last solution while that contracts, else by Newton's method with the bounds unknown,
/// too. Leaves the graphs at the last solution's bounds, whether they still move or not: the
/// certificate judges all laws at one state. `path_start`: where each pass begins its path, or
/// null.
void StepSolver::couple_bounds(StepMatrix& matrix, const InequalityState* path_start,
                               StepEquation& equation, Trial& trial, StepResult& out) {
  const double tolerance = plan_.options.tolerance;
  double error = bounds_error(equation, trial);
  const auto again = [&](Start start) {
    if (path_start != nullptr) {
      laws_.z_before = path_start->z_before;
      laws_.xi_before = path_start->xi, laws_.state_before = path_start->state;
    }
    const int iterations = out.inequality.iterations, corrections = out.corrections;
    out = correct(matrix, start, equation, trial);
    out.inequality.iterations += iterations;
    out.corrections += corrections;
    error = bounds_error(equation, trial);
    return error <= tolerance;
  };
  if (error <= tolerance && out.inequality.converged) return;
  double before = error;
  for (int pass = 1; out.inequality.converged; ++pass) {
    if (again(Start::again) && out.inequality.converged) return;
    if (pass % passes_to_judge != 0) continue;
    if (!(error < contracts * before)) break; // infinite ones do not fall, either
    before = error;
  }
  if (!again(Start::again_with_bounds) && out.inequality.verdict.empty())
    out.inequality.verdict =
        "the laws do not hold with the bounds that the multipliers of the same state make";
}

StepResult StepSolver::attempt(int n, StepMatrix& matrix, bool follow, StepEquation& equation,
                               Trial& trial) {
  const auto& grid = evolution_.grid();
  const double tolerance = plan_.options.tolerance;
  equation.n = n;
  balance_.known_state(n, equation.known);
  find_change(n, matrix, equation, trial);
  if (follow && !equation.exact()) { // where a branch ends, K_n itself has to say
    matrices_.factor(n, evolution_.factors(n), matrix);
    equation.change.setZero();
  }
  balance_.find_right_hand_side(equation);
  if (!contact_.none())
    prepare(contact_, plan_.problem, grid.t(n), law_fields(n, equation.known, nullptr), laws_.xi);
  std::optional<InequalityState> path_start;
  if (follow) {
    const double before = grid.is_static() ? 0.0 : grid.t(n - 1);
    arguments_of(contact_, plan_.problem, before, evolution_.law_fields(contact_.other_fields),
                 laws_.z_before);
    if (contact_.coupled) path_start = laws_;
  }
  auto out = correct(matrix, Start::predicted, equation, trial);
  if (contact_.coupled)
    couple_bounds(matrix, path_start ? &*path_start : nullptr, equation, trial, out);
  if (refinement_.on()) refinement_.refine(matrix, equation, trial, laws_, out);
  equation.known.head(trial.d.size()) += trial.d; // now u_n
  out.inclusion = inclusion_error(contact_, law_fields(n, equation.known, &trial.d), laws_.xi,
                                  tolerance, trial.z);
  return out;
}

bool StepSolver::can_begin_anew() {
  if (!predictor_.ready()) return false;
  predictor_.clear();
  give_up();
  return true;
}

void StepSolver::accept(int n, StepMatrix& matrix, const StepResult& result, Trial& trial) {
  accepted_ = laws_;
  const auto& grid = evolution_.grid();
  // Nothing is smooth across a jump.
  if (grid.is_static() || refinement_.on() || result.snap || result.inequality.events > 0)
    return predictor_.clear();
  if (!continues(n, matrix)) predictor_.clear();
  predictor_.note(matrix.gamma(), trial.d, trial.kd, laws_.xi);
  if (const auto* factor = matrix.factorisation())
    solves_->accept(matrix.k(), *factor, predictor_.ready(), grid.steps() - n);
}

void StepSolver::save(std::ostream& out) const {
  StateWriter w(out);
  put_vector(w, laws_.c);
  put_vector(w, laws_.xi);
  w.put(laws_.state);
  matrices_.save(out);
  predictor_.save(out);
  solves_->save(out, matrices_.all());
  refinement_.save(w);
}

namespace {

/// The pieces that contact points are on must be pieces of their laws.
void check_states(const Contact& contact, const std::vector<int>& states, const StateReader& r) {
  const auto& points = contact.problem.points;
  bool good = states.empty() || states.size() == points.size();
  for (std::size_t p = 0; good && p < states.size(); ++p)
    good = states[p] >= -1 && states[p] / 2 < contact.problem.graphs[points[p].graph].pieces();
  if (!good) r.fail("is inconsistent");
}

} // namespace

void StepSolver::restore(std::istream& in) {
  StateReader r(in, {});
  get_vector(r, laws_.c, laws_.c.size());
  get_vector(r, laws_.xi, contact_.n_rows());
  laws_.state = r.get_vector<int>();
  // Laws that move with time are prepared for the step's time before every solve.
  if (!contact_.none() && evolution_.step() > 0)
    prepare(contact_, plan_.problem, evolution_.t(), evolution_.law_fields(contact_.other_fields),
            laws_.xi);
  check_states(contact_, laws_.state, r);
  accepted_ = laws_;
  matrices_.restore(in);
  predictor_.restore(in, formulation_.layout().n_unknowns, contact_.n_rows());
  solves_->restore(in, matrices_.all());
  refinement_.restore(r);
}

} // namespace hvi::solver
