// Two sides that touch, with meshes that need not match: the points where laws act on the jump of
// u across them, by a mortar projection.
//
// The first side carries points i, its nodes, with functions q_i >= 0 that sum to 1 on every facet:
// the nodal shape functions where these are positive on average, else the hats of the corners. With
// Pi the projection onto the second side, G the part of the first side that has a partner, and
// psi_i spanned by the q_k of a facet, int_G psi_i q_k = delta_ik int_G q_i (biorthogonal):
//
//   w_i = int_G q_i,   [u]_i = (1/w_i) int_G psi_i (u - u o Pi),   gap_i = nu_i . (1/w_i) int_G
//   psi_i (Pi x - x),   {u}_i = (1/w_i) int_G psi_i (u + u o Pi)/2
//
// so that sum_i w_i [u]_i . xi = int_G [u] . xi for every constant xi. The integrals are taken on
// the intersections of the facets of both sides, where everything is a polynomial. Sources:
// B. I. Wohlmuth, A mortar finite element method using dual spaces for the Lagrange multiplier,
// SIAM J. Numer. Anal. 38 (2000); Variationally consistent discretization schemes and numerical
// algorithms for contact problems, Acta Numerica 20 (2011).
#pragma once

#include "solver/fem/pointwise.hpp"

namespace hvi::solver {

struct Pairing {
  std::vector<Point> x, normal;                ///< normal: out of the first side, averaged
  std::vector<double> weight, gap;             ///< gap: along `normal`; negative where they overlap
  std::vector<std::int32_t> node, facet, cell; ///< of the first side
  /// Twice as many rows as points, x nodes of the space: u -> [u]_i, then u -> {u}_i.
  SparseMatrix jump;
  int alone = 0;       ///< nodes of the first side without a partner
  Point first_alone{}; ///< one of them
};

/// `region`: of a pair. `order`: of the unknown whose laws act there; of a lower one than the
/// space's the points are the corners and the q_i their hats. Throws Failure(bad_value) where no
/// point of the first side has a partner, where the second side lies over the first one twice, and
/// where the sides share facets.
Pairing make_pairing(const Space& space, const Region& region, int order);

/// Its points, for expressions of place, normal, time, gap and parts.
PointBlock as_block(const Space& space, const Pairing& pairing);

/// `jump` for an unknown of lower order than the space's, without functions at the middles of
/// edges: its value there is the mean of the ends. Entries that are rounding are left out.
SparseMatrix straightened(const Space& space, const SparseMatrix& jump);

} // namespace hvi::solver
