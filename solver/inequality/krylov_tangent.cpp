// See krylov_tangent.hpp.
#include "solver/inequality/krylov_tangent.hpp"

#include "solver/inequality/iterative_operator.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// Of the residual while points still change their places, and at least where they do not.
constexpr double while_changing = 1e-2, when_settled = 1e-2, most_at_once = 1e-9;
/// Of the target: norms fall about as fast as the worst row.
constexpr double below_target = 0.1;

} // namespace

/// What is left of the residual's norm after a step: while points change their places two digits
/// are lost in the next step anyway; then one step may go as far as the target.
double KrylovTangent::reduction(const Position& at, const Vector& residual, bool settled) const {
  if (!settled) return while_changing;
  const Vector &load = at.balance.load(), &s_c = at.balance.product.value();
  double worst = 0.0;
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    const double size =
        std::abs(load[i]) + std::abs(s_c[i]) + std::abs(points_.diagonal[i] * at.c[i]);
    if (size > 0.0) worst = std::max(worst, std::abs(residual[i]) / size);
  }
  if (!(worst > 0.0)) return when_settled;
  return std::clamp(below_target * at.balance.target() / worst, most_at_once, when_settled);
}

bool KrylovTangent::solve(const Position& at, const Vector& residual, bool settled,
                          InequalityReport& report, TangentStep& out) {
  if (!factor_.make(at.places.d, report)) return false;
  const IterativeOperator& op = *factor_.op().iterative();
  if (!op.solve_to(residual, reduction(at, residual, settled), out.dc)) return false;
  pattern_.assemble(at.places.d, h_);
  finish_inexact(at, op, h_, residual, out);
  return true;
}

} // namespace hvi::solver
