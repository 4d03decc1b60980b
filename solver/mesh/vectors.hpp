// Vectors between points of a mesh. Internal to solver/mesh.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <cmath>

namespace hvi::solver {

inline Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double norm(const Point& a) { return std::hypot(a[0], a[1], a[2]); }

} // namespace hvi::solver
