// Errors of the steps together, by the matrix of one step of the whole time; see
// rounding_estimate.cpp.
#pragma once

#include "solver/formulation/step_matrix.hpp"

#include <span>

namespace hvi::solver {

/// gamma_b of K_w = sum_b gamma_b T_b: one step of this length, int q_m over it by memory.
Vector whole_coefficients(const Operators& operators, double length,
                          std::span<const double> memory);

/// How many vectors the solution with K_w may take, so that its triangular solves are few beside
/// those of the run, or little work at all. 0: none.
int vectors_for_whole_time(int unknowns, int contact_rows, int steps);

/// Turns solutions with K + H into those with K_w + H, by minimal residuals: with R = (K + H)^-1
/// and D = K - K_w,
///
///   (K_w + H) e = f   is   (1 - R D) e = R f,   e in the span of R f, R D R f, (R D)^2 R f, ..
///
/// The method of generalised conjugate residuals, whose directions serve all right-hand sides:
/// S. C. Eisenstat, H. C. Elman, M. H. Schultz, Variational iterative methods for nonsymmetric
/// systems of linear equations, SIAM J. Numer. Anal. 20 (1983) 345-357.
class WholeTime {
public:
  /// `change`: the coefficients of D. Keeps references to the first three.
  WholeTime(const Operators& operators, StepMatrix& matrix, const InequalityState& at, int n_state,
            Vector change)
      : operators_(operators), matrix_(matrix), at_(at), change_(std::move(change)),
        state_(Vector::Zero(n_state)) {}
  /// x = R f becomes e, with the multipliers' change xi; false: no e was found, both are as they
  /// were. `bound`: of |e| / |R f|, so that a residual may hide that much of e. `most`: directions,
  /// of all calls together. With laws of no points xi stays as it is.
  bool relax(const Vector& force, int most, double bound, Vector& x, Vector& xi);

private:
  struct Direction {
    Vector vector, image; ///< v, (1 - R D) v; the images are orthonormal
  };
  bool respond(const Vector& v, const Vector& more);
  bool add_direction(const Vector& v);

  const Operators& operators_;
  StepMatrix& matrix_;
  const InequalityState& at_;
  Vector change_, state_;
  std::vector<Vector> answer_, multipliers_;
  std::vector<Direction> directions_;
};

} // namespace hvi::solver
