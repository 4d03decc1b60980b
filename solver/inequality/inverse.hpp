// What Newton's method keeps for laws of straight pieces: (S + H)^-1 itself (inverse.cpp).
#pragma once

#include "solver/common/stream.hpp"
#include "solver/inequality/position.hpp"
#include "solver/inequality/updated_inverse.hpp"

namespace hvi::solver {

class KeptInverse {
public:
  KeptInverse(const ContactPoints& points, const StiffnessPattern& pattern,
              const ReducedOperator& s, const InequalityOptions& options);
  /// The solution from a guess. False: the general method has to find it; `io` and `report` are as
  /// they were.
  bool solve(Position& at, InequalityState& io, InequalityReport& report);

  void save(StateWriter& out) const;
  void restore(StateReader& in);

private:
  bool may_serve(const InequalityState& from);
  bool iterate(Position& at, InequalityReport& report);

  static constexpr int largest = 600; ///< unknowns: while it stays in the second cache

  const ContactPoints& points_;
  const bool possible_; ///< laws, operator and options are such that it may serve
  UpdatedInverse inverse_;
  int waited_ = 0;           ///< solves that could have used it before it was made
  int rest_ = 0, pause_ = 4; ///< solves it is left alone after it failed, and after the next time
  Vector residual_, dc_, dz_, stiffness_dz_, h_dc_; ///< room for `iterate`
};

} // namespace hvi::solver
