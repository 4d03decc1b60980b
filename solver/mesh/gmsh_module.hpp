// Geometry and mesh generation through libgmsh, loaded only when a plan asks for it.
#pragma once

#include "solver/mesh/geo_constants.hpp"
#include "solver/mesh/mesh.hpp"
#include "solver/mesh/straightening.hpp"

#include <string>
#include <vector>

namespace hvi::solver {

/// The geometries we know: name, what the numbers mean, the groups made. All have the group "body".
/// The numbers end with the mesh size and, for most, a second size near the place its name says
/// ("size_hole"): from there the size grows linearly.
struct GeometryInfo {
  std::string name; ///< "disk", "annulus", "plate_with_hole", "bracket", ...
  int dim;
  std::vector<std::string> parameters; ///< names of the numbers, in order
  std::vector<double> defaults;
  std::vector<std::string> groups;
  std::vector<std::string> points = {}; ///< those of the groups that are points
};
const std::vector<GeometryInfo>& geometries();

/// Meshes a known geometry. No numbers: the defaults; the second size may be left out. Throws
/// Failure(bad_value) for impossible numbers, Failure(limit) for too many cells,
/// Failure(missing_file) when the gmsh module cannot be loaded.
Mesh generate_geometry(const std::string& name, const std::vector<double>& numbers);
/// Meshes a .geo file (it can run programs: only where the user allows it). Throws
/// Failure(bad_value) for a constant that the file does not define.
Mesh mesh_geo_file(const std::string& path, Straightening* straightened = nullptr,
                   const GeoConstants& constants = {});

} // namespace hvi::solver
