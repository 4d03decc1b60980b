// See corrector.hpp.
#include "solver/step/corrector.hpp"

#include "solver/common/clock.hpp"

namespace hvi::solver {
namespace {

/// y = the forward solve of the gap, r = what it leaves on the contact unknowns. Without a factor
/// there are no others.
void condense(const SharedFactor& factor, const Vector& gap, CorrectionSolves& solves, Vector& y,
              Vector& r) {
  if (!factor) {
    r = gap;
    return;
  }
  factor->order().gather(gap, y);
  solves.forward(*factor, y);
  r = y.tail(factor->order().contacts());
}

/// x with the contact part c, from the y of `condense`.
void expand(const SharedFactor& factor, const Vector& c, double moved, CorrectionSolves& solves,
            Vector& y, Vector& x) {
  if (!factor) {
    x = c;
    return;
  }
  y.tail(factor->order().contacts()) = c;
  solves.back(*factor, moved, y);
  factor->order().scatter(y, x);
}

} // namespace

Corrector::Corrector(const Contact& contact, bool separate)
    : contact_(contact), separate_(separate) {
  r_ = c_ = product_ = Vector::Zero(static_cast<Eigen::Index>(contact.unknowns.size()));
}

/// x_ = the correction of a d whose contact part is c_, which becomes the contact part of x_.
Correction Corrector::solve(const StepMatrix& matrix, const Vector& gap, const Vector* rhs,
                            bool couple_bounds, CorrectionSolves& solves, InequalityState& state) {
  Correction out;
  LapClock<wall_seconds> clock;
  const SharedFactor& factor = matrix.factorisation();
  condense(factor, gap, solves, y_, r_);
  if (contact_.none()) {
    expand(factor, r_, 0.0, solves, y_, x_);
    clock.charge(seconds_triangular);
    out.report.converged = true;
    return out;
  }
  add_part_of(c_, matrix, gap, rhs, state);
  clock.charge(seconds_triangular);
  auto& laws = *matrix.laws();
  out.report = couple_bounds ? laws.solve_coupled(r_, state) : laws.solve(r_, state);
  if (state.s_c_guess.size() > 0) state.s_c_guess.swap(product_);
  clock.charge(seconds_inequality);
  c_ = state.c - c_;
  const double size = state.c.lpNorm<Eigen::Infinity>();
  out.moved = size > 0.0 ? c_.lpNorm<Eigen::Infinity>() / size : 0.0;
  expand(factor, c_, out.moved, solves, y_, x_);
  clock.charge(seconds_triangular);
  return out;
}

/// r_ += S c
void Corrector::add_part_of(const Vector& c, const StepMatrix& matrix, const Vector& gap,
                            const Vector* rhs, InequalityState& state) {
  if (c.isZero(0.0)) return;
  const bool whole = !matrix.factorisation();
  if (rhs != nullptr && (separate_ || whole)) { // gap = rhs - K d
    product_ = rhs->head(c.size()) - gap.head(c.size());
    if (whole) matrix.add_held(c, product_); // r_ is exactly 0 on a piece that nothing acts on
  } else {
    matrix.reduced()->apply(c, product_);
  }
  r_ += product_;
  if (state.c_guess.size() == c.size() && state.c_guess == c) state.s_c_guess.swap(product_);
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
  contact_part(contact_, d, c_);
  auto out = solve(matrix, gap, rhs, couple_bounds, solves, state);
  d += x_;
  const double size = d.lpNorm<Eigen::Infinity>();
  out.change = size > 0.0 ? x_.lpNorm<Eigen::Infinity>() / size : 0.0;
  if (contact_.none()) out.moved = 100.0 * out.change; // no law damps rounding: as strict as that
  return out;
}

} // namespace hvi::solver
