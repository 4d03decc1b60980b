// See corrector.hpp.
#include "solver/time/corrector.hpp"

#include "solver/common/clock.hpp"

namespace hvi::solver {

Corrector::Corrector(const Contact& contact, bool separate)
    : contact_(contact), separate_(separate) {
  r_ = c_ = product_ = Vector::Zero(static_cast<Eigen::Index>(contact.unknowns.size()));
}

void Corrector::condense(const StepMatrix& matrix, const Vector& gap, const Vector* rhs,
                         CorrectionSolves& solves, InequalityState& state) {
  if (contact_.whole)
    r_ = gap;
  else
    solves.reduce(*matrix.factorisation(), gap, r_);
  if (c_.isZero(0.0)) return;
  if (separate_ && rhs != nullptr) // gap = rhs - K d
    product_ = rhs->head(c_.size()) - gap.head(c_.size());
  else
    matrix.reduced()->apply(c_, product_);
  r_ += product_;
  if (state.c_guess.size() == c_.size() && state.c_guess == c_) state.s_c_guess.swap(product_);
}

void Corrector::expand(const StepMatrix& matrix, const InequalityState& state,
                       CorrectionSolves& solves, Correction& out) {
  c_ = state.c - c_;
  const double size = state.c.lpNorm<Eigen::Infinity>();
  out.moved = size > 0.0 ? c_.lpNorm<Eigen::Infinity>() / size : 0.0;
  if (contact_.whole)
    x_ = c_;
  else
    solves.back(*matrix.factorisation(), c_, out.moved, x_);
}

/// x_ = the correction of a d whose contact part is c_.
Correction Corrector::solve(const StepMatrix& matrix, const Vector& gap, const Vector* rhs,
                            bool couple_bounds, CorrectionSolves& solves, InequalityState& state) {
  Correction out;
  LapClock<wall_seconds> clock;
  if (contact_.none()) {
    solves.reduce(*matrix.factorisation(), gap, r_);
    solves.back(*matrix.factorisation(), r_, 0.0, x_);
    clock.charge(seconds_triangular);
    out.report.converged = true;
    return out;
  }
  condense(matrix, gap, rhs, solves, state);
  clock.charge(seconds_triangular);
  auto& laws = *matrix.laws();
  out.report = couple_bounds ? laws.solve_coupled(r_, state) : laws.solve(r_, state);
  if (state.s_c_guess.size() > 0) state.s_c_guess.swap(product_);
  clock.charge(seconds_inequality);
  expand(matrix, state, solves, out);
  clock.charge(seconds_triangular);
  return out;
}

InequalityReport Corrector::start(const StepMatrix& matrix, const Vector& gap,
                                  InequalityState& state, Vector& d) {
  c_.setZero();
  CorrectionSolves own(0.0);
  auto out = solve(matrix, gap, nullptr, false, own, state);
  d.swap(x_);
  return std::move(out.report);
}

Correction Corrector::correct(const StepMatrix& matrix, const Vector& gap, const Vector* rhs,
                              bool couple_bounds, CorrectionSolves& solves, InequalityState& state,
                              Vector& d) {
  for (Eigen::Index i = 0; i < c_.size(); ++i) c_[i] = d[contact_.unknowns[i]];
  auto out = solve(matrix, gap, rhs, couple_bounds, solves, state);
  d += x_;
  if (contact_.none()) { // no law damps rounding: a hundred times as strict
    const double size = d.lpNorm<Eigen::Infinity>();
    out.moved = size > 0.0 ? 100.0 * x_.lpNorm<Eigen::Infinity>() / size : 0.0;
  }
  return out;
}

} // namespace hvi::solver
