// Meshes put together: `mesh both = upper + lower`, and what their groups are called.
#include "lang/check/checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

using solver::Group;
using solver::MeshSpec;
using solver::RegionSpec;

namespace {

/// The group `piece.group` of the whole mesh.
std::string of_piece(const std::string& piece, const std::string& group) {
  return fmt::format("{}.{}", piece, group);
}

} // namespace

/// The mesh that is put together comes first: the others are its pieces then.
void Checker::locate_pieces() {
  for (std::size_t i = 0; i < declarations_.size(); ++i) {
    const auto* mesh = std::get_if<ast::Mesh>(declarations_[i].statement);
    if (mesh == nullptr || !std::holds_alternative<ast::Binary>(mesh->value.node)) continue;
    const bool used = declarations_[i].used;
    value_of(static_cast<int>(i), mesh->name.span);
    declarations_[i].used = used;
    return;
  }
}

Value Checker::mesh_of_pieces(const ast::Mesh& m) {
  if (!mesh_name_.empty()) {
    second_mesh(m.name.span);
    return Poison{};
  }
  mesh_name_ = m.name.text;
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
    groups_.clear();
    if (!add_piece(**name)) {
      good = false;
      continue;
    }
    if (!spec.pieces.empty() && model_.dim != dim) {
      error("E0307", (*name)->span,
            fmt::format("a mesh in {}D and one in {}D are not put together", dim, model_.dim));
      good = false;
    }
    if (!spec.pieces.empty() && model_.mesh.axisymmetric != spec.axisymmetric) {
      error("E0440", (*name)->span, "an axisymmetric mesh and another one are not put together",
            "give all of them `axisymmetric = true`, or none");
      good = false;
    }
    spec.axisymmetric = model_.mesh.axisymmetric;
    const std::string& piece = pieces_.back();
    groups[piece] = Group::Kind::cells;
    groups[of_piece(piece, "boundary")] = Group::Kind::facets;
    for (const auto& [group, kind] : groups_) groups[of_piece(piece, group)] = kind;
    for (const auto& group : std::exchange(cuts_, {})) cuts.insert(of_piece(piece, group));
    spec.pieces.push_back(model_.mesh);
    const int adapted = std::exchange(spec.pieces.back().adapted, 0);
    if (spec.pieces.size() > 1 && (adapted > 0) != (spec.adapted > 0)) {
      error("E0440", (*name)->span,
            fmt::format("`{}` is {}adapted, the piece before it is {}", piece,
                        adapted > 0 ? "" : "not ", adapted > 0 ? "not" : ""),
            "give all pieces `adapted = CELLS`, or none: the cells go where the errors are");
      good = false;
    }
    spec.adapted += adapted; // of all pieces together
  }
  making_pieces_ = false;
  groups_ = std::move(groups);
  cuts_ = std::move(cuts);
  groups_known_ = good;
  if (!good) return Poison{};
  spec.kind = MeshSpec::Kind::pieces;
  spec.name = m.name.text;
  spec.origin = model_.origin(m.value.span);
  model_.mesh = std::move(spec);
  return MeshValue{0};
}

/// Makes model_.mesh, model_.dim and groups_ those of the mesh with this name.
bool Checker::add_piece(const ast::Expr& e) {
  const std::string& name = std::get<ast::Reference>(e.node).name;
  const int index = find_declaration(name);
  if (index < 0) {
    Scope none;
    unknown_name(e.span, name, none);
    return false;
  }
  const auto* made = std::get_if<ast::Mesh>(declarations_[index].statement);
  if (made == nullptr || !std::holds_alternative<ast::Call>(made->value.node)) {
    error("E0306", e.span, fmt::format("`{}` is no mesh made by a call", name),
          "a piece is one mesh: `rectangle(...)`, `box(...)`, `gmsh(...)`");
    return false;
  }
  if (std::ranges::find(pieces_, name) != pieces_.end()) {
    error("E0440", e.span, fmt::format("`{}` is put together with itself", name),
          "two bodies of one shape are two meshes: declare it again, with `at = [...]`");
    return false;
  }
  if (is_poison(value_of(index, e.span))) return false;
  pieces_.push_back(name);
  return true;
}

