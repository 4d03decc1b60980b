// Newton's method on a step with states: the states are eliminated point by point.
//
// At a solution (c, xi) of the inequality for given states z, with z^ = what the states' equations
// make of its inputs a, points keep their places on their graphs and
//
//   dxi = A dc + X dz,    da = R dc + Phi dxi,    dz = (z^ - z) + S da,    S_c dc + G^T W dxi = 0,
//
// A, X: slopes of the laws by displacements and states; R, Phi: of the inputs; S: of the local
// solutions. With N = (I - S Phi X)^-1, which acts within points,
//
//   (S_c + G^T W (A + X N S (R + Phi A))) dc = - G^T W X N (z^ - z).
#pragma once

#include "solver/formulation/step_matrix.hpp"
#include "solver/step/point_states.hpp"

namespace hvi::solver {

/// A solution for given states, and what the states' equations make of it.
struct StatePass {
  const InequalityState& laws;
  const Vector& z;        ///< arguments of all laws
  const Vector& inputs;   ///< a
  const Vector& solution; ///< z^
  double share = 1.0;     ///< of the step (PointStates::solve)
};

class StateTangent {
public:
  /// Keeps references to all of them.
  StateTangent(const Problem& problem, const Contact& contact, const PointStates& states,
               const StepMatrix& matrix);
  /// The change da of the inputs. False: no regular matrix.
  bool step(const StatePass& pass, Vector& change);

private:
  void add_point(const ContactTerm& term, int p, const StatePass& pass);
  void add_offsets(const ContactTerm& term);
  double factor_of(const ContactTerm& term, int row) const; ///< row of a point
  double holding(const ContactPoint& point, double factor) const;
  double change_of_state(int state, int p) const;
  void assemble(const StatePass& pass);

  const Problem& problem_;
  const Contact& contact_;
  const PointStates& states_;
  const StepMatrix& matrix_;
  std::unique_ptr<ReducedOperator> lu_;
  std::vector<Eigen::Triplet<double>> stiffness_, by_state_, by_multiplier_, offsets_;
  SparseMatrix a_, x_, force_;
};

} // namespace hvi::solver
