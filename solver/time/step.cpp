// One step of the fully discrete scheme; see step.hpp. Called by the loop in run.cpp.
#include "solver/time/step.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/common/parallel.hpp"
#include "solver/time/rigid.hpp"
#include "solver/time/snap.hpp"
#include "solver/time/uniqueness.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int most_corrections = 40;
/// The fixed point of coupled bounds goes on while so many passes make its error so much smaller.
constexpr int passes_to_judge = 8;
constexpr double contracts = 0.1;
/// A factor of another matrix (q(t, s) changes it) is kept while it gains three digits a
/// correction.
constexpr double slow_contraction = 1e-3;
/// With such a factor corrections go on until what it does not know is rounding: that error would
/// pile up over the steps.
constexpr double refined = 1e-13;
/// Matrices are stored once more, for products that read half, when a run has so many steps.
constexpr int worth_halving = 12;
/// No factor of more bytes is made once more with fewer bits.
constexpr double largest_shortened = 4e9;

} // namespace

Stepper::Stepper(const Plan& plan, const Discretisation& d, Timing& timing)
    : plan_(plan), discretisation_(d), timing_(timing), grid_(plan.time),
      layout_(make_layout(d.space, d.dofs)), never_shortened_(!plan.options.shortened_sweeps),
      sweeps_(plan.options.tolerance) {
  const PhaseClock<> clock(timing.assembly);
  operators_ = assemble_operators(plan, d, layout_);
  contact_ = make_contact(plan, d, layout_);
  loads_.emplace(d.space, d.parts, plan.loads);
  loads_->restrict_to({layout_.dof_of.data(), static_cast<std::size_t>(layout_.n_unknowns)});
  options_.tolerance = plan.options.tolerance;
  options_.branch = plan.options.branch;
  n_unknowns_ = layout_.n_unknowns;
  u_ = Vector::Zero(layout_.n_state);
  if (!grid_.is_static() && !plan.time.initial.empty())
    layout_.gather(interpolate(d.space, plan.time.initial, grid_.t(0), plan.time.origin), u_);
  reduce_if_possible();
  memory_.emplace(plan, layout_.n_state);
  operators_.memory_to_come = history_bytes_to_come(plan, memory_->reports(), layout_.n_state);
  require_memory(operators_.memory_to_come, "the fields its memories will hold");
  allocate();
  if (!grid_.is_static()) memory_->start(grid_.t(0), u_);
}

void Stepper::allocate() {
  known_ = d_previous_ = d_before_ = combined_ = Vector::Zero(layout_.n_state);
  dz_ = Vector::Zero(contact_.n_rows());
  d_ = rhs_ = gap_ = scale_ = work_ = kd_ = Vector::Zero(layout_.n_unknowns);
  left_over_.force = gap_;
  full_ = Vector::Zero(layout_.n_dofs);
  z_ = inequality_.xi = Vector::Zero(contact_.n_rows());
  inequality_.c = Vector::Zero(static_cast<Eigen::Index>(contact_.unknowns.size()));
  accepted_ = inequality_;
  if (grid_.steps() < worth_halving || !operators_.symmetric ||
      layout_.n_state > layout_.n_unknowns)
    return;
  halves_.resize(operators_.bases.size());
  for_each_piece(operators_.n_bases(), plan_.options.threads, [&](int b) {
    halves_[b] = SymmetricBlocks(operators_.bases[b], operators_.mirrored);
  });
  if (std::any_of(halves_.begin(), halves_.end(), [](const auto& half) { return half.empty(); }))
    halves_.clear();
}

/// known = u_{n-1} with the values imposed at t_n: what is known of u_n before the step.
void Stepper::impose_values(int n) {
  known_ = u_;
  if (layout_.n_state == layout_.n_unknowns) return;
  layout_.scatter(u_, full_);
  impose(discretisation_.space, plan_.space, discretisation_.dofs, grid_.t(n), full_);
  layout_.gather(full_, known_);
  known_.head(layout_.n_unknowns) = u_.head(layout_.n_unknowns);
}

void Stepper::add_load(int n) {
  rhs_.setZero();
  if (plan_.time.sampling == LoadSampling::average && !grid_.is_static())
    loads_->add_mean(grid_.t(n - 1), grid_.t(n), rhs_);
  else
    loads_->add(grid_.t(n), rhs_);
}

