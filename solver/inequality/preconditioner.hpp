// The last factor, corrected where few points moved far from it: a preconditioner for S + H.
//
// The last factor M = S + H_old preconditions S + H. Most points keep their stiffness about; those
// that moved far (stick to slip and back, contact that opens) are few and have their unknowns to
// themselves. With X their unknowns, the preconditioner is the matrix P that equals S + H on X and
// M elsewhere, solved exactly:
//
//   R: unknowns that M holds by a penalty and that are free now. M^-1 gives 0 there, so that with
//      Y = M^-1 S E_R and C = (S + H)_RR - S_RF Y   (F: all but R)
//          x_R = C^-1 (b_R - Y^T b),   x_F = M^-1 b - Y x_R.
//   Q: the others, by Woodbury with Delta = (H - H_old)_QQ and Z = M^-1 E_Q:
//          force = (1 + Delta G)^-1 Delta x_Q,   G = Z_QQ + Y_Q C^-1 Y_Q^T,   b := b - E_Q force.
//
// The columns Y and Z are kept as long as the factor.
#pragma once

#include "solver/inequality/far_unknowns.hpp"

namespace hvi::solver {

class Preconditioner {
public:
  Preconditioner(const ContactPoints& points, LastFactor& factor);
  /// Forgets what belongs to another factor than the last.
  void keep_up();
  /// For S + h. False: P has no factor.
  bool prepare(const FarPoints& far, const SparseMatrix& h);
  void apply(const Vector& r, Vector& out); ///< out = P^-1 r

  const FarColumns& columns() const; ///< known of the last factor
  int served() const;                ///< times that it was applied
  /// As a saved solver had them, for the factor that there is now.
  void restore(FarColumns columns, int served);

private:
  const ContactPoints& points_;
  LastFactor& factor_;
  int number_ = 0, served_ = 0; ///< of the factor: which one, and how often it was applied
  FarColumns columns_;
  FarPoints far_;
  FreedUnknowns freed_;
  ChangedUnknowns changed_;
  Vector kept_; ///< room for `apply`
};

} // namespace hvi::solver
