// The numbers of hypothesis H(J) for one law, with what is known about each.
#pragma once

#include "solver/common/bracket.hpp"
#include "solver/law/law.hpp"

namespace hvi::solver {

/// As LawConstants, by proof where one is found: closed forms for polynomials, else branch and
/// bound over every argument (supremum.hpp).
struct KnownConstants {
  /// Steepest descent of the slope, m_J of H(J)(iii); infinite where it jumps down, or falls
  /// infinitely steeply.
  Bracket m;
  bool jumps_down = false;
  Bracket c;                  ///< growth: |xi| <= c (1 + |r|), c_J of H(J)(ii); inf if superlinear
  Bracket steepest_ascent;    ///< sup of the slope's derivative; inf at an upward jump
  double slope_scale = 0.0;   ///< a typical |xi|
  bool clarke_regular = true; ///< j or -j regular (finite m: always, since j + m r^2/2 is convex)
  double worst_at = 0.0;      ///< an argument where m is (nearly) attained
};

/// How much work a proof may take: enclosures of each function, and the relative width of its
/// bracket at which it is enough.
struct ProofEffort {
  int evaluations = 20000;
  double digits = 1e-10;
  int of_growth = 20000; ///< enclosures for c and the ascent
};

/// At one point of space and time.
KnownConstants known_constants(const Law& law, const Point& x, LawTime t, ProofEffort effort = {});

/// A part of space as simplices of 1 to 4 corners, and the times.
struct LawDomain {
  struct Simplex {
    std::array<Point, 4> corners{};
    int n = 1;
  };
  std::vector<Simplex> part;
  double t_low = 0.0, t_high = 0.0;
};

/// The worst over a domain, for a law that depends on place or time and is not coupled. m and c by
/// branch and bound over argument, place and time at once. That the slope nowhere jumps down is
/// proved from the two sides of each comparison, along the argument where it turns; where that
/// fails m is what was seen.
KnownConstants known_constants(const Law& law, const LawDomain& domain,
                               ProofEffort effort = {20000, 1e-8});

/// Only m of it and whether the slope jumps down, with what a run may spend.
KnownConstants steepest_descent(const Law& law, const LawDomain& domain);

} // namespace hvi::solver
