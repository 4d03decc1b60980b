// See state_coupling.hpp. Called by the StepSolver.
#include "solver/step/state_coupling.hpp"

#include "solver/common/numbers.hpp"
#include "solver/step/coupled_bounds.hpp"
#include "solver/step/mixing.hpp"
#include "solver/step/state_kinds.hpp"
#include "solver/step/state_tangent.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace hvi::solver {
namespace {

/// States are moved on while they still come closer, down to this part of the tolerance.
constexpr double part_of_tolerance = 1e-3;
/// Plain passes go on where each leaves less than this of the error.
constexpr double contracts = 0.1;
/// Less where each has its own factor: Newton's method takes few of them.
constexpr double contracts_in_forms = 1e-3;
constexpr int most_newton = 40;
constexpr int most_plain = 400;
/// Passes that do not halve the least error so far: what gets to the tolerance at all is faster.
constexpr int most_in_vain = 100;
constexpr int most_mixed = 100;
/// The cosine of the directions of two passes that lead the same way.
constexpr double same_way = 0.7;
constexpr int between_newton = 10;
/// The way of the states over what they wanted at first: where a branch ends, it is two or three.
constexpr double most_stretched = 3.0;
/// From one step of a march to the next.
constexpr double longer = 1.2;
constexpr double shortest_newton = 1.0 / 64.0;
constexpr int most_leaps = 12;
/// A path ends where the step would have to grow by less than this part; at last by the other one.
constexpr double shortest_part = 1.0 / 16.0, smallest_share = 1e-4;

double cosine(const Vector& a, const Vector& b) {
  const double sizes = a.norm() * b.norm();
  return sizes > 0.0 ? a.dot(b) / sizes : 1.0;
}

class StateCoupling {
public:
  StateCoupling(const Problem& problem, EquationSolver& solver, Contact& contact, double tolerance,
                StepMatrix& matrix, const InequalityState* path_start, BodyTangent* body,
                const std::function<double()>& renew, StepEquation& equation, Trial& trial,
                StepResult& out)
      : problem_(problem), solver_(solver), states_(solver.laws.states), contact_(contact),
        tolerance_(tolerance), matrix_(matrix), path_start_(path_start), body_(body), renew_(renew),
        equation_(equation), trial_(trial), out_(out),
        algebraic_(std::ranges::any_of(problem.states, &StateTerm::algebraic)),
        has_rates_(!std::ranges::all_of(problem.states, &StateTerm::algebraic)) {}

  void run() {
    judge();
    if (!usable()) return; // the inequality itself has no solution: its verdict stands
    if (wanted_.size() > 0 && !read() && !in_forms()) { // a wear that is only told
      contact_.state_values = wanted_;
      return;
    }
    if (!find() && !(out_.inequality.converged && error_ <= tolerance_)) refuse();
  }

private:
  /// The solution that continues the last states, near them or on a path; else one that they lead
  /// to. False: there is none; the place is the nearest that was found.
  bool find() {
    const Here first = here();
    first_off_ = worst_;
    const bool settled = settle();
    if (settled && continues(first)) return keep_wanted();
    const Here nearest = here();
    if (has_rates_) {
      go(first);
      if (settle_on_path(shortest_part)) return keep_wanted();
    }
    go(settled || in_forms() ? nearest : first);
    if (settled || (in_forms() ? settle_in_forms(nearest) : settle_by_marching()))
      return keep_jumped();
    if (!in_forms()) {
      go(first);
      if (settle_on_path(smallest_share)) return keep_wanted();
    }
    go(nearest);
    return false;
  }

  void refuse() {
    out_.inequality.converged = false;
    const StateTerm& worst = problem_.states[static_cast<std::size_t>(std::max(worst_, 0))];
    out_.inequality.verdict =
        fmt::format("the {} and the solution do not settle on each other: the step is too long for "
                    "what it does there, or there is no solution near the last one",
                    worst.algebraic ? worst.name : fmt::format("state `{}`", worst.name));
    if (!obstacle_.empty())
      out_.inequality.verdict += "; with some of the states that were tried, " + obstacle_;
  }

