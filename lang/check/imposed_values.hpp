// Values that a find statement imposes where the space is zero.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/mesh_groups.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/parts.hpp"

#include <array>
#include <optional>
#include <set>

namespace hvi::lang {

class ImposedValues {
public:
  ImposedValues(const Context& context, const MeshGroups& groups, Parts& parts, Pairs& pairs)
      : mistakes_(context.mistakes), find_(context.find), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator), groups_(groups), parts_(parts),
        pairs_(pairs) {}

  void read(const ast::Find& find);

private:
  bool contains(const solver::RegionSpec& larger, const solver::RegionSpec& part) const;
  solver::DirichletSpec* imposed_entry(int unknown, int part, int component);
  std::optional<int> imposed_component(const ast::ImposedValue& imposed, int unknown);
  bool has_shape_of(const ast::ImposedValue& imposed, const Field& value, int unknown,
                    int component);
  solver::DirichletSpec* place_of_imposed(const ast::ImposedValue& imposed, int unknown, int part,
                                          int component, std::set<std::array<int, 3>>& before);
  void imposed_value(const ast::ImposedValue& imposed, std::set<std::array<int, 3>>& before);

  Mistakes& mistakes_;
  const ast::Find* const find_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  const MeshGroups& groups_;
  Parts& parts_;
  Pairs& pairs_;
};

} // namespace hvi::lang
