// How far a point that no cell holds is from the body.
#pragma once

#include "solver/mesh/mesh.hpp"

namespace hvi::solver {

struct NearestOnBoundary {
  Point at{};
  double distance = 0.0;
};

/// The point of the boundary's facets that is nearest to p; goes through all of them.
NearestOnBoundary nearest_on_boundary(const Mesh& mesh, const Point& p);

} // namespace hvi::solver