  /// Does a law depend on a state?
  bool read() const {
    return std::ranges::any_of(contact_.terms, [](const ContactTerm& term) {
      return !term.first_states.empty() || term.offset_of_states;
    });
  }

  /// Do forms or loads depend on states?
  bool in_forms() const { return body_ != nullptr; }

  struct Here {
    Vector values, wanted;
    StateInputs inputs;
    double error;
    Trial trial;
    InequalityState now;
    StepResult out;
  };
  Here here() const {
    return {contact_.state_values, wanted_, inputs_, error_, trial_, solver_.laws.now, out_};
  }
  void go(const Here& place) {
    const int iterations = out_.inequality.iterations, corrections = out_.corrections;
    contact_.state_values = place.values;
    inputs_ = place.inputs, wanted_ = place.wanted, error_ = place.error;
    trial_ = place.trial, solver_.laws.now = place.now, out_ = place.out;
    out_.inequality.iterations = iterations, out_.corrections = corrections;
    if (in_forms()) renew_();
    solver_.laws.prepare(equation_.n, equation_.known);
  }

  /// Is there a solution for the states at hand?
  bool usable() const { return out_.inequality.converged && trial_.d.allFinite(); }

  /// What the states' equations make of the solution, and how far that is from them.
  void judge() {
    error_ = infinity;
    wanted_.resize(0);
    if (!usable()) return;
    state_ = equation_.known;
    state_.head(trial_.d.size()) += trial_.d;
    states_.inputs(state_, &trial_.d, solver_.laws.now.xi, inputs_);
    if (!states_.solve(inputs_.values, share_, wanted_)) return;
    const StateError left = states_.distance(wanted_, inputs_);
    error_ = left.worst, worst_ = left.state;
  }

  /// The solution for these states.
  void solve_with(const Vector& values) {
    const int iterations = out_.inequality.iterations, corrections = out_.corrections;
    contact_.state_values = values;
    auto& now = solver_.laws.now;
    try {
      renew_();
      solver_.laws.prepare(equation_.n, equation_.known);
    } catch (const Failure& failure) {
      if (failure.kind != FailureKind::bad_law && failure.kind != FailureKind::not_coercive) throw;
      error_ = infinity; // states for which there is no law, or no stiffness
      obstacle_ = failure.what();
      return;
    }
    if (path_start_ != nullptr) {
      now.z_before = path_start_->z_before;
      now.xi_before = path_start_->xi, now.state_before = path_start_->state;
    }
    out_ = solver_.solve(matrix_, CorrectionStart::again, equation_, trial_);
    if (contact_.coupled && usable())
      couple_bounds(solver_, tolerance_, matrix_, path_start_, equation_, trial_, out_);
    out_.inequality.iterations += iterations;
    out_.corrections += corrections;
    judge();
  }

  bool near() const { return error_ <= part_of_tolerance * tolerance_; }

  /// Plain passes while they contract, then Newton's method. False: neither gets there.
  bool settle() {
    const Here first = here();
    double before = infinity;
    const double enough = in_forms() ? contracts_in_forms : contracts;
    while (!near() && error_ < enough * before) {
      before = error_;
      solve_with(Vector(wanted_));
    }
    if (near()) return true;
    if (body_ != nullptr && algebraic_) {
      if (!(error_ < contracts * first.error)) go(first); // a steep load has gone far
      if (settle_from_inputs()) return true;
    }
    if (!std::isfinite(error_)) return false;
    for (int k = 0; k < most_newton; ++k) {
      before = error_;
      if (!newton() && !leap()) break;
      if (near()) return true;
      if (error_ <= tolerance_ && error_ > 0.25 * before) break; // rounding is left
    }
    return (!in_forms() && holds_with_wanted()) || (error_ <= tolerance_ && usable());
  }

  /// Where states change forms or loads and Newton's method ends at this place.
  bool settle_in_forms(const Here& place) {
    if (!std::isfinite(error_)) return false;
    if (settle_by_mixing()) return true;
    go(place);
    return settle_by_following();
  }

