// Linear solves of Newton's steps by iterations, each to the accuracy that pays (forcing terms: R.
// S. Dembo, S. C. Eisenstat, T. Steihaug, Inexact Newton methods, SIAM J. Numer. Anal. 19 (1982)
// 400-408).
#pragma once

#include "solver/inequality/conjugate_gradients.hpp"

namespace hvi::solver {

class KrylovTangent final : public TangentSolver {
public:
  KrylovTangent(const StiffnessPattern& pattern, LastFactor& factor)
      : pattern_(pattern), factor_(factor), h_(pattern.zero()) {}
  bool solve(const Position& at, const Vector& residual, bool settled, InequalityReport& report,
             TangentStep& out) override;

private:
  double reduction_while_changing(const Position& at, const Vector& residual) const;
  static double left_by_curves(const Vector& residual, const TangentStep& last);
  double reduction(const Position& at, const Vector& residual, bool settled,
                   const TangentStep& last) const;
  Vector rows_unseen(const Position& at, const Vector& residual, double accuracy) const;

  const StiffnessPattern& pattern_;
  LastFactor& factor_;
  SparseMatrix h_;
};

} // namespace hvi::solver