/// What K_n differs from the factored matrix by (q(t, s) changes it a little in every step), and
/// the increment it is moved to the right-hand side with: the predictor's, else the one that
/// continues the last two; the difference makes its error too small to need a second pair of
/// sweeps.
void Stepper::find_change(int n, const StepMatrix& matrix) {
  const Vector gamma = coefficients(n);
  change_ = gamma - matrix.gamma();
  for (int b = 0; b < operators_.n_bases(); ++b)
    if (std::abs(change_[b]) <= 8e-16 * std::abs(gamma[b])) change_[b] = 0.0;
  if (change_.isZero(0.0)) return;
  expected_.setZero(layout_.n_state);
  if (n < 2) return;
  auto expected = expected_.head(layout_.n_unknowns);
  if (predictor_.ready() && same_problem(n, matrix)) {
    predictor_.predict(d_);
    expected = d_;
    return;
  }
  expected = grid_.length(n) / grid_.length(n - 1) * d_previous_.head(layout_.n_unknowns);
  const bool even =
      n > 2 && grid_.length(n) == grid_.length(n - 1) && grid_.length(n) == grid_.length(n - 2);
  if (even) expected += (d_previous_ - d_before_).head(layout_.n_unknowns);
}

/// K_n from now on: nothing is left to move.
void Stepper::refactor(int n, StepMatrix& matrix) {
  for (int b = 0; b < operators_.n_bases(); ++b)
    if (change_[b] != 0.0) rhs_.noalias() += change_[b] * (operators_.bases[b] * expected_);
  change_.setZero();
  factor_or_explain(matrix, coefficients(n), {operators_, grid_, n}, plan_, discretisation_,
                    layout_);
}

/// combined_ = - what all fields put on base matrix b, with what is known of u_n. False: nothing.
bool Stepper::known_part(int n, int b) {
  const auto weight = operators_.weights.col(b);
  double on_known = weight[field_u];
  for (int m = 0; m < memory_->size(); ++m)
    on_known += weight[first_history_field + m] * memory_->w0(m);
  bool any = on_known != 0.0;
  const auto add = [&](const auto& term) {
    if (any)
      combined_ -= term;
    else
      combined_ = -term;
    any = true;
  };
  if (any) combined_ = -on_known * known_;
  for (int m = 0; m < memory_->size(); ++m)
    if (const double w = weight[first_history_field + m]; w != 0.0) add(w * memory_->known(m));
  if (grid_.is_static() || weight[field_rate] == 0.0) return any;
  // What is known of u': imposed values move, and BDF2 carries the last increment on.
  if (layout_.n_state > layout_.n_unknowns) add(weight[field_rate] * grid_.rate(n) * (known_ - u_));
  if (grid_.carry(n) != 0.0) add(-weight[field_rate] * grid_.carry(n) * d_previous_);
  return any;
}

/// rhs = f_n - sum_b T_b ( what all fields put on base matrix b ): one product per base matrix.
/// Includes - change_b T_b expected.
void Stepper::right_hand_side(int n) {
  add_load(n);
  if (layout_.interior) load_ = rhs_;
  for (int b = 0; b < operators_.n_bases(); ++b) {
    bool any = known_part(n, b);
    if (!any && (layout_.interior || change_[b] != 0.0)) combined_.setZero(), any = true;
    if (layout_.interior) stress_ = -combined_; // there is one base only
    if (change_[b] != 0.0) combined_ -= change_[b] * expected_;
    if (!any || combined_.isZero(0.0)) continue;
    if (halves_.empty()) {
      combined_ = -combined_;
      subtract_product(operators_.bases[b], combined_, rhs_);
    } else {
      halves_[b].add_product(combined_, rhs_);
    }
    ++products_;
  }
}

StepMatrix& Stepper::matrix_for(int n) {
  const double rate = grid_.is_static() ? 0.0 : grid_.rate(n);
  const auto found = std::find_if(matrices_.begin(), matrices_.end(), [&](const Cached& c) {
    return c.rate == rate && c.length == grid_.length(n);
  });
  if (found != matrices_.end()) {
    matrices_.splice(matrices_.begin(), matrices_, found);
    return *matrices_.front().matrix;
  }
  const StepMatrix* like = matrices_.empty() ? nullptr : matrices_.front().matrix.get();
  if (matrices_.size() < static_cast<std::size_t>(grid_.useful_factors()))
    matrices_.push_front(
        {0, 0, std::make_unique<StepMatrix>(operators_, contact_, options_, like)});
  else
    matrices_.splice(matrices_.begin(), matrices_, std::prev(matrices_.end()));
  auto& entry = matrices_.front();
  entry.rate = rate;
  entry.length = grid_.length(n);
  factor_or_explain(*entry.matrix, coefficients(n), {operators_, grid_, n}, plan_, discretisation_,
                    layout_);
  look_at_conditioning(*entry.matrix);
  return *entry.matrix;
}