  /// Newton's method on what the states are made of. What a steep load makes of a solution that is
  /// a little off is far off, and the solution for that farther: there is no way back from it.
  /// False: the place is as it was.
  bool settle_from_inputs() {
    const Here first = here();
    Vector at = inputs_.values, size = Vector::Zero(at.size()), change;
    if (!take_states_of(at)) return false;
    double last = infinity;
    for (int k = 0; k < most_newton && usable() && !near(); ++k) {
      if (error_ <= tolerance_ && error_ > 0.25 * last) break; // rounding is left
      last = error_;
      if (!body_->step_from(at, pass(), matrix_, change)) break;
      const Here start = here();
      const double least = start.error <= tolerance_ ? 1.0 : shortest_newton;
      bool nearer = false;
      for (double t = 1.0; t >= least && !nearer; t /= 2.0) {
        if (t < 1.0) go(start);
        const Vector next = at + t * change;
        if (!take_states_of(next) || !usable()) continue;
        take_sizes(size);
        const double before = (start.inputs.values - at).cwiseQuotient(size).norm();
        nearer = (inputs_.values - next).cwiseQuotient(size).norm() < before ||
                 error_ < contracts * start.error;
        if (nearer) at = next;
      }
      if (nearer) continue;
      go(start);
      break;
    }
    if (usable() && error_ <= tolerance_) return true;
    go(first);
    return false;
  }

  /// The solution for the states that these inputs make. False: they make none.
  bool take_states_of(const Vector& inputs) {
    Vector states;
    if (!states_.solve(inputs, share_, states)) return false;
    solve_with(states);
    return true;
  }

  /// Of each kind of input the largest there was, before anything cancels.
  void take_sizes(Vector& size) const {
    for (const auto& group : contact_.state_groups)
      for (int row = group.first_input; row < group.first_input + group.n_inputs();
           row += group.n_points) {
        auto of_kind = size.segment(row, group.n_points);
        const double now = inputs_.scales.segment(row, group.n_points).lpNorm<Eigen::Infinity>();
        of_kind = of_kind.cwiseMax(std::max(now, std::numeric_limits<double>::min())).eval();
      }
  }

  /// What rounding leaves of multipliers that depend on each other, or of arguments that cancel, is
  /// another one in each pass, and states that read it find no rest. Does the last solution hold
  /// with the states that follow from it? They are taken if so.
  bool holds_with_wanted() {
    if (!usable() || wanted_.size() == 0) return false;
    const Here place = here();
    contact_.state_values = wanted_;
    Vector z;
    const double left = solver_.laws.settle_bounds(equation_.n, equation_.known, trial_.d, z);
    judge();
    if (left <= tolerance_ && error_ <= tolerance_) return true;
    go(place);
    return false;
  }

  /// Rates that begin at a threshold are steep on one side of it alone, so that a state which is as
  /// near as one can tell may leave much of its equation. What the solution makes of the states
  /// takes their place, and the forces of their loads change by as little as these. States at the
  /// points of laws stay: the multipliers are those of their values. True: the step has a solution.
  bool keep_wanted() {
    if (problem_.state_loads.empty() || wanted_.size() == 0) return true;
    const Here place = here();
    for (const auto& group : contact_.state_groups)
      for (const int i : group.states)
        if (const int first = contact_.first_state[static_cast<std::size_t>(i)]; group.body)
          contact_.state_values.segment(first, group.n_points) =
              wanted_.segment(first, group.n_points);
    out_.equilibrium = renew_();
    solver_.laws.prepare(equation_.n, equation_.known);
    judge();
    if (!(out_.equilibrium <= tolerance_)) go(place);
    return true;
  }

  /// Of a solution that was not followed from the last states.
  bool keep_jumped() {
    keep_wanted();
    if (has_rates_) out_.not_followed = std::max(first_off_, 0);
    return true;
  }

