// The parts of the inequality solver (engine_parts.hpp).
#include "solver/inequality/engine_parts.hpp"

#include "solver/inequality/certificate.hpp"

namespace hvi::solver {

EngineParts::EngineParts(const ReducedProblem& problem, ReducedOperator& s,
                         InequalityOptions options_given, std::span<const double> factors)
    : options(options_given), points(problem, s, factors), pattern(points),
      at(points, s, s.aim() * options.tolerance), factor(points, pattern, s),
      tangent(points, pattern, factor), krylov(pattern, factor),
      newton(s.iterative() ? static_cast<TangentSolver&>(krylov) : tangent, options),
      components(factor, newton, options), inverse(points, pattern, s, options),
      follower(points, pattern, factor, newton, components, options) {
  points.estimate_compliance(s, pattern.zero());
}

void certify_found(EngineParts& parts, InequalityReport& report, double snap) {
  parts.at.balance.leave_at_rest(parts.at.xi, parts.at.c);
  certify(parts.at, parts.options.tolerance, report, snap);
}

} // namespace hvi::solver
