// The VTU and PVD files of one `fields` item.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/output/file.hpp"
#include "solver/output/vtu.hpp"
#include "solver/results/field_grids.hpp"

#include <filesystem>

namespace hvi::solver {

/// One VTU per written step for the body, and one for every multiplier (FieldGrids).
class FieldFiles {
public:
  /// `stem`: file name without extension inside `folder`.
  FieldFiles(const Problem& problem, const Discretisation& discretisation, const Contact& contact,
             const FieldsSpec& spec, VtuUnits units, std::filesystem::path folder, std::string stem,
             Durability durability);

  std::vector<Expr> expressions() const { return grids_.expressions(); }
  /// Writes the files of a step and the collection so far; file names are added to `written`.
  void write(const Snapshot& snapshot, std::vector<std::string>& written);
  /// The collection again, where a run was resumed: it may have been lost since.
  void write_collection() const;

  void save(std::ostream& out) const;
  /// Throws Failure(broken_file) when a file written before is gone, empty or changed.
  void restore(std::istream& in);

private:
  void write_vtu(const VtuGrid& grid, int part, const std::string& name, double t,
                 std::vector<std::string>& written);

  FieldGrids grids_;
  VtuUnits units_;
  std::filesystem::path folder_;
  std::string stem_;
  std::vector<PvdEntry> entries_;
  std::vector<std::uint64_t> hashes_; ///< of the entries' files
  Durability durability_;
  bool resumed_ = false;
};

} // namespace hvi::solver
