// Whether the cells of a mesh that somebody else made fit together: seams that were not merged,
// cells that overlap, a body in several pieces. Each is linear in the cells, with a small factor:
// all but the pieces look at the boundary and at what comes near it.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

/// Nodes of the boundary at one place (to 1e-8 of the body's size, gmsh's own Geometry.Tolerance,
/// and to a thousandth of the cells there) that no cell joins, and nodes that lie inside a side
/// without being a corner of it: there the body is open, whether that was meant (a crack) or not.
struct Seam {
  std::size_t doubled = 0;         ///< nodes that merging would remove
  std::size_t hanging = 0;         ///< nodes inside a side
  Point at{};                      ///< one of them
  std::vector<std::string> groups; ///< that have entities with such nodes, sorted
};
std::optional<Seam> find_seam(const Mesh& mesh);

/// Cells that share more than their common corners, edges and facets.
struct Overlap {
  std::size_t cells = 0; ///< of the boundary, that reach into others
  double depth = 0.0;    ///< how far the deepest would have to be moved to come free
  Point at{};            ///< centre of that one
  int cell = -1, other = -1;
};
/// Two bodies that overlap, and a body that overlaps itself, do so with a cell of the boundary of
/// one of them, so that only those are looked at. Not seen: overlaps of less than 1e-6 of a cell's
/// longest edge or 1e-9 of the body, and cells flatter than that.
std::optional<Overlap> find_overlap(const Mesh& mesh);

/// A part of the body whose cells are connected by facets.
struct Piece {
  std::size_t cells = 0;
  double measure = 0.0;
  Point at{}; ///< centre of its first cell
};
/// By first cell, so that pieces_of gives the index.
std::vector<Piece> measure_pieces(const Mesh& mesh, const std::vector<std::int32_t>& piece_of);

} // namespace hvi::solver
