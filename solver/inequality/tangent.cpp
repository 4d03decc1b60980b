// What a small change of the right-hand side does to a solution (engine.hpp).
#include "solver/inequality/engine.hpp"

namespace hvi::solver {

/// (S + H) dc = r with the linearisation of the graphs at the state: slopes inside pieces, held
/// points at breaks. The bound of a coupled law is taken as it is.
bool InequalityEngine::respond(const InequalityState& at_state, std::span<const Vector> r,
                               std::vector<Vector>& change_c, std::vector<Vector>& change_xi) {
  refresh_laws();
  InequalityState from = at_state;
  from.c_guess.resize(0), from.xi_guess.resize(0);
  load(from);
  factored = false;
  forget_far();
  assemble();
  if (!op.factor(h, {})) return false;
  change_c.resize(r.size()), change_xi.resize(r.size());
  for (std::size_t k = 0; k < r.size(); ++k) {
    op.solve(r[k], change_c[k]);
    dz.noalias() = problem.g * change_c[k];
    change_xi[k].resize(n_rows);
    for (int p = 0; p < n_points; ++p) put(change_xi[k], p, apply_d(p, at(dz, p)));
  }
  return true;
}

} // namespace hvi::solver
