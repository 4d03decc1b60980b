// The matrix of a step with its factor, condensed to the contact unknowns; see step_matrix.hpp.
#include "solver/time/step_matrix.hpp"

#include "solver/common/clock.hpp"
#include "solver/linear/condition_estimate.hpp"
#include "solver/linear/separate.hpp"

namespace hvi::solver {

StepMatrix::StepMatrix(const Operators& operators, const Contact& contact,
                       const InequalityOptions& options, const StepMatrix* like)
    : operators_(operators), contact_(contact), options_(options), like_(like) {
  const auto n_contact = static_cast<Eigen::Index>(contact.unknowns.size());
  r_ = c_ = product_ = Vector::Zero(n_contact);
  x_ = Vector::Zero(operators.n_unknowns);
}

void StepMatrix::factor(const Vector& gamma) {
  gamma_ = gamma;
  SparseMatrix k = combine(operators_, gamma);
  k_.swap(k); // Eigen 3.4 copies what is moved
  half_ = {};
  solver_.reset();
  contact_diagonal_.resize(r_.size());
  for (Eigen::Index i = 0; i < r_.size(); ++i)
    contact_diagonal_[i] = k_.coeff(contact_.unknowns[i], contact_.unknowns[i]);
  if (contact_.whole) {
    reduced_ = sparse_operator(k_, operators_.symmetric);
  } else {
    make_factor();
    if (contact_.none()) return;
    reduced_ = dense_operator(factorisation_->schur(), operators_.symmetric);
  }
  solver_ = std::make_unique<InequalitySolver>(contact_.problem, *reduced_, options_, law_factors_);
}

/// The first factor may be shared with another run, and is then replaced by one of this run; a
/// factor of this run is made anew in its place.
void StepMatrix::make_factor() {
  if (factorisation_ && !factorisation_.is_shared()) {
    factorisation_->factor(k_);
    return;
  }
  if (operators_.separate) {
    factorisation_ =
        SharedFactor(separate_factor(*operators_.separate, operators_.n_unknowns), false, false);
    factorisation_->factor(k_);
    return;
  }
  const StepMatrix* like = std::exchange(like_, nullptr);
  auto* from = factorisation_ ? nullptr : operators_.shared;
  if (from == nullptr && like != nullptr && like->factorisation_) {
    factorisation_ = SharedFactor(like->factorisation_->another(), false, false);
    factor_where_it_fits(*factorisation_.operator->(), k_, contact_.unknowns.size(), 0.0);
    return;
  }
  factorisation_ =
      take_factor(from, k_, contact_.unknowns, operators_.symmetric, operators_.memory_to_come);
}

void StepMatrix::condense(const Vector& gap, const Vector* rhs, CorrectionSolves& solves,
                          InequalityState& state) {
  const bool separate = operators_.separate && rhs != nullptr;
  if (contact_.whole)
    r_ = gap;
  else
    solves.reduce(*factorisation_.operator->(), gap, r_);
  if (c_.isZero(0.0)) return;
  if (separate) // gap = rhs - K d, and no other unknown has a part in S c
    product_ = rhs->head(c_.size()) - gap.head(c_.size());
  else
    reduced_->apply(c_, product_);
  r_ += product_;
  if (state.c_guess.size() == c_.size() && state.c_guess == c_) state.s_c_guess.swap(product_);
}

void StepMatrix::expand(const InequalityState& state, CorrectionSolves& solves, Correction& out) {
  c_ = state.c - c_;
  const double size = state.c.lpNorm<Eigen::Infinity>();
  out.moved = size > 0.0 ? c_.lpNorm<Eigen::Infinity>() / size : 0.0;
  if (contact_.whole)
    x_ = c_;
  else
    solves.back(*factorisation_.operator->(), c_, out.moved, x_);
}

/// x_ = the correction of a d whose contact part is c_.
Correction StepMatrix::solve(const Vector& gap, const Vector* rhs, bool couple_bounds,
                             CorrectionSolves& solves, InequalityState& state) {
  Correction out;
  LapClock<wall_seconds> clock;
  if (contact_.none()) {
    solves.reduce(*factorisation_.operator->(), gap, r_);
    solves.back(*factorisation_.operator->(), r_, 0.0, x_);
    clock.charge(seconds_triangular);
    out.report.converged = true;
    return out;
  }
  condense(gap, rhs, solves, state);
  clock.charge(seconds_triangular);
  out.report = couple_bounds ? solver_->solve_coupled(r_, state) : solver_->solve(r_, state);
  if (state.s_c_guess.size() > 0) state.s_c_guess.swap(product_);
  clock.charge(seconds_inequality);
  expand(state, solves, out);
  clock.charge(seconds_triangular);
  return out;
}

InequalityReport StepMatrix::start(const Vector& gap, InequalityState& state, Vector& d) {
  c_.setZero();
  CorrectionSolves own(0.0);
  auto out = solve(gap, nullptr, false, own, state);
  d.swap(x_);
  return std::move(out.report);
}

Correction StepMatrix::correct(const Vector& gap, const Vector* rhs, bool couple_bounds,
                               CorrectionSolves& solves, InequalityState& state, Vector& d) {
  for (Eigen::Index i = 0; i < c_.size(); ++i) c_[i] = d[contact_.unknowns[i]];
  auto out = solve(gap, rhs, couple_bounds, solves, state);
  d += x_;
  if (contact_.none()) { // no law damps rounding: a hundred times as strict
    const double size = d.lpNorm<Eigen::Infinity>();
    out.moved = size > 0.0 ? 100.0 * x_.lpNorm<Eigen::Infinity>() / size : 0.0;
  }
  return out;
}

double StepMatrix::condition() {
  if (factorisation_) return estimate_condition(k_, *factorisation_.operator->());
  const auto factor = analyse(k_, {}, operators_.symmetric);
  factor->factor(k_);
  return estimate_condition(k_, *factor);
}

bool StepMatrix::respond(std::span<const Vector> forces, const InequalityState& at,
                         std::vector<Vector>& x, std::vector<Vector>& xi) {
  x.resize(forces.size());
  if (contact_.whole) return solver_->respond(at, forces, x, xi);
  std::vector<Vector> r, c;
  factorisation_->reduce_each(forces, r);
  if (contact_.none())
    c = r; // without entries
  else if (!solver_->respond(at, r, c, xi))
    return false;
  factorisation_->back_each(c, x);
  return true;
}

double StepMatrix::bytes() const {
  return static_cast<double>(k_.nonZeros()) * (sizeof(double) + sizeof(int)) + half_.bytes() +
         (reduced_ ? reduced_->bytes() : 0.0);
}

FactorStatistics StepMatrix::statistics() const {
  return factorisation_ ? factorisation_.statistics() : FactorStatistics{};
}

} // namespace hvi::solver
