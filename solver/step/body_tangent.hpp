// Newton's method on a step whose forms or loads read states: the states are eliminated point by
// point.
//
// With U(z) the solution for given states, Z(a) what the states' equations make of their inputs a =
// R U, a step asks for z = Z(R U(z)). Forces of the forms and loads change by Q dz, the solution by
// dU = - (K + G^T W D G)^-1 Q dz, where points keep their places on their graphs, and so
//
//   (1 + S R (K + G^T W D G)^-1 Q) dz = Z - z,
//
// S the slopes of the local solutions. Where loads read the solution, states at the points of laws
// may stand beside them: these follow from one pass to the next, as if they changed no force.
// Solved by minimal residuals (generalised conjugate residuals, as in whole_time.hpp): a direction
// is a forward and backward solve with the factor at hand.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/fem/pointwise.hpp"
#include "solver/formulation/step_matrix.hpp"
#include "solver/step/point_states.hpp"

namespace hvi::solver {

class Formulation;

/// A solution of step n for given states, and what the states' equations make of it.
struct BodyPass {
  int n = 0;
  const Vector& u; ///< the state, with the increment
  const Vector& d;
  const InequalityState& laws;
  const Vector& inputs;   ///< a
  const Vector& solution; ///< Z
  double share = 1.0;     ///< of the step (PointStates::solve)
};

class BodyTangent {
public:
  /// Keeps references to all of them.
  BodyTangent(const Problem& problem, const Discretisation& d, const Formulation& formulation,
              const Evolution& evolution, const PointStates& states);
  /// The change da of the inputs. False: laws have states, too, and no load reads the solution, or
  /// nothing was found.
  bool step(const BodyPass& pass, const StepMatrix& matrix, Vector& change);
  /// The same from inputs b of which the states at hand are made, z = Z(b), not from those of their
  /// solution: what is sought is b = R U(Z(b)), so that
  ///   (1 + R (K + G^T W D G)^-1 Q S) db = a - b,    S at b.
  bool step_from(const Vector& b, const BodyPass& pass, const StepMatrix& matrix, Vector& change);

private:
  /// How one entry of a form changes with one state: dC/dz D_trial(y) at the points, on the rows
  /// D_test(v). Of a load: -dF/dz.
  struct Part {
    int base = -1, first = 0; ///< of the operators (a load: none); of the state's values
    Origin origin;
    const PointBlock* points = nullptr;
    SparseMatrix test, trial; ///< points x state
    Pointwise coefficient;
  };
  struct Direction {
    Vector vector, image, inputs; ///< dz, its image, da; the images are orthonormal
  };
  struct Place {
    const StateGroup* group;
    const PointBlock* points;
  };
  Place place_of(int part) const;
  SparseMatrix rows(const PointBlock& points, int index, Origin origin) const;
  void add_form(int base, const FormTerm& form);
  void add_load(const LoadTerm& load);
  int first_of(int state) const;
  Vector trial_of(const BodyPass& pass, const Part& part) const;
  Vector in_equation(const BodyPass& pass, int base) const;
  void find_q(const BodyPass& pass);
  void find_r(const BodyPass& pass);
  bool prepare(const BodyPass& pass, const StepMatrix& matrix);
  bool reduce(Vector left, int most, const BodyPass& pass, const StepMatrix& matrix,
              Vector& change);
  bool add_direction(const Vector& v, const StepMatrix& matrix, const InequalityState& at);

  const Discretisation& d_;
  const Formulation& formulation_;
  const Evolution& evolution_;
  const PointStates& states_;
  std::vector<std::unique_ptr<PointBlock>> blocks_; ///< by group of states; null: not in a body
  std::vector<Part> parts_;
  std::vector<Direction> directions_;
  SparseMatrix q_, r_, s_;
};

} // namespace hvi::solver
