// Linear solves of Newton's steps without a new factor, where the last one is close.
//
// What the preconditioner (preconditioner.hpp) does not know are the small changes of slopes,
// E = S + H - P: a few iterations of conjugate gradients. They need no product with S, for P p is
// known of a direction p = P^-1 r + beta p_before: it is r + beta P p_before.
#pragma once

#include "solver/inequality/preconditioner.hpp"

namespace hvi::solver {

/// Computes what an inexact step dc of (S + H) dc = residual leaves of the residual; resting points
/// add it to their multipliers. A resting point that stands exactly at its break does not move at
/// all: with its entries of dc set to 0, S dc serves to update S c.
void finish_inexact(const Position& at, const ReducedOperator& s, const SparseMatrix& h,
                    const Vector& residual, TangentStep& out);

class ConjugateGradients final : public TangentSolver {
public:
  ConjugateGradients(const ContactPoints& points, const StiffnessPattern& pattern,
                     LastFactor& factor);
  /// By conjugate gradients preconditioned with the last factor when few points moved far from it
  /// (slopes that change a little, a front of slip), else by a factor of this H; a rounded one is
  /// refined.
  bool solve(const Position& at, const Vector& residual, bool settled, InequalityReport& report,
             TangentStep& out) override;

  const Preconditioner& preconditioner() const { return preconditioner_; }
  int last_iterations() const { return last_; } ///< of the last solve; it says whether they pay
  void restore(int last_iterations, FarColumns columns, int served);

private:
  bool is_close(const PointMatrices& d);
  bool iterate(const Vector& residual, bool settled, TangentStep& out);

  const ContactPoints& points_;
  const StiffnessPattern& pattern_;
  LastFactor& factor_;
  Preconditioner preconditioner_;
  SparseMatrix h_, drift_; ///< H, E
  FarPoints far_;
  PointMatrices change_;      ///< of the stiffnesses since the factor: room for `is_close`
  Vector r_, z_, p_, mp_, q_; ///< room for `iterate`
  int last_ = 0;
};

} // namespace hvi::solver
