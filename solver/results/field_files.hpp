// The VTU, PVTU and PVD files of one `fields` item.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/output/file.hpp"
#include "solver/output/vtu.hpp"
#include "solver/results/field_grids.hpp"
#include "solver/results/piece_files.hpp"

#include <filesystem>
#include <optional>

namespace hvi::solver {

/// One VTU per written step for the body, and one for every multiplier (FieldGrids). Where several
/// processes share the work the body has a PVTU, and a VTU of each process.
class FieldFiles {
public:
  /// `stem`: file name without extension inside `folder`; `processes`: so many write a piece
  /// of the body each.
  FieldFiles(const Problem& problem, const Discretisation& discretisation, const Contact& contact,
             const FieldsSpec& spec, VtuUnits units, std::filesystem::path folder, std::string stem,
             Durability durability, int processes);

  std::vector<Expr> expressions() const { return grids_.expressions(); }
  /// Writes the files of a step and the collection so far; file names are added to `written`.
  void write(const Snapshot& snapshot, std::vector<std::string>& written);
  /// The collection again, where a run was resumed: it may have been lost since.
  void write_collection() const;

  void save(std::ostream& out) const;
  /// Throws Failure(broken_file) when a file written before is gone, empty or changed.
  void restore(std::istream& in);

private:
  /// A file of this run. `part`: in the collection (PvdEntry); -1: not there.
  struct Written {
    PvdEntry entry;
    std::uint64_t hash;
  };
  void note(const std::string& name, std::uint64_t hash, int part, double t,
            std::vector<std::string>& written);
  void write_vtu(const VtuGrid& grid, int part, const std::string& name, double t,
                 std::vector<std::string>& written);
  void write_pieces(const VtuGrid& grid, const std::string& name, double t,
                    std::vector<std::string>& written);
  std::string collection() const;

  FieldGrids grids_;
  VtuUnits units_;
  std::filesystem::path folder_;
  std::string stem_;
  std::vector<Written> files_;
  std::optional<PieceFiles> pieces_;
  Durability durability_;
  bool resumed_ = false;
  bool collected_ = false; ///< has the collection been written, and told?
};

} // namespace hvi::solver
