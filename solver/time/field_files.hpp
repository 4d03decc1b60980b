// The VTU and PVD files of one `fields` item.
#pragma once

#include "solver/output/file.hpp"
#include "solver/output/vtu.hpp"
#include "solver/time/law_sampler.hpp"

#include <filesystem>

namespace hvi::solver {

/// Body fields go to one VTU per written step: point data for expressions of values, cell averages
/// for expressions with gradients. A multiplier goes to a VTU of its own on the contact part: on
/// its facets with point data when the law's rule is nodal, else on the quadrature points.
class FieldFiles {
public:
  /// `stem`: file name without extension inside `folder`.
  FieldFiles(const Problem& problem, const Discretisation& discretisation, const Contact& contact,
             const FieldsSpec& spec, std::filesystem::path folder, std::string stem,
             Durability durability);

  std::vector<Expr> expressions() const;
  /// Writes the files of a step and the collection so far; file names are added to `written`.
  void write(const Snapshot& snapshot, std::vector<std::string>& written);
  /// The collection again, where a run was resumed: it may have been lost since.
  void write_collection() const;

  void save(std::ostream& out) const;
  /// Throws Failure(broken_file) when a file written before is gone, empty or changed.
  void restore(std::istream& in);

private:
  struct OnContact {
    FieldSpec field;
    LawSampler sampler;
    VtuGrid grid;
    std::vector<std::int64_t> grid_point; ///< of each point of the sampler; in a body: its cell
  };
  void add_body_array(const FieldSpec& field, const Snapshot& snapshot);
  void fill_contact(OnContact& part, const Snapshot& snapshot) const;
  void write_vtu(const VtuGrid& grid, int part, const std::string& name, double t,
                 std::vector<std::string>& written);

  const Space& space_;
  const Contact& contact_;
  int n_fields_;
  std::filesystem::path folder_;
  std::string stem_;
  std::vector<FieldSpec> body_;
  std::vector<OnContact> contact_parts_;
  VtuGrid grid_;
  std::vector<PvdEntry> entries_;
  std::vector<std::uint64_t> hashes_; ///< of the entries' files
  Durability durability_;
  bool resumed_ = false;
};

/// The grid of the body: P1 or P2 cells in VTK's order of nodes.
VtuGrid body_grid(const Space& space);

} // namespace hvi::solver