/// The group of the whole mesh that a piece's group is. Of the whole mesh itself: the one that a
/// single piece has. "" (reported): of several pieces.
std::string Checker::group_named(const MeshValue& mesh, const std::string& name, const Span& span) {
  if (mesh.index > 0) return of_piece(pieces_[static_cast<std::size_t>(mesh.index) - 1], name);
  const auto known = [&](const std::string& group) {
    return groups_.count(group) > 0 || cuts_.contains(group);
  };
  std::vector<std::string> found;
  for (const std::string& piece : pieces_)
    if (auto whole = of_piece(piece, name); known(whole)) found.push_back(std::move(whole));
  if (known(name) || found.empty()) return name;
  if (found.size() == 1) return found.front();
  error("E0440", span, fmt::format("`{}` is in several pieces of `{}`", name, mesh_name_),
        fmt::format("write `{}`, or their sum `{}`", fmt::join(found, "`, `"),
                    fmt::join(found, " + ")));
  return {};
}

std::vector<std::string> Checker::groups_of(const MeshValue& mesh) const {
  std::vector<std::string> out;
  const std::string prefix =
      mesh.index > 0 ? pieces_[static_cast<std::size_t>(mesh.index) - 1] + "." : "";
  for (const auto& [group, kind] : groups_)
    if (group.starts_with(prefix)) out.push_back(group.substr(prefix.size()));
  return out;
}

/// `split = ["crack"]`, where it is written: inner groups along which the mesh is cut.
bool Checker::split_along(const ast::Expr* written, MeshSpec& spec) {
  if (!written) return true;
  const auto* list = std::get_if<ast::List>(&written->node);
  if (!list) {
    error("E0306", written->span, "`split` is a list of groups: `split = [\"crack\"]`");
    return false;
  }
  for (const ast::Expr& item : list->items) {
    const auto* name = std::get_if<ast::String>(&item.node);
    const auto group = name ? groups_.find(name->text) : groups_.end();
    if (group == groups_.end() || group->second != Group::Kind::facets) {
      error(name ? "E0602" : "E0306", item.span,
            name ? fmt::format("the mesh `{}` has no group \"{}\" of facets", spec.name, name->text)
                 : "the name of a group is a text: `split = [\"crack\"]`");
      return false;
    }
    groups_.erase(group);
    groups_[name->text + ".first"] = groups_[name->text + ".second"] = Group::Kind::facets;
    cuts_.insert(name->text);
    spec.split.push_back(name->text);
  }
  if (spec.adapted == 0) return true;
  error("E0440", written->span, "a mesh that is cut is not adapted",
        "give it small cells where it matters");
  return false;
}

/// A group of the mesh; one along which it is cut is a pair.
RegionSpec Checker::group_region(const std::string& group, const Span& span) {
  RegionSpec spec;
  spec.kind = RegionSpec::Kind::group;
  spec.origin = model_.origin(span);
  spec.name = group;
  if (!cuts_.contains(group)) return spec;
  RegionSpec pair;
  pair.kind = RegionSpec::Kind::pair;
  pair.origin = spec.origin;
  pair.children = {spec, spec};
  pair.children[0].name += ".first";
  pair.children[1].name += ".second";
  return pair;
}

/// All cells of the mesh, or of a piece.
RegionSpec Checker::whole(const MeshValue& mesh, const Span& span) {
  RegionSpec spec;
  spec.origin = model_.origin(span);
  if (mesh.index == 0) return spec;
  spec.kind = RegionSpec::Kind::group;
  spec.name = pieces_[static_cast<std::size_t>(mesh.index) - 1];
  return spec;
}

} // namespace hvi::lang
