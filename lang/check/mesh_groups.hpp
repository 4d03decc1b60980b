// The groups of the mesh in use, as far as they are known before it is made.
#pragma once

#include "lang/check/value.hpp"
#include "solver/mesh/mesh.hpp"
#include "solver/plan/problem.hpp"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace hvi::lang {

struct MeshGroups {
  std::string mesh_name;                            ///< of the mesh that was declared; empty before
  std::map<std::string, solver::Group::Kind> kinds; ///< by the names of the groups
  bool known = false;                               ///< are these all?
  std::set<std::string> cuts;      ///< groups along which the mesh is cut: each is a pair
  std::vector<std::string> pieces; ///< their names; MeshValue i > 0 is pieces[i - 1]

  bool has(const std::string& group) const { return kinds.contains(group) || cuts.contains(group); }
  /// Of the whole mesh, or of a piece, by the names that they have there.
  std::vector<std::string> of(const MeshValue& mesh) const;
  /// Nothing where the mesh would have to tell.
  std::optional<solver::Group::Kind> kind_of(const solver::RegionSpec& region) const;
  /// The group of the whole mesh that a piece's group is.
  static std::string of_piece(const std::string& piece, const std::string& group);
  /// A piece's group by its name in the file, which may be `boundary`: `a.boundary` is all of it.
  static std::string of_file(const std::string& piece, const std::string& group);
};

} // namespace hvi::lang
