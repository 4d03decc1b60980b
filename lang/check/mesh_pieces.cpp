// Meshes put together: `mesh both = upper + lower`, and what their groups are called.

#include "lang/check/meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

using solver::Group;
using solver::MeshSpec;
using solver::RegionSpec;

namespace {

/// The names in `a + b + c`, from the left.
std::vector<const ast::Expr*> summands(const ast::Expr& whole) {
  std::vector<const ast::Expr*> out;
  for (const ast::Expr* left = &whole; left != nullptr;) {
    const auto* sum = std::get_if<ast::Binary>(&left->node);
    out.push_back(sum ? &*sum->right : left);
    left = sum ? &*sum->left : nullptr;
  }
  std::ranges::reverse(out);
  return out;
}

} // namespace

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
  bool good = true;
  for (const ast::Expr* name : summands(m.value)) {
    const int dim = model_.dim;
    groups_.kinds.clear();
    if (!add_piece(*name)) {
      good = false;
      continue;
    }
    if (!spec.pieces.empty() && !fits(spec, dim, name->span)) good = false;
    spec.axisymmetric = model_.mesh.axisymmetric;
    const std::string& piece = groups_.pieces.back();
    groups[piece] = Group::Kind::cells;
    groups[MeshGroups::of_piece(piece, "boundary")] = Group::Kind::facets;
    for (const auto& [group, kind] : groups_.kinds)
      groups[MeshGroups::of_file(piece, group)] = kind;
    for (const auto& group : std::exchange(groups_.cuts, {}))
      cuts.insert(MeshGroups::of_piece(piece, group));
    spec.pieces.push_back(model_.mesh);
    spec.adapted += std::exchange(spec.pieces.back().adapted, 0); // of all pieces together
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

/// Is the mesh that was added last, model_.mesh, of one kind with the pieces before it?
bool Meshes::fits(const MeshSpec& before, int dim_before, const Span& span) {
  bool good = true;
  if (model_.dim != dim_before) {
    mistakes_.error(
        "E0307", span,
        fmt::format("a mesh in {}D and one in {}D are not put together", dim_before, model_.dim));
    good = false;
  }
  if (model_.mesh.axisymmetric != before.axisymmetric) {
    mistakes_.error("E0440", span, "an axisymmetric mesh and another one are not put together",
                    "give all of them `axisymmetric = true`, or none");
    good = false;
  }
  const bool adapted = model_.mesh.adapted > 0;
  if (adapted != (before.adapted > 0)) {
    mistakes_.error(
        "E0440", span,
        fmt::format("`{}` is {}adapted, the piece before it is{}", groups_.pieces.back(),
                    adapted ? "" : "not ", adapted ? " not" : ""),
        "give all pieces `adapted = CELLS`, or none: the cells go where the errors are");
    good = false;
  }
  return good;
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