void Stepper::judge_uniqueness(StepMatrix& matrix) {
  uniqueness_judged_ = true;
  Uniqueness uniqueness(plan_, operators_, contact_);
  if (!uniqueness.settled()) {
    if (uniqueness.condensed() && step_ == 0) // a restored solver goes on with the same bits
      uniqueness.judge(matrix.unique());
    else
      uniqueness.judge_all(matrix.factorisation());
  }
  not_unique_ = uniqueness.obstacle();
}

/// Coupled laws: their own passes settle the bounds, the path matters where a law softens.
bool Stepper::follows() const {
  return !not_unique_.empty() &&
         (!contact_.coupled ||
          std::ranges::any_of(contact_.softening, [](double m) { return m != 0.0; }));
}

/// gap = rhs - K_n d with K_n = K + sum_b change_b T_b, its scale, and the backward error.
double Stepper::residual(StepMatrix& matrix) {
  ++products_;
  if (change_.isZero(0.0)) {
    if (!halves_.empty()) matrix.halve(halves_);
    if (matrix.half().empty()) {
      const double error = equilibrium_error(matrix.k(), d_, rhs_, contact_.unknowns,
                                             contact_.force, inequality_.xi, gap_);
      kd_ = rhs_ - gap_;
      return error;
    }
    kd_.setZero(layout_.n_unknowns);
    matrix.half().add_product(d_, kd_);
    return equilibrium_error(matrix.k(), matrix.half().diagonal(), kd_, d_, rhs_, contact_.unknowns,
                             contact_.force, inequality_.xi, gap_);
  }
  gap_and_scale(matrix.k(), d_, rhs_, gap_, scale_);
  kd_ = rhs_ - gap_;
  combined_ = expected_;
  combined_.head(layout_.n_unknowns) -= d_;
  mismatch_ = 0.0;
  for (int b = 0; b < operators_.n_bases(); ++b) {
    if (change_[b] == 0.0) continue;
    work_.noalias() = operators_.bases[b] * combined_;
    work_ *= change_[b];
    gap_ += work_;
    mismatch_ += (work_.array().abs() / scale_.array().max(1e-300)).maxCoeff();
    ++products_;
  }
  return equilibrium_error(matrix.k(), d_, gap_, scale_, contact_.force, inequality_.xi);
}

/// Has step n the matrix and the length of the steps that the predictor knows?
bool Stepper::same_problem(int n, const StepMatrix& matrix) const {
  return n > 1 && grid_.length(n) == grid_.length(n - 1) &&
         predicted_gamma_.size() == matrix.gamma().size() && predicted_gamma_ == matrix.gamma();
}

/// After an accepted step.
void Stepper::learn(int n, StepMatrix& matrix, const StepResult& result) {
  if (grid_.is_static() || refines_) return predictor_.clear();
  // Nothing is smooth across a jump.
  if (result.snap || result.inequality.events > 0) return predictor_.clear();
  if (!same_problem(n, matrix)) predictor_.clear();
  predicted_gamma_ = matrix.gamma();
  predictor_.note(d_, kd_, inequality_.xi);
  choose_storage(n, matrix);
}

/// Extrapolates from the last steps, if they had this factor: d_ and gap_ = rhs - K_n d_, for d_ is
/// then what the change of K_n was moved with.
bool Stepper::predict(int n, const StepMatrix& matrix) {
  if (!predictor_.ready() || !same_problem(n, matrix)) return false;
  predictor_.predict(d_);
  predictor_.predict_gap(rhs_, gap_);
  if (contact_.none()) return true;
  inequality_.xi_guess.swap(xi_guess_);
  predictor_.predict_multipliers(inequality_.xi_guess);
  guess_from_increment();
  return true;
}

/// The search for the contact unknowns begins at those of d_.
void Stepper::guess_from_increment() {
  auto& guess = inequality_.c_guess;
  guess.swap(c_guess_);
  guess.resize(static_cast<Eigen::Index>(contact_.unknowns.size()));
  for (Eigen::Index i = 0; i < guess.size(); ++i) guess[i] = d_[contact_.unknowns[i]];
}

/// The room of a guess is kept for the next step.
void Stepper::drop_guess() {
  if (inequality_.c_guess.size() > 0) inequality_.c_guess.swap(c_guess_);
  if (inequality_.xi_guess.size() > 0) inequality_.xi_guess.swap(xi_guess_);
  inequality_.c_guess.resize(0), inequality_.xi_guess.resize(0);
}

