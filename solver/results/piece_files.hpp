// The fields of a body in pieces, each written by another process (linear/processes.hpp).
#pragma once

#include "solver/fem/space.hpp"
#include "solver/output/file.hpp"
#include "solver/output/grid_pieces.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::solver {

/// NAME_0.vtu, NAME_1.vtu, ...: the process that writes it.
std::string name_of_piece(const std::string& name, std::size_t process);

/// The Task of every process: writes the piece that the message holds. Answers with its hash, or
/// with why it was not written.
std::string write_piece(std::string_view message);

class PieceFiles {
public:
  /// Keeps a reference to the space. The mesh is cut when the first grid is written.
  PieceFiles(const Space& space, int processes) : space_(space), processes_(processes) {}

  /// Writes name_of_piece(name, p) in the folder for every process p: the grid of the body.
  /// Returns the hashes of the files. Throws Failure(output) where one cannot be written.
  std::vector<std::uint64_t> write(const VtuGrid& grid, const VtuUnits& units,
                                   const std::filesystem::path& folder, const std::string& name,
                                   Durability durability);

private:
  const Space& space_;
  int processes_;
  std::optional<GridPieces> pieces_;
};

} // namespace hvi::solver
