// Parts of the mesh: sides, groups, points, sums, differences and conditions.
#include "lang/check/checker.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::MeshSpec;
using solver::RegionSpec;

namespace {

const char* kind_word(Group::Kind kind) {
  return kind == Group::Kind::cells ? "cells" : kind == Group::Kind::facets ? "boundary" : "points";
}

/// Of places put together in one part, those of the parts it names among them.
constexpr std::size_t most_places = 1200;

std::size_t places_in(const RegionSpec& region) {
  std::size_t out = region.children.empty() ? 1 : 0;
  for (const RegionSpec& child : region.children) out += places_in(child);
  return out;
}

RegionSpec combined(RegionSpec::Kind kind, solver::Origin origin, RegionSpec left,
                    RegionSpec right) {
  RegionSpec both;
  both.kind = kind;
  both.origin = origin;
  both.children.reserve(2);
  both.children.push_back(std::move(left));
  both.children.push_back(std::move(right));
  return both;
}

} // namespace

std::optional<RegionSpec> Checker::region(const ast::Region& r) {
  std::optional<RegionSpec> out;
  bool good = true;
  std::size_t places = 0;
  for (const ast::RegionTerm& term : r.terms) {
    auto spec = region_term(term);
    if (!spec) {
      good = false;
      continue;
    }
    places += places_in(*spec);
    if (places > most_places) {
      error("E0216", term.span,
            fmt::format("more than {} places are put together in one part", most_places));
      return std::nullopt;
    }
    if (!out) {
      out = std::move(spec);
      continue;
    }
    const bool pairs = out->kind == RegionSpec::Kind::pair || spec->kind == RegionSpec::Kind::pair;
    if (pairs) {
      error("E0441", term.span, "a pair is no part of another part",
            "put sides together inside it: `pair(a.left + a.bottom, b.right)`");
      return std::nullopt;
    }
    const auto left = kind_of(*out), right = kind_of(*spec);
    if (left && right && *left != *right) {
      error("E0306", term.span,
            fmt::format("{} and {} cannot be combined", kind_word(*left), kind_word(*right)));
      good = false;
      continue;
    }
    out = combined(term.minus ? RegionSpec::Kind::subtract : RegionSpec::Kind::unite,
                   model_.origin(r.span), std::move(*out), std::move(*spec));
  }
  if (r.where && out && out->kind == RegionSpec::Kind::pair) {
    error(
        "E0441", r.where->span, "a condition on a pair",
        "take it on a side: `part some = upper.bottom where x < 1`, then `pair(some, lower.top)`");
    return std::nullopt;
  }
  if (r.where) {
    Scope scope;
    scope.what = "the condition of a part";
    scope.position = true;
    auto predicate = condition(*r.where, scope);
    if (!predicate) return std::nullopt;
    if (!good || !out) return std::nullopt;
    RegionSpec where;
    where.kind = RegionSpec::Kind::where;
    where.origin = model_.origin(r.where->span);
    where.predicate = *predicate;
    where.children = {std::move(*out)};
    out = std::move(where);
  }
  return good ? out : std::nullopt;
}

std::optional<RegionSpec> Checker::region_term(const ast::RegionTerm& term) {
  if (const auto* inner = std::get_if<Box<ast::Region>>(&term.term)) return region(**inner);
  return region_path(std::get<ast::Expr>(term.term));
}

std::optional<RegionSpec> Checker::region_path(const ast::Expr& path) {
  if (const auto* call = std::get_if<ast::Call>(&path.node)) {
    const auto* callee = std::get_if<ast::Reference>(&call->callee->node);
    if (callee && callee->name == "point") return point_region(path, *call);
    if (callee && callee->name == "pair" && find_declaration("pair") < 0)
      return pair_region(path, *call);
    if (std::holds_alternative<ast::Member>(call->callee->node)) return mesh_group(path, *call);
    if (callee && find_declaration(callee->name) < 0) {
      Scope none;
      unknown_name(call->callee->span, callee->name, none);
      return std::nullopt;
    }
  }
  if (const auto* m = std::get_if<ast::Member>(&path.node)) {
    const auto* object = std::get_if<ast::Reference>(&m->object->node);
    if (object) {
      Scope none;
      Value value = reference(*m->object, object->name, none);
      if (is_poison(value)) return std::nullopt;
      if (const auto* mesh = std::get_if<MeshValue>(&value))
        return mesh_member(path, *mesh, object->name, m->member);
      error("E0303", m->member.span,
            fmt::format("{} has no member `{}`", describe(value), m->member.text),
            fmt::format("sides belong to a mesh: `{}.{}`", mesh_name_, m->member.text));
      return std::nullopt;
    }
  }
  if (const auto* r = std::get_if<ast::Reference>(&path.node)) {
    Scope none;
    Value value = reference(path, r->name, none);
    if (is_poison(value)) return std::nullopt;
    if (const auto* mesh = std::get_if<MeshValue>(&value)) return whole(*mesh, path.span);
    if (const auto* part = std::get_if<PartValue>(&value)) return model_.parts[part->index].region;
    error("E0306", path.span,
          fmt::format("a part of a mesh is expected here, not {}", describe(value)));
    return std::nullopt;
  }
  error(
      "E0306", path.span, "a part of a mesh is expected here",
      "`slab.top`, `slab.group(\"roof\")`, `slab.boundary where y > 0.99`, `point(slab, [0, 0])`");
  return std::nullopt;
}

