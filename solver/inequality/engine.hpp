// The inequality solver: which of its parts (engine_parts.hpp) is asked when. Internal to
// solver/inequality.
#pragma once

#include "solver/inequality/engine_parts.hpp"

namespace hvi::solver {

class InequalityEngine {
public:
  InequalityEngine(const ReducedProblem& problem, ReducedOperator& s, InequalityOptions options,
                   std::span<const double> factors)
      : parts_(problem, s, options, factors) {}
  // As in InequalitySolver.
  InequalityReport solve(const Vector& r, InequalityState& io);
  InequalityReport solve_coupled(const Vector& r, InequalityState& io);
  bool convex() { return is_convex(parts_.points, parts_.pattern, parts_.factor); }
  bool respond(const InequalityState& at_state, std::span<const Vector> r,
               std::vector<Vector>& change_c, std::vector<Vector>& change_xi);
  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  void solve_at_once(Methods methods, InequalityState& io, InequalityReport& report);
  void solve_and_follow(InequalityState& io, InequalityReport& report);

  EngineParts parts_;
  // Room for a solve.
  StepStart start_;
  InequalityState before_;
};

} // namespace hvi::solver
