// The linear solves of Newton's steps on coupled laws. The matrix S + G^T W D G has the derivative
// by the bounds, too, so that it is not symmetric.
#pragma once

#include "solver/inequality/coupled_bounds.hpp"
#include "solver/inequality/stiffness.hpp"

#include <memory>

namespace hvi::solver {

/// Displacements and multipliers: of a step, or their derivatives.
struct CoupledStep {
  Vector c, xi;
};

class CoupledTangent {
public:
  CoupledTangent(Position& at, const CoupledBounds& bounds, const StiffnessPattern& pattern,
                 const ReducedOperator& s);
  /// The change of c, and the multipliers after the full step; false: no regular matrix.
  bool step(CoupledStep& out, InequalityReport& report);
  /// What (c, xi) of a linear step change with the share. Needs the last factor.
  bool by_share(CoupledStep& out) const;
  int determinant_sign() const { return lu_->determinant_sign(); } ///< of the last factor

private:
  void assemble();
  void add_slip(const CoupledBound& b, double size, Vector& xi) const;
  void add_linear_change(const Vector& dc, Vector& xi) const;

  Position& at_;
  const CoupledBounds& bounds_;
  const StiffnessPattern& pattern_;
  std::unique_ptr<ReducedOperator> lu_;
  SparseMatrix plain_, by_bounds_; ///< their sum is H
  std::vector<Eigen::Triplet<double>> entries_;
};

} // namespace hvi::solver