std::optional<RegionSpec> Checker::mesh_member(const ast::Expr& path, const MeshValue& value,
                                               const std::string& mesh, const ast::Name& name) {
  RegionSpec spec;
  spec.origin = model_.origin(path.span);
  if (name.text == "boundary" && value.index == 0) {
    spec.kind = RegionSpec::Kind::boundary;
    return spec;
  }
  spec.kind = RegionSpec::Kind::group;
  spec.name = group_named(value, name.text, name.span);
  if (spec.name.empty()) return std::nullopt;
  if (groups_known_ && !groups_.count(spec.name) && !cuts_.contains(spec.name)) {
    std::vector<std::string> known = groups_of(value);
    if (value.index == 0) known.insert(known.begin(), "boundary");
    const bool structured = model_.mesh.kind != MeshSpec::Kind::file;
    const std::string near = did_you_mean(name.text, known);
    error(
        structured ? "E0303" : "E0602", name.span,
        fmt::format("the mesh `{}` has no {} `{}`", mesh, structured ? "side" : "group", name.text),
        near.empty() ? fmt::format("there are: {}", fmt::join(known, ", ")) : near);
    return std::nullopt;
  }
  return group_region(spec.name, path.span);
}

std::optional<RegionSpec> Checker::mesh_group(const ast::Expr& path, const ast::Call& call) {
  const auto& m = std::get<ast::Member>(call.callee->node);
  const auto* object = std::get_if<ast::Reference>(&m.object->node);
  Scope none;
  if (!object) {
    error("E0310", call.callee->span, "only names are called");
    return std::nullopt;
  }
  Value value = reference(*m.object, object->name, none);
  if (is_poison(value)) return std::nullopt;
  if (!std::holds_alternative<MeshValue>(value) || m.member.text != "group") {
    error("E0303", m.member.span,
          fmt::format("{} has no member `{}` to be called", describe(value), m.member.text),
          edit_distance(m.member.text, "group") <= 2
              ? "did you mean `group`?"
              : "`slab.group(\"roof\")` is a group of a mesh");
    return std::nullopt;
  }
  auto args = match(path, call, "group", {"name"}, 1);
  if (!args) return std::nullopt;
  const auto* name = std::get_if<ast::String>(&(*args)[0]->node);
  if (!name) {
    error("E0306", (*args)[0]->span, "the name of a group is a text: `slab.group(\"roof\")`");
    return std::nullopt;
  }
  const auto& mesh = std::get<MeshValue>(value);
  const std::string group = group_named(mesh, name->text, (*args)[0]->span);
  if (group.empty()) return std::nullopt;
  if (groups_known_ && !groups_.count(group) && !cuts_.contains(group)) {
    const std::vector<std::string> known = groups_of(mesh);
    const std::string near = did_you_mean(name->text, known);
    error("E0602", (*args)[0]->span,
          fmt::format("the mesh `{}` has no group \"{}\"", object->name, name->text),
          near.empty() ? (known.empty() ? std::string("it has no groups")
                                        : fmt::format("there are: {}", fmt::join(known, ", ")))
                       : near);
    return std::nullopt;
  }
  return group_region(group, path.span);
}

std::optional<RegionSpec> Checker::point_region(const ast::Expr& path, const ast::Call& call) {
  auto args = match(path, call, "point", {"mesh", "at"}, 2);
  if (!args) return std::nullopt;
  Scope none;
  Value value = expr(*(*args)[0], none);
  auto at = constant_list(*(*args)[1], "a point");
  if (is_poison(value) || !at) return std::nullopt;
  if (!std::holds_alternative<MeshValue>(value)) {
    error("E0306", (*args)[0]->span,
          fmt::format("a mesh is expected here, not {}", describe(value)));
    return std::nullopt;
  }
  if (static_cast<int>(at->size()) != model_.dim) {
    error("E0307", (*args)[1]->span,
          fmt::format("a point in {0}D has {0} coordinates", model_.dim));
    return std::nullopt;
  }
  RegionSpec spec;
  spec = whole(std::get<MeshValue>(value), path.span); // of a piece: among its nodes
  spec.kind = RegionSpec::Kind::point;
  for (int i = 0; i < model_.dim; ++i) spec.point[i] = (*at)[i];
  return spec;
}

std::optional<Group::Kind> Checker::kind_of(const RegionSpec& r) const {
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
    auto found = groups_.find(r.name);
    return found == groups_.end() ? std::nullopt : std::optional(found->second);
  }
  case RegionSpec::Kind::unite:
  case RegionSpec::Kind::subtract:
  case RegionSpec::Kind::where:
    return kind_of(r.children[0]);
  }
  return std::nullopt;
}

std::optional<int> Checker::part_index(const ast::Name& name) {
  Scope none;
  none.what = "a place";
  ast::Expr as_expr;
  as_expr.span = name.span;
  Value value = reference(as_expr, name.text, none);
  if (is_poison(value)) return std::nullopt;
  if (const auto* part = std::get_if<PartValue>(&value)) return part->index;
  if (const auto* mesh = std::get_if<MeshValue>(&value)) {
    if (auto found = part_of_.find(name.text); found != part_of_.end()) return found->second;
    RegionSpec spec = whole(*mesh, name.span);
    model_.parts.push_back({name.text, name.span, spec, Group::Kind::cells});
    part_of_[name.text] = static_cast<int>(model_.parts.size()) - 1;
    return part_of_[name.text];
  }
  error("E0306", name.span,
        fmt::format("a part of a mesh is expected here, not {}", describe(value)));
  return std::nullopt;
}

} // namespace hvi::lang
