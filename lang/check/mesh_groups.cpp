#include "lang/check/mesh_groups.hpp"

#include <fmt/format.h>

namespace hvi::lang {

using solver::Group;
using solver::RegionSpec;

std::string MeshGroups::of_piece(const std::string& piece, const std::string& group) {
  return fmt::format("{}.{}", piece, group);
}

std::string MeshGroups::of_file(const std::string& piece, const std::string& group) {
  return of_piece(piece, group == "boundary" ? "group(\"boundary\")" : group);
}

std::vector<std::string> MeshGroups::of(const MeshValue& mesh) const {
  std::vector<std::string> out;
  const std::string prefix =
      mesh.index > 0 ? pieces[static_cast<std::size_t>(mesh.index) - 1] + "." : "";
  for (const auto& [group, kind] : kinds)
    if (group.starts_with(prefix)) out.push_back(group.substr(prefix.size()));
  return out;
}

std::optional<Group::Kind> MeshGroups::kind_of(const RegionSpec& r) const {
  switch (r.kind) {
  case RegionSpec::Kind::pair:
    return Group::Kind::facets;
  case RegionSpec::Kind::all_cells:
    return Group::Kind::cells;
  case RegionSpec::Kind::boundary:
    return Group::Kind::facets;
  case RegionSpec::Kind::point:
    return Group::Kind::points;
  case RegionSpec::Kind::group: {
    auto found = kinds.find(r.name);
    return found == kinds.end() ? std::nullopt : std::optional(found->second);
  }
  case RegionSpec::Kind::unite:
  case RegionSpec::Kind::subtract:
  case RegionSpec::Kind::where:
    return kind_of(r.children[0]);
  }
  return std::nullopt;
}

} // namespace hvi::lang
