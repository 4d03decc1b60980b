// The point of a convex set that is nearest to a given one, the set being known by its support.
#pragma once

#include "solver/linear/sparse.hpp"

#include <functional>

namespace hvi::solver {

/// Where a set reaches farthest along y: a point of it, or a ray (of length one) along which it has
/// no end and that goes along y.
struct Support {
  Vector q;
  bool ray = false;
};

struct NearestPoint {
  Vector apart;         ///< b less the nearest point
  bool outside = false; ///< by proof: the set reaches less far along `apart` than b
};

/// Wolfe's algorithm (P. Wolfe, Finding the nearest point in a polytope, Math. Programming 11
/// (1976) 128-149) with rays beside points, for few dimensions. `start`: any point of the set.
NearestPoint nearest_point(const Vector& b, Vector start,
                           const std::function<Support(const Vector& y)>& support);

} // namespace hvi::solver
