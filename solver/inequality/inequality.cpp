// The solver's face (inequality.hpp).
#include "solver/inequality/inequality.hpp"

#include "solver/inequality/engine.hpp"

namespace hvi::solver {

struct InequalitySolver::Impl : InequalityEngine {
  using InequalityEngine::InequalityEngine;
};

InequalitySolver::InequalitySolver(const ReducedProblem& problem, ReducedOperator& s,
                                   InequalityOptions options, std::span<const double> factors)
    : impl_(std::make_unique<Impl>(problem, s, options, factors)) {}
InequalitySolver::~InequalitySolver() = default;

InequalityReport InequalitySolver::solve(const Vector& r, InequalityState& state) {
  return impl_->solve(r, state);
}

InequalityReport InequalitySolver::solve_coupled(const Vector& r, InequalityState& state) {
  return impl_->solve_coupled(r, state);
}

bool InequalitySolver::convex() { return impl_->convex(); }
bool InequalitySolver::respond(const InequalityState& at_state, std::span<const Vector> r,
                               std::vector<Vector>& change_c, std::vector<Vector>& change_xi) {
  return impl_->respond(at_state, r, change_c, change_xi);
}
void InequalitySolver::save(std::ostream& out) const { impl_->save(out); }
void InequalitySolver::restore(std::istream& in) { impl_->restore(in); }

} // namespace hvi::solver