  /// Is this solution on the branch of that place, whose states want to go somewhere? They do all
  /// the way here, less and less. Beyond a place where a branch ends they want it more and more.
  /// Not asked where they came about as far as they wanted to.
  bool continues(const Here& from) {
    const Vector way = contact_.state_values - from.values;
    if (!has_rates_ || from.wanted.size() != way.size()) return true;
    const Vector along = by_squared_sizes(way, kinds_of_states(contact_));
    double last = along.dot(from.wanted - from.values);
    if (along.dot(way) <= most_stretched * std::abs(last)) return true;
    const Here place = here();
    bool less = true;
    for (double part = 0.25; part < 1.0 && less; part += 0.25) {
      solve_with(from.values + part * way);
      const double now =
          std::isfinite(error_) ? along.dot(wanted_ - contact_.state_values) : infinity;
      less = now <= last;
      last = now;
    }
    go(place);
    return less;
  }

  bool settle_by_mixing() {
    Mixing mixing(kinds_of_states(contact_));
    double best = error_;
    for (int k = 0; k < most_mixed && std::isfinite(error_); ++k) {
      solve_with(states_.kept(mixing.next(contact_.state_values, wanted_)));
      if (near()) return true;
      if (error_ <= tolerance_ && error_ > 0.5 * best) return true; // rounding is left
      best = std::min(best, error_);
    }
    return false;
  }

  /// Passes that follow the states to where these lead. They pass by a place where a solution has
  /// just ceased to be: on a long step softening runs on until points have lost all they can.
  /// Newton's method is tried from time to time.
  bool settle_by_following() {
    Vector before;
    double best = error_;
    for (int k = 1, in_vain = 0; k <= most_plain && in_vain < most_in_vain && std::isfinite(error_);
         ++k) {
      const Vector direction = wanted_ - contact_.state_values;
      const bool goes_on = k == 1 || cosine(direction, before) > same_way;
      before = direction;
      solve_with(Vector(wanted_));
      if (near() || (k % between_newton == 0 && settle_from_here())) return true;
      in_vain = goes_on || error_ < 0.5 * best ? 0 : in_vain + 1;
      best = std::min(best, error_);
    }
    return error_ <= tolerance_;
  }

  /// By Newton's method. False: the place is as it was.
  bool settle_from_here() {
    const Here place = here();
    for (int k = 0; k < most_newton && newton(); ++k)
      if (near()) return true;
    if (error_ <= tolerance_) return true;
    go(place);
    return false;
  }

  /// One step, halved until the error falls. False: it does not, and the place is as it was.
  bool newton() {
    Vector change, next;
    if (!(in_forms() ? step_of_body(change) : step_of_laws(change))) return false;
    const Here start = here();
    for (double t = 1.0; t >= shortest_newton; t /= 2.0) {
      const Vector inputs = start.inputs.values + t * change;
      if (states_.solve(inputs, share_, next)) {
        solve_with(next);
        if (error_ < start.error) return true;
      }
      go(start);
    }
    return false;
  }

  /// Whole steps that may leave more than the one before, for a while: where points begin to flow
  /// or stop, as beyond a yield stress, steps go past a place from which all shorter ones are
  /// worse.
  bool leap() {
    if (problem_.state_loads.empty()) return false;
    const Here start = here();
    Vector change, next;
    for (int k = 0; k < most_leaps && std::isfinite(error_) && step_of_body(change); ++k) {
      const Vector inputs = inputs_.values + change;
      if (!states_.solve(inputs, share_, next)) break;
      solve_with(next);
      if (error_ < start.error) return true;
    }
    go(start);
    return false;
  }

  bool step_of_laws(Vector& change) {
    Vector z;
    arguments(z);
    StateTangent tangent(problem_, contact_, states_, matrix_);
    return tangent.step({solver_.laws.now, z, inputs_.values, wanted_, share_}, change);
  }

  BodyPass pass() const {
    return {equation_.n, state_, trial_.d, solver_.laws.now, inputs_.values, wanted_, share_};
  }

  bool step_of_body(Vector& change) {
    return wanted_.size() > 0 && body_->step(pass(), matrix_, change);
  }

