// What a small change of the right-hand side does to a solution (tangent.hpp).
#include "solver/inequality/tangent.hpp"

namespace hvi::solver {

/// (S + H) dc = r with the linearisation of the graphs at the state: slopes inside pieces, held
/// points at breaks. The bound of a coupled law is taken as it is.
bool respond(const InequalityState& state, std::span<const Vector> r, Position& at,
             const StiffnessPattern& pattern, LastFactor& factor, std::vector<Vector>& change_c,
             std::vector<Vector>& change_xi) {
  const ContactPoints& points = at.points;
  InequalityState from = state;
  from.c_guess.resize(0), from.xi_guess.resize(0);
  at.load(from);
  // A state that is not stable has a tangent, too: its matrix is not positive definite.
  std::unique_ptr<ReducedOperator> indefinite;
  if (InequalityReport made; !factor.make(at.places.d, made)) {
    SparseMatrix h = pattern.zero();
    pattern.assemble(at.places.d, h);
    indefinite = factor.op().unsymmetric();
    if (!indefinite || !indefinite->factor(h, {})) return false;
  }
  const ReducedOperator& op = indefinite ? *indefinite : factor.op();
  change_c.resize(r.size()), change_xi.resize(r.size());
  for (std::size_t k = 0; k < r.size(); ++k) {
    op.estimate(r[k], change_c[k]);
    const Vector dz = points.g * change_c[k];
    change_xi[k].resize(points.rows);
    for (int p = 0; p < points.size(); ++p)
      points[p].put(change_xi[k], at.places.times_stiffness(p, points[p].of(dz)));
  }
  return true;
}

} // namespace hvi::solver
