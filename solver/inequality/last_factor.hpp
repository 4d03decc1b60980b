// The factor of S + H that was made last. Nothing else factors the operator.
#pragma once

#include "solver/inequality/stiffness.hpp"
#include "solver/inequality/tangent_solver.hpp"

namespace hvi::solver {

class LastFactor final : public TangentSolver {
public:
  LastFactor(const ContactPoints& points, const StiffnessPattern& pattern, ReducedOperator& s);
  /// By a factor of this very H.
  bool solve(const Position& at, const Vector& residual, bool settled, InequalityReport& report,
             TangentStep& out) override;

  /// Factors S + H unless that is what is factored already. False: there is no factor.
  bool make(const PointMatrices& d, InequalityReport& report);
  /// Factors S + h for an h that no step of Newton's has; the next step begins anew.
  bool make_other(const SparseMatrix& h);
  void forget() { made_ = false; } ///< what it was made of has changed
  /// The factor of these stiffnesses again, or none, where a saved solver had none.
  void remake(PointMatrices d, bool made);

  bool made() const { return made_; }
  bool is_of(const PointMatrices& d) const { return made_ && d == d_; }
  const PointMatrices& stiffnesses() const { return d_; }
  int number() const { return number_; } ///< of the factors made: another factor, another number
  ReducedOperator& op() const { return op_; }

private:
  bool factor();
  void find_held_unknowns();

  const ContactPoints& points_;
  const StiffnessPattern& pattern_;
  ReducedOperator& op_;
  SparseMatrix h_;
  std::vector<int> held_; ///< unknowns that no factor needs
  PointMatrices d_;
  bool made_ = false;
  int number_ = 0;
};

/// Stiffness over that of the body: beyond it a point counts as held.
constexpr double holding_stiffness = 1e6;
/// Are all rows of a point held alike? (At the origin, or at a break of a scalar law.)
bool holds_all(const PointMatrices& d, const PointData& q);

} // namespace hvi::solver
