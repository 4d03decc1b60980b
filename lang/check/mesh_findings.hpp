// What is said of a mesh that was read from a file: cells that were straightened, seams, overlaps
// and pieces. Meshes made here are right by construction and are not looked at.
#pragma once

#include "solver/mesh/inspect.hpp"
#include "solver/mesh/straightening.hpp"

#include <string>
#include <vector>

namespace hvi::lang {

struct MeshFinding {
  const char* code;
  std::string message, help;
};

/// W0602, if there is a curved edge.
std::vector<MeshFinding> straightened_cells(const solver::Mesh& mesh,
                                            const solver::Straightening& lost);
/// W0603 for seams, W0604 for overlaps.
std::vector<MeshFinding> misfits(const solver::Mesh& mesh);
/// "12 cells of area 0.5 around (0.1, 0.2)".
std::string describe_piece(const solver::Piece& piece, int dim);
/// W0605 for several pieces; `held`: what holds each, or empty.
MeshFinding pieces(const std::vector<solver::Piece>& all, const std::vector<std::string>& held,
                   int dim);

} // namespace hvi::lang
