// Meshes put together: `mesh both = upper + lower`, and what their groups are called.

#include "lang/check/meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

using solver::Group;
using solver::MeshSpec;
using solver::RegionSpec;

Value Meshes::mesh_of_pieces(const ast::Mesh& m) {
  if (!groups_.mesh_name.empty()) {
    report_second(m.name.span);
    return Poison{};
  }
  groups_.mesh_name = m.name.text;
  making_pieces_ = true;
  MeshSpec spec;
  std::map<std::string, Group::Kind> groups;
  std::set<std::string> cuts;
  std::vector<const ast::Expr*> names;
  for (const ast::Expr* left = &m.value; left != nullptr;) {
    const auto* sum = std::get_if<ast::Binary>(&left->node);
    names.push_back(sum ? &*sum->right : left);
    left = sum ? &*sum->left : nullptr;
  }
  bool good = true;
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    const int dim = model_.dim;
    groups_.kinds.clear();
    if (!add_piece(**name)) {
      good = false;
      continue;
    }
    if (!spec.pieces.empty() && model_.dim != dim) {
      mistakes_.error(
          "E0307", (*name)->span,
          fmt::format("a mesh in {}D and one in {}D are not put together", dim, model_.dim));
      good = false;
    }
    if (!spec.pieces.empty() && model_.mesh.axisymmetric != spec.axisymmetric) {
      mistakes_.error("E0440", (*name)->span,
                      "an axisymmetric mesh and another one are not put together",
                      "give all of them `axisymmetric = true`, or none");
      good = false;
    }
    spec.axisymmetric = model_.mesh.axisymmetric;
    const std::string& piece = groups_.pieces.back();
    groups[piece] = Group::Kind::cells;
    groups[MeshGroups::of_piece(piece, "boundary")] = Group::Kind::facets;
    for (const auto& [group, kind] : groups_.kinds)
      groups[MeshGroups::of_file(piece, group)] = kind;
    for (const auto& group : std::exchange(groups_.cuts, {}))
      cuts.insert(MeshGroups::of_piece(piece, group));
    spec.pieces.push_back(model_.mesh);
    const int adapted = std::exchange(spec.pieces.back().adapted, 0);
    if (spec.pieces.size() > 1 && (adapted > 0) != (spec.adapted > 0)) {
      mistakes_.error(
          "E0440", (*name)->span,
          fmt::format("`{}` is {}adapted, the piece before it is {}", piece,
                      adapted > 0 ? "" : "not ", adapted > 0 ? "not" : ""),
          "give all pieces `adapted = CELLS`, or none: the cells go where the errors are");
      good = false;
    }
    spec.adapted += adapted; // of all pieces together
  }
  making_pieces_ = false;
  groups_.kinds = std::move(groups);
  groups_.cuts = std::move(cuts);
  groups_.known = good;
  if (!good) return Poison{};
  spec.kind = MeshSpec::Kind::pieces;
  spec.name = m.name.text;
  spec.origin = model_.origin(m.value.span);
  model_.mesh = std::move(spec);
  return MeshValue{0};
}

/// Makes model_.mesh, model_.dim and groups_ those of the mesh with this name.
bool Meshes::add_piece(const ast::Expr& e) {
  const std::string& name = std::get<ast::Reference>(e.node).name;
  const int index = names_.find(name);
  if (index < 0) {
    Scope none;
    names_.report_unknown(e.span, name, none);
    return false;
  }
  const auto* made = std::get_if<ast::Mesh>(names_[index].statement);
  if (made == nullptr || !std::holds_alternative<ast::Call>(made->value.node)) {
    mistakes_.error("E0306", e.span, fmt::format("`{}` is no mesh made by a call", name),
                    "a piece is one mesh: `rectangle(...)`, `box(...)`, `gmsh(...)`");
    return false;
  }
  if (std::ranges::find(groups_.pieces, name) != groups_.pieces.end()) {
    mistakes_.error("E0440", e.span, fmt::format("`{}` is put together with itself", name),
                    "two bodies of one shape are two meshes: declare it again, with `at = [...]`");
    return false;
  }
  if (is_poison(evaluator_.value_of(index, e.span))) return false;
  groups_.pieces.push_back(name);
  return true;
}

/// `split = ["crack"]`, where it is written: inner groups along which the mesh is cut.
bool Meshes::split_along(const ast::Expr* written, MeshSpec& spec) {
  if (!written) return true;
  const auto* list = std::get_if<ast::List>(&written->node);
  if (!list) {
    mistakes_.error("E0306", written->span, "`split` is a list of groups: `split = [\"crack\"]`");
    return false;
  }
  for (const ast::Expr& item : list->items) {
    const auto* name = std::get_if<ast::String>(&item.node);
    const auto group = name ? groups_.kinds.find(name->text) : groups_.kinds.end();
    if (group == groups_.kinds.end() || group->second != Group::Kind::facets) {
      mistakes_.error(
          name ? "E0602" : "E0306", item.span,
          name ? fmt::format("the mesh `{}` has no group \"{}\" of facets", spec.name, name->text)
               : "the name of a group is a text: `split = [\"crack\"]`");
      return false;
    }
    groups_.kinds.erase(group);
    groups_.kinds[name->text + ".first"] = groups_.kinds[name->text + ".second"] =
        Group::Kind::facets;
    groups_.cuts.insert(name->text);
    spec.split.push_back(name->text);
  }
  if (spec.adapted == 0) return true;
  mistakes_.error("E0440", written->span, "a mesh that is cut is not adapted",
                  "give it small cells where it matters");
  return false;
}

} // namespace hvi::lang
