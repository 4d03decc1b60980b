// Parts of the mesh: sides, groups, points, pairs, sums, differences and conditions.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/mesh_groups.hpp"

#include <map>
#include <optional>
#include <string>

namespace hvi::lang {

class Parts {
public:
  Parts(const Context& context, MeshGroups& groups)
      : mistakes_(context.mistakes), names_(context.names), model_(context.model),
        evaluator_(context.evaluator), groups_(groups) {}

  /// Of `slab.top`, `slab.group("roof")`, a part by its name; nothing where it is wrong (reported).
  std::optional<solver::RegionSpec> region_path(const ast::Expr& path);
  /// Of `part roof = ...`.
  Value part(const ast::Part& part);
  /// The index of a part (or of a mesh, as all its cells) by its name.
  std::optional<int> index_of(const ast::Name& name);

private:
  std::optional<solver::RegionSpec> region(const ast::Region& region);
  std::optional<solver::RegionSpec> region_term(const ast::RegionTerm& term);
  std::optional<solver::RegionSpec> mesh_member(const ast::Expr& path, const MeshValue& value,
                                                const std::string& mesh, const ast::Name& name);
  std::optional<solver::RegionSpec> mesh_group(const ast::Expr& path, const ast::Call& call);
  std::optional<solver::RegionSpec> point_region(const ast::Expr& path, const ast::Call& call);
  std::optional<solver::RegionSpec> pair_region(const ast::Expr& path, const ast::Call& call);
  std::optional<solver::RegionSpec> side_of_pair(const ast::Expr& e);
  solver::RegionSpec whole(const MeshValue& mesh, const Span& span);
  std::string group_named(const MeshValue& mesh, const std::string& name, const Span& span);
  solver::RegionSpec group_region(const std::string& group, const Span& span);

  Mistakes& mistakes_;
  Names& names_;
  Model& model_;
  Evaluator& evaluator_;
  MeshGroups& groups_;
  std::map<std::string, int> part_of_;
};

} // namespace hvi::lang
