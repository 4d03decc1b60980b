// The equations of the equilibrium curve between two loads: its tangent, and Newton's method back
// onto it.
#pragma once

#include "solver/inequality/curve_state.hpp"

#include <optional>

namespace hvi::solver {

/// A direction of the curve. Its length is one where unknowns are measured by the size of the
/// problem: |way|^2 / (n size^2) + load^2 = 1.
struct CurveTangent {
  Vector way; ///< change of each point's unknown
  double load = 1.0;

  void reverse() { way = -way, load = -load; }
};

class CurveEquations {
public:
  /// b(l) runs from b0 to b1. `size`: of the arguments and loads, the largest.
  CurveEquations(const CurveProblem& problem, Vector b0, const Vector& b1, double size);

  const CurveProblem& problem() const { return problem_; }
  double size() const { return size_; }
  double cosine(const CurveTangent& a, const CurveTangent& b) const;

  /// Its sign is any; nothing where there is none.
  std::optional<CurveTangent> tangent(const CurveState& at) const;
  /// The one that does not turn back from `before`.
  std::optional<CurveTangent> tangent(const CurveState& at, const CurveTangent& before) const;
  /// To the curve at right angles to the tangent, by Newton's method. False: it does not get there.
  bool correct(CurveState& at, const CurveTangent& tangent) const;

private:
  void fill_jacobian(const CurveState& at, Eigen::Ref<DenseMatrix> jacobian) const;
  Vector correction(const CurveState& at, const CurveTangent& tangent, const Vector& error) const;

  const CurveProblem& problem_;
  Vector b0_, db_;
  double size_;
};

} // namespace hvi::solver