  void arguments(Vector& z) {
    z = contact_.problem.offset;
    const auto& factors = matrix_.law_factors();
    const Vector moved = contact_.problem.g * solver_.laws.now.c;
    for (const auto& term : contact_.terms)
      for (int row = 0; row < term.n_rows(); ++row)
        z[term.first_row + row] +=
            (factors.empty()
                 ? 1.0
                 : factors[static_cast<std::size_t>(slot::most_arguments * term.points.law_term +
                                                    row % term.points.rows)]) *
            moved[term.first_row + row];
  }

  /// Where what a state does makes it go on, as a bond that breaks, the states go after it: by ever
  /// longer steps while these keep their direction, and there it is looked for a solution.
  bool settle_by_marching() {
    Vector before;
    double stride = 1.0, best = error_;
    for (int pass = 0; pass < most_plain && wanted_.size() > 0 && !near(); ++pass) {
      const Vector direction = wanted_ - contact_.state_values;
      const bool onward = before.size() == 0 || direction.dot(before) > 0.0;
      if (!onward || error_ < contracts * best) {
        best = std::min(best, error_);
        const Here place = here();
        if (settle()) return true;
        go(place);
      }
      stride = onward ? longer * stride : std::max(1.0, stride / 8.0);
      before = direction;
      solve_with(states_.kept(contact_.state_values + stride * direction));
      if (!std::isfinite(error_)) return false;
    }
    return near() && usable();
  }

  /// Steps that grow from nothing to the full one, by no less than this part of it.
  bool settle_on_path(double least) {
    Here last = here();
    double reached = 0.0, step = 0.25;
    while (reached < 1.0) {
      share_ = std::min(1.0, reached + step);
      judge();
      const Here before = here(); // what the states want of this part of the step
      if (std::isfinite(error_) && settle() && continues(before)) {
        reached = share_, last = here();
        step *= 2.0;
        continue;
      }
      go(last);
      step /= 4.0;
      if (step < least) {
        share_ = 1.0;
        judge();
        return false;
      }
    }
    return usable();
  }

  const Problem& problem_;
  EquationSolver& solver_;
  const PointStates& states_;
  Contact& contact_;
  double tolerance_;
  StepMatrix& matrix_;
  const InequalityState* path_start_;
  BodyTangent* body_; ///< null where no form or load reads states
  const std::function<double()>& renew_;
  StepEquation& equation_;
  Trial& trial_;
  StepResult& out_;
  bool algebraic_; ///< loads read the solution
  bool has_rates_; ///< some states have: a part of a step is another problem
  double share_ = 1.0, error_ = infinity;
  int worst_ = -1;       ///< the state that is farthest off
  int first_off_ = -1;   ///< that which was at first
  std::string obstacle_; ///< why some states have no solution
  StateInputs inputs_;
  Vector wanted_, state_;
};

} // namespace

void couple_states(const Problem& problem, EquationSolver& solver, Contact& contact,
                   double tolerance, StepMatrix& matrix, const InequalityState* path_start,
                   BodyTangent* body, const std::function<double()>& renew, StepEquation& equation,
                   Trial& trial, StepResult& out) {
  StateCoupling(problem, solver, contact, tolerance, matrix, path_start, body, renew, equation,
                trial, out)
      .run();
}

void follow_refined(EquationSolver& solver, Contact& contact, double tolerance,
                    const StepEquation& equation, const Trial& trial) {
  const PointStates& states = solver.laws.states;
  Vector state = equation.known, z, wanted;
  state.head(trial.d.size()) += trial.d;
  StateInputs inputs;
  states.inputs(state, &trial.d, solver.laws.now.xi, inputs);
  if (!states.solve(inputs.values, 1.0, wanted)) return;
  const Vector before = std::exchange(contact.state_values, wanted);
  if (solver.laws.settle_bounds(equation.n, equation.known, trial.d, z) <= tolerance &&
      states.error(inputs).worst <= tolerance)
    return;
  contact.state_values = before;
  solver.laws.prepare(equation.n, equation.known);
}

} // namespace hvi::solver
