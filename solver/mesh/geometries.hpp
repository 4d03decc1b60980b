// Checks of the numbers of a geometry; internal to solver/mesh (the list itself: gmsh_module.hpp).
#pragma once

#include "solver/mesh/gmsh_module.hpp"

namespace hvi::solver {

/// Throws Failure(bad_value) naming the geometries there are.
const GeometryInfo& geometry_info(const std::string& name);

/// All numbers of a geometry: none given means the defaults, and a fine size not given is the mesh
/// size. Throws Failure(bad_value) for numbers that make no body, Failure(limit) for too many
/// cells.
std::vector<double> complete_numbers(const GeometryInfo& info, std::vector<double> numbers);

} // namespace hvi::solver