/// The sweeps are bound by reading the factor: fewer bits an entry halve that where the
/// extrapolation is so good that one pair of sweeps is enough.
void Stepper::choose_storage(int n, StepMatrix& matrix) {
  if (never_shortened_ || contact_.whole) return;
  if (shortened_ == nullptr) {
    if (!predictor_.ready() || !sweeps_.worthwhile(grid_.steps() - n)) return;
    never_shortened_ = matrix.statistics().bytes > largest_shortened || !matrix.shorten();
    if (!never_shortened_) shortened_ = &matrix;
    return;
  }
  if (shortened_ != &matrix) return;
  sweeps_.count_step();
  if (sweeps_.failed()) shortened_ = nullptr, never_shortened_ = true;
}

/// Solves step n; `again`: d_, gap_ and the multipliers are those of the same step with other laws.
StepResult Stepper::correct(int n, StepMatrix& matrix, bool again) {
  StepResult out;
  const double tolerance = plan_.options.tolerance;
  const bool shortened = shortened_ == &matrix;
  const double target = shortened ? sweeps_.target() : tolerance;
  if (again) inequality_.xi_guess = inequality_.xi;
  if (again) guess_from_increment();
  const bool predicted = again || predict(n, matrix);
  matrix.limit_sweeps(shortened && predicted ? sweeps_.limits(!contact_.none()) : SweepLimits{});
  sweeps_.note_moved(std::numeric_limits<double>::infinity());
  inequality_.c.setZero(); // the path to the new state starts at the last one
  const Vector* const right = change_.isZero(0.0) ? &rhs_ : nullptr;
  double last = std::numeric_limits<double>::infinity();
  int iterations = 0, events = 0, reattached = 0, inner = 0;
  double gap = -1.0;
  bool not_followed = false;
  while (out.corrections < most_corrections) {
    if (out.corrections > 0) matrix.limit_sweeps({});
    out.inequality = out.corrections == 0 && !predicted
                         ? matrix.start(rhs_, inequality_, d_)
                         : matrix.correct(gap_, right, inequality_, d_);
    drop_guess();
    ++out.corrections;
    iterations += out.inequality.iterations;
    events += out.inequality.events, reattached += out.inequality.reattached;
    if (out.inequality.least_gap >= 0.0) gap = out.inequality.least_gap;
    inner += out.inequality.inner_steps;
    not_followed = not_followed || out.inequality.not_followed;
    auto& ends = out.inequality.branch_ends;
    out.branch_ends.insert(out.branch_ends.end(), ends.begin(), ends.end());
    out.equilibrium = residual(matrix);
    if (!contact_.none()) find_reach(matrix.contact_diagonal(), kd_, d_, rhs_, contact_);
    if (predicted && out.corrections == 1) {
      sweeps_.note_moved(matrix.moved());
      if (matrix.swept_forward() != SweepStorage::full && change_.isZero(0.0))
        sweeps_.learn(matrix.swept_forward(), matrix.swept_back(), out.equilibrium);
    }
    const bool exact = change_.isZero(0.0) || mismatch_ <= refined;
    if (!out.inequality.converged || (exact && out.equilibrium <= target)) break;
    const bool slow = out.equilibrium > slow_contraction * last;
    if (slow && change_.isZero(0.0)) break;
    if (slow && out.equilibrium <= tolerance) break; // at the rounding of the products
    last = out.equilibrium;
    if (!slow) continue;
    refactor(n, matrix);
    // The error is measured anew: what was moved with the change may have been most of its scale.
    last = std::numeric_limits<double>::infinity();
  }
  out.inequality.iterations = iterations;
  out.inequality.events = events, out.inequality.reattached = reattached;
  out.inequality.least_gap = gap;
  out.inequality.inner_steps = inner, out.inequality.not_followed = not_followed;
  return out;
}

/// Are all laws at d_ those of its own multipliers, and kept?
bool Stepper::bounds_agree(int n) {
  prepare(contact_, plan_, grid_.t(n), known_, inequality_.xi);
  combined_ = known_;
  combined_.head(layout_.n_unknowns) += d_;
  const double tolerance = plan_.options.tolerance;
  inclusion_ = inclusion_error(contact_, combined_, inequality_.xi, tolerance, z_).worst;
  return inclusion_ <= tolerance;
}

