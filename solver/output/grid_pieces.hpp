// An unstructured grid in pieces, each a file of its own, and the file that names them (PVTU).
#pragma once

#include "solver/common/stream.hpp"
#include "solver/output/vtu.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// Which points and cells of a grid are in which piece. A point of several cells is in each of
/// their pieces.
class GridPieces {
public:
  /// `part_of_cell`: from 0 to count - 1.
  GridPieces(const VtuGrid& grid, std::span<const std::int32_t> part_of_cell, int count);
  int count() const { return static_cast<int>(pieces_.size()); }
  /// The piece of a grid with these points and cells.
  VtuGrid piece(const VtuGrid& grid, int p) const;

private:
  struct Piece {
    std::vector<std::int64_t> points, cells;
    std::vector<std::int64_t> connectivity; ///< by the piece's points
  };
  std::vector<Piece> pieces_;
};

/// The XML PUnstructuredGrid of pieces with the arrays of this one in these files.
std::string pvtu_bytes(const VtuGrid& piece, const VtuUnits& units,
                       std::span<const std::string> files);

/// A grid as bytes, for another process.
void put_grid(StateWriter& w, const VtuGrid& grid);
VtuGrid get_grid(StateReader& r);

} // namespace hvi::solver
