// How close to a break an argument counts as on it.
#pragma once

#include "solver/inequality/force_balance.hpp"

namespace hvi::solver {

/// Rounding of G c + g before anything cancels in it (which depends on the axes), and of the
/// displacements that the forces at the point amount to, times a factor.
class Snap {
public:
  /// Arguments within this part of their size count as on a break; Newton aims closer at first.
  static constexpr double tight = 2e-14, certificate = 1e-12;

  explicit Snap(const ContactPoints& points);
  /// From the displacements and the S c of `balance`.
  void update(const Vector& c, const ForceBalance& balance, double factor);
  double operator()(int p) const;

  double factor = certificate; ///< as it was updated with

private:
  const ContactPoints& points_;
  Vector reach_; ///< by unknown: a displacement, the scale of its rounding
};

} // namespace hvi::solver