/// Coulomb's bound depends on the normal multiplier: the step is solved again with the bounds of
/// its own last solution while that contracts, else by Newton's method with the bounds unknown,
/// too. Leaves the graphs at the last solution's bounds, whether they still move or not: the
/// certificate judges all laws at one state.
void Stepper::couple_bounds(int n, StepMatrix& matrix, StepResult& out) {
  const auto again = [&] {
    if (follows()) {
      inequality_.z_before = path_start_.z_before;
      inequality_.xi_before = path_start_.xi, inequality_.state_before = path_start_.state;
    }
    const int iterations = out.inequality.iterations, corrections = out.corrections;
    out = correct(n, matrix, true);
    out.inequality.iterations += iterations;
    out.corrections += corrections;
    return bounds_agree(n);
  };
  if (bounds_agree(n) && out.inequality.converged) return;
  double before = inclusion_;
  for (int pass = 1; out.inequality.converged; ++pass) {
    if (again() && out.inequality.converged) return;
    if (pass % passes_to_judge != 0) continue;
    if (!(inclusion_ < contracts * before)) break; // infinite ones do not fall, either
    before = inclusion_;
  }
  matrix.couple_bounds(true);
  if (!again() && out.inequality.verdict.empty())
    out.inequality.verdict =
        "the laws do not hold with the bounds that the multipliers of the same state make";
  matrix.couple_bounds(false);
}

/// From the last accepted state to known_ = u_n, with its certificate; nothing is accepted.
StepResult Stepper::attempt(int n, StepMatrix& matrix) {
  impose_values(n);
  find_change(n, matrix);
  if (follows() && !change_.isZero(0.0)) { // where a branch ends, K_n itself has to say
    factor_or_explain(matrix, coefficients(n), {operators_, grid_, n}, plan_, discretisation_,
                      layout_);
    change_.setZero();
  }
  right_hand_side(n);
  if (!contact_.none()) prepare(contact_, plan_, grid_.t(n), known_, inequality_.xi);
  if (follows()) {
    const double before = grid_.is_static() ? 0.0 : grid_.t(n - 1);
    arguments_of(contact_, plan_, before, u_, inequality_.z_before);
    if (contact_.coupled) path_start_ = inequality_;
  }
  auto out = correct(n, matrix, false);
  if (contact_.coupled) couple_bounds(n, matrix, out);
  if (refines_) refine(n, matrix, out);
  corrections_ += out.corrections;
  newton_ += out.inequality.iterations;
  fallbacks_ += out.inequality.used_fallback ? 1 : 0;

  known_.head(layout_.n_unknowns) += d_; // now u_n
  const bool waits = checks_wait_ && n < grid_.steps();
  if (!checked_.empty() && checked_[n] != 0 && !waits)
    out.equilibrium = std::max(out.equilibrium, equilibrium_of_all(n));
  out.inclusion = inclusion_error(contact_, known_, inequality_.xi, plan_.options.tolerance, z_);
  const double tolerance = plan_.options.tolerance;
  out.certified =
      out.inequality.converged && out.equilibrium <= tolerance && out.inclusion.worst <= tolerance;
  return out;
}

StepResult Stepper::advance(int n) {
  {
    const PhaseClock<wall_seconds> clock(timing_.history);
    memory_->begin_step(grid_.t(n));
  }
  auto& matrix = matrix_for(n);
  if (!uniqueness_judged_) judge_uniqueness(matrix);
  auto out = attempt(n, matrix);
  if (!out.certified && predictor_.ready()) { // the extrapolated start may have led astray
    predictor_.clear();
    inequality_ = accepted_;
    out = attempt(n, matrix);
  }
  if (out.certified) {
    inner_steps_ += out.inequality.inner_steps;
    unfollowed_ += out.inequality.not_followed;
    followed_ += out.inequality.inner_steps > 0 && !out.inequality.not_followed;
  }
  const bool guess = out.inequality.inner_steps == 0 || out.inequality.not_followed;
  if (!out.branch_ends.empty())
    out.snap = true;
  else if (out.certified && guess && operators_.symmetric && !contact_.none())
    out.snap = is_snap(contact_, inequality_.c, kd_.dot(d_), dz_);
  if (out.certified) {
    if (checks_wait_ && !checked_.empty()) put_off_check(n);
    learn(n, matrix, out);
    note_left_over(out.equilibrium);
    accept(n);
  } else
    inequality_ = accepted_;
  return out;
}

void Stepper::accept(int n) {
  if (!grid_.is_static()) {
    const PhaseClock<wall_seconds> clock(timing_.history);
    memory_->commit(grid_.t(n), known_);
    d_before_.swap(d_previous_);
    if (layout_.n_state == layout_.n_unknowns)
      d_previous_.swap(d_);
    else
      d_previous_ = known_ - u_;
  }
  u_.swap(known_);
  accepted_ = inequality_;
  step_ = n;
  note_size();
}

} // namespace hvi::solver
