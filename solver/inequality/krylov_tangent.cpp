// See krylov_tangent.hpp.
#include "solver/inequality/krylov_tangent.hpp"

#include "solver/inequality/iterative_operator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

/// Of the residual while points still change their places, and at least where they do not.
constexpr double while_changing = 1e-1, when_settled = 1e-2, most_at_once = 1e-9;
/// Of what curved laws are expected to leave, which the first step after the last change has ten
/// to a hundred times too large.
constexpr double below_curves = 0.03;
/// Of points that rest and share their unknowns, as two bodies on each other do: slender ones turn
/// by what a hundredth of the forces leaves open, and their points change places again.
constexpr double while_resting_together = 1e-4;
/// And where stiffnesses that stand for infinite ones are most of it.
constexpr double most_of_penalties = 1e-12;
/// Of the target: norms fall about as fast as the worst row, and a body may move by what the last
/// digits of a residual say (a tenth left 2e-8 of a pressure, a hundredth 5e-10).
constexpr double below_target = 0.01;

} // namespace

/// Of the residual's norm, while points change their places. The forces which take points that have
/// come to rest to their breaks do not count: a step has to be exact beside the other ones.
double KrylovTangent::reduction_while_changing(const Position& at, const Vector& residual) const {
  Vector penalties = Vector::Zero(at.points.rows);
  bool together = false;
  for (int p = 0; p < at.points.size(); ++p) {
    const PointData& q = at.points[p];
    if (q.single || !at.places.resting(p)) continue;
    together = true;
    for (int row = q.first; row < q.first + q.rows; ++row)
      penalties[row] = at.xi[row] - at.places.xi_hat[row];
  }
  if (!together) return while_changing;
  // Residuals of several unknowns are weighed by what motions cost, these stiffnesses included.
  if (factor_.op().iterative()->several_unknowns()) return while_resting_together;
  const double all = residual.lpNorm<Eigen::Infinity>();
  if (penalties.isZero(0.0) || !(all > 0.0)) return while_resting_together;
  const Vector others = residual + at.points.force_of * penalties;
  return std::clamp(while_resting_together * others.lpNorm<Eigen::Infinity>() / all,
                    most_of_penalties, while_resting_together);
}

/// What curved laws will leave of the residual, however well the step is solved: what they left of
/// the last one beyond its solve, times the length of this step over the last one's, for Newton's
/// method converges quadratically. 0: straight laws.
double KrylovTangent::left_by_curves(const Vector& residual, const TangentStep& last) {
  if (!(last.before > 0.0) || last.rest.size() != residual.size()) return 0.0;
  const auto beyond_solve = (residual.cwiseAbs() - last.rest.cwiseAbs()).cwiseMax(0.0);
  return beyond_solve.matrix().norm() / last.before * (residual.norm() / last.before);
}

/// What is left of the residual's norm after a step: while points change their places a digit or
/// two are lost in the next step anyway; then one step may go as far as the target, or as curves
/// let it (S. C. Eisenstat, H. F. Walker, Choosing the forcing terms in an inexact Newton method,
/// SIAM J. Sci. Comput. 17 (1996) 16-32).
double KrylovTangent::reduction(const Position& at, const Vector& residual, bool settled,
                                const TangentStep& last) const {
  if (!settled) return reduction_while_changing(at, residual);
  const double worst = at.balance.worst_of(residual, at.c, at.xi);
  if (!(worst > 0.0)) return when_settled;
  const double of_target = below_target * at.balance.target() / worst;
  return std::clamp(std::max(of_target, below_curves * left_by_curves(residual, last)),
                    most_at_once, when_settled);
}

/// Rows may be as small as rounding of others, far from where anything acts: where those that do
/// not hold yet are beyond what the norm of all rows sees, they are solved for without the others.
Vector KrylovTangent::rows_unseen(const Position& at, const Vector& residual,
                                  double accuracy) const {
  return at.balance.beyond(below_target * at.balance.target(), accuracy * residual.norm(), residual,
                           at.c, at.xi);
}

bool KrylovTangent::solve(const Position& at, const Vector& residual, bool settled,
                          InequalityReport& report, TangentStep& out) {
  if (!factor_.make(at.places.d, report)) return false;
  const IterativeOperator& op = *factor_.op().iterative();
  const double accuracy = reduction(at, residual, settled, out);
  out.before = residual.norm();
  const Vector unseen = settled ? rows_unseen(at, residual, accuracy) : Vector();
  out.of_small_rows = unseen.size() > 0;
  using Outcome = IterativeAnswer::Outcome;
  const Outcome outcome =
      op.answer_to(out.of_small_rows ? unseen : residual, accuracy, out.dc).outcome;
  if (outcome == Outcome::indefinite) return false;
  if (outcome == Outcome::stagnated) { // another method may come where it does not
    out.dc.setConstant(std::numeric_limits<double>::quiet_NaN());
    return true;
  }
  pattern_.assemble(at.places.d, h_);
  finish_inexact(at, op, h_, residual, out);
  // Early steps are large and rough: sums of products would keep rounding of their size.
  out.product_known = false;
  return true;
}

} // namespace hvi::solver
