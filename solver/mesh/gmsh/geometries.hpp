// The geometries of `gmsh` meshes, built with gmsh's OpenCASCADE kernel. Part of libhvi_gmsh.so.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hvi::gmsh_module {

/// The bounding box of a piece of the boundary, for deciding to which side it belongs.
struct Extent {
  std::array<double, 3> low, high;
};

/// What a builder leaves behind beside the entities in gmsh's model.
struct Blueprint {
  int dim = 2;
  /// Sides in the order in which they are tried: a piece belongs to the first whose test it passes.
  std::vector<std::pair<std::string, std::function<bool(const Extent&)>>> sides{};
  std::vector<std::pair<std::string, std::array<double, 3>>> points{};
  /// Mesh size: `fine` where `distance` is 0, growing linearly to `size` at distance `reach`.
  double size = 0, fine = 0, reach = 1;
  std::function<double(double, double, double)> distance{};
};

/// Builds a geometry in the current model; numbers as listed by hvi::solver::geometries(). All
/// lengths are of order one. Throws std::invalid_argument for an unknown name.
Blueprint build(const std::string& geometry, std::span<const double> numbers);

} // namespace hvi::gmsh_module
