// Iterative refinement of a step in extended precision; see step.hpp.
//
// J. Demmel, Y. Hida, W. Kahan, X. S. Li, S. Mukherjee, E. J. Riedy, Error bounds from
// extra-precise iterative refinement, ACM Trans. Math. Softw. 32 (2006) 325-351: residuals in twice
// the working precision make the solution of an ill-conditioned system as accurate as its matrix,
// as long as the factor gains at all.
#include "solver/linear/double_double.hpp"
#include "solver/time/rounding.hpp"
#include "solver/time/step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

constexpr int most_passes = 60;
/// A correction of this relative size is the rounding of the state itself.
constexpr double smallest_correction = 4e-16;
/// Corrections that shrink slower than this have come to their end.
constexpr double slow = 0.5;
/// The last correction must be smaller: else the factor of K gains nothing.
constexpr double largest_last = 1e-6;

} // namespace

/// Asked of each new factor: a pair of sweeps beside it.
void Stepper::look_at_conditioning(StepMatrix& matrix) {
  if (layout_.interior || refines_) return;
  refines_ = matrix.growth() > growth_to_refine;
  if (!refines_) return;
  never_shortened_ = true;
  shortened_ = nullptr;
  predictor_.clear();
}

/// gap = f - sum_b T_b w_b in extended precision with w_b = what acts on T_b in step n when d is
/// the increment; returns the backward error of gap - G^T W xi. `known`: -w_b of d = 0.
double Stepper::precise_gap(int n, const StepMatrix& matrix, const std::vector<Vector>& known,
                            const Vector& d) {
  add_load(n);
  std::vector<DoubleDouble> sums(static_cast<std::size_t>(n_unknowns_));
  scale_ = rhs_.cwiseAbs();
  for (int i = 0; i < n_unknowns_; ++i) sums[static_cast<std::size_t>(i)].high = rhs_[i];
  const Vector gamma = coefficients(n);
  for (int b = 0; b < operators_.n_bases(); ++b) {
    combined_ = -known[static_cast<std::size_t>(b)];
    combined_.head(n_unknowns_) += gamma[b] * d;
    subtract_product(operators_.bases[b], combined_, sums, scale_);
    ++products_;
  }
  for (int i = 0; i < n_unknowns_; ++i) gap_[i] = sums[static_cast<std::size_t>(i)].value();
  return equilibrium_error(matrix.k(), d, gap_, scale_, contact_.force, inequality_.xi);
}

/// d_ and the multipliers of an attempted step, corrected until that moves nothing. The laws are
/// solved about the present state, so their unknowns are corrections, too.
void Stepper::refine(int n, StepMatrix& matrix, StepResult& out) {
  if (!d_.allFinite()) return;
  const Vector known = known_;
  std::vector<Vector> on_base(operators_.bases.size());
  for (int b = 0; b < operators_.n_bases(); ++b) {
    if (!known_part(n, b)) combined_.setZero();
    on_base[static_cast<std::size_t>(b)] = combined_;
  }
  Vector total = d_;
  const int iterations = out.inequality.iterations, events = out.inequality.events;
  double last = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < most_passes; ++pass) {
    precise_gap(n, matrix, on_base, total);
    known_.head(n_unknowns_) = known.head(n_unknowns_) + total;
    if (!contact_.none()) prepare(contact_, plan_, grid_.t(n), known_, inequality_.xi);
    inequality_.c.setZero();
    const auto report = matrix.start(gap_, inequality_, d_);
    ++out.corrections;
    const double size = known_.lpNorm<Eigen::Infinity>(), moved = d_.lpNorm<Eigen::Infinity>();
    const double correction = size > 0.0 ? moved / size : 0.0;
    if (!std::isfinite(correction) || correction > slow * last) break;
    total += d_;
    out.inequality = report;
    last = correction;
    if (correction <= smallest_correction) break;
  }
  out.inequality.iterations += iterations, out.inequality.events += events;
  known_ = known;
  d_ = total;
  for (std::size_t i = 0; i < contact_.unknowns.size(); ++i)
    inequality_.c[static_cast<Eigen::Index>(i)] = d_[contact_.unknowns[i]];
  if (!contact_.none()) prepare(contact_, plan_, grid_.t(n), known_, inequality_.xi);
  out.equilibrium = precise_gap(n, matrix, on_base, d_);
  kd_.noalias() = matrix.k() * d_;
  last_correction_ = std::max(last_correction_, last);
  if (last <= largest_last) return;
  throw TooInaccurate(
      FailureKind::not_certified, plan_.space.origin,
      fmt::format("the matrix of step {} is too ill-conditioned for double precision: corrections "
                  "with residuals in extended precision still change the state by {:.1e} of its "
                  "size",
                  n, last),
      better_conditioned);
}

} // namespace hvi::solver
