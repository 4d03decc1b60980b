// VTU and PVD: what ParaView, PyVista and meshio read. Plain grids in, bytes out.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::solver {

/// VTK's numbers for the cells we have.
enum class VtkCell : std::uint8_t {
  vertex = 1,
  line = 3,
  triangle = 5,
  tetra = 10,
  quadratic_edge = 21,
  quadratic_triangle = 22,
  quadratic_tetra = 24
};
int nodes_of(VtkCell cell);

/// A named array of n x components values, component fastest.
/// VTK's convention: 3 components are a vector, 9 a tensor (row by row).
struct VtuArray {
  std::string name;
  int components = 1;
  std::vector<double> values;
  std::string unit{}; ///< VTK calls it UNITS_LABEL; "": none is written
};

/// An unstructured grid with cells of one type; `connectivity` holds nodes_of(cell) per cell.
struct VtuGrid {
  std::vector<Point> points;
  VtkCell cell = VtkCell::triangle;
  std::vector<std::int64_t> connectivity;
  std::vector<VtuArray> point_data, cell_data;
  double time = 0.0; ///< as field data TimeValue
};

/// Of the time and the coordinates of grids, as far as they are known.
struct VtuUnits {
  std::string time, length;
};

/// The grid as an XML UnstructuredGrid: inline base64, zlib in blocks, UInt64 headers.
/// Throws Failure(output) when an array does not have one entry per point or cell.
std::string vtu_bytes(const VtuGrid& grid, const VtuUnits& units = {});

/// An array as the file of a grid in pieces names it: its type, name, shape and unit.
std::string array_without_values(const VtuArray& array);

/// One file of a collection.
struct PvdEntry {
  double time = 0.0;
  int part = 0;     ///< 0: the body; contact parts after it
  std::string file; ///< relative to the PVD
};
std::string pvd_bytes(const std::vector<PvdEntry>& entries);

/// Values padded with zeros to what VTK wants: 2 -> 3 components, 4 -> 9 (a 2 x 2 tensor), 1 as is.
VtuArray vtk_array(std::string name, int components, const std::vector<double>& values);

/// Text for XML attributes and content.
std::string xml_escaped(std::string_view text);

} // namespace hvi::solver
