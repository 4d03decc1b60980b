#include "lang/check/parts.hpp"

#include "lang/diag/suggest.hpp"
#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <utility>

namespace hvi::lang {

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

Value Parts::part(const ast::Part& written) {
  auto spec = region(written.region);
  if (!spec) return Poison{};
  model_.parts.push_back({written.name.text, written.name.span, *spec, groups_.kind_of(*spec)});
  const int index = static_cast<int>(model_.parts.size()) - 1;
  part_of_[written.name.text] = index;
  return PartValue{index};
}

std::optional<RegionSpec> Parts::region(const ast::Region& r) {
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
      mistakes_.error("E0216", term.span,
                      fmt::format("more than {} places are put together in one part", most_places));
      return std::nullopt;
    }
    if (!out) {
      out = std::move(spec);
      continue;
    }
    const bool pairs = out->kind == RegionSpec::Kind::pair || spec->kind == RegionSpec::Kind::pair;
    if (pairs) {
      mistakes_.error("E0441", term.span, "a pair is no part of another part",
                      "put sides together inside it: `pair(a.left + a.bottom, b.right)`");
      return std::nullopt;
    }
    const auto left = groups_.kind_of(*out), right = groups_.kind_of(*spec);
    if (left && right && *left != *right) {
      mistakes_.error(
          "E0306", term.span,
          fmt::format("{} and {} cannot be combined", kind_word(*left), kind_word(*right)));
      good = false;
      continue;
    }
    out = combined(term.minus ? RegionSpec::Kind::subtract : RegionSpec::Kind::unite,
                   model_.origin(r.span), std::move(*out), std::move(*spec));
  }
  if (r.where && out && out->kind == RegionSpec::Kind::pair) {
    mistakes_.error(
        "E0441", r.where->span, "a condition on a pair",
        "take it on a side: `part some = upper.bottom where x < 1`, then `pair(some, lower.top)`");
    return std::nullopt;
  }
  if (r.where) {
    Scope scope;
    scope.what = "the condition of a part";
    scope.position = true;
    auto predicate = evaluator_.condition(*r.where, scope);
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

std::optional<RegionSpec> Parts::region_term(const ast::RegionTerm& term) {
  if (const auto* inner = std::get_if<Box<ast::Region>>(&term.term)) return region(**inner);
  return region_path(std::get<ast::Expr>(term.term));
}

std::optional<RegionSpec> Parts::region_path(const ast::Expr& path) {
  if (const auto* call = std::get_if<ast::Call>(&path.node)) {
    const auto* callee = std::get_if<ast::Reference>(&call->callee->node);
    if (callee && callee->name == "point") return point_region(path, *call);
    if (callee && callee->name == "pair" && names_.find("pair") < 0)
      return pair_region(path, *call);
    if (std::holds_alternative<ast::Member>(call->callee->node)) return mesh_group(path, *call);
    if (callee && names_.find(callee->name) < 0) {
      Scope none;
      names_.report_unknown(call->callee->span, callee->name, none);
      return std::nullopt;
    }
  }
  if (const auto* m = std::get_if<ast::Member>(&path.node)) {
    const auto* object = std::get_if<ast::Reference>(&m->object->node);
    if (object) {
      Scope none;
      Value value = evaluator_.reference(*m->object, object->name, none);
      if (is_poison(value)) return std::nullopt;
      if (const auto* mesh = std::get_if<MeshValue>(&value))
        return mesh_member(path, *mesh, object->name, m->member);
      mistakes_.error(
          "E0303", m->member.span,
          fmt::format("{} has no member `{}`", describe(value), m->member.text),
          fmt::format("sides belong to a mesh: `{}.{}`", groups_.mesh_name, m->member.text));
      return std::nullopt;
    }
  }
  if (const auto* r = std::get_if<ast::Reference>(&path.node)) {
    Scope none;
    Value value = evaluator_.reference(path, r->name, none);
    if (is_poison(value)) return std::nullopt;
    if (const auto* mesh = std::get_if<MeshValue>(&value)) return whole(*mesh, path.span);
    if (const auto* part = std::get_if<PartValue>(&value)) return model_.parts[part->index].region;
    mistakes_.error("E0306", path.span,
                    fmt::format("a part of a mesh is expected here, not {}", describe(value)));
    return std::nullopt;
  }
  mistakes_.error(
      "E0306", path.span, "a part of a mesh is expected here",
      "`slab.top`, `slab.group(\"roof\")`, `slab.boundary where y > 0.99`, `point(slab, [0, 0])`");
  return std::nullopt;
}

std::optional<RegionSpec> Parts::mesh_member(const ast::Expr& path, const MeshValue& value,
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
  if (groups_.known && !groups_.has(spec.name)) {
    std::vector<std::string> known = groups_.of(value);
    if (value.index == 0) known.insert(known.begin(), "boundary");
    const bool structured = model_.mesh.kind != MeshSpec::Kind::file;
    const std::string near = did_you_mean(name.text, known);
    mistakes_.error(
        structured ? "E0303" : "E0602", name.span,
        fmt::format("the mesh `{}` has no {} `{}`", mesh, structured ? "side" : "group", name.text),
        near.empty() ? fmt::format("there are: {}", solver::joined(known)) : near);
    return std::nullopt;
  }
  return group_region(spec.name, path.span);
}

std::optional<RegionSpec> Parts::mesh_group(const ast::Expr& path, const ast::Call& call) {
  const auto& m = std::get<ast::Member>(call.callee->node);
  const auto* object = std::get_if<ast::Reference>(&m.object->node);
  Scope none;
  if (!object) {
    mistakes_.error("E0310", call.callee->span, "only names are called");
    return std::nullopt;
  }
  Value value = evaluator_.reference(*m.object, object->name, none);
  if (is_poison(value)) return std::nullopt;
  if (!std::holds_alternative<MeshValue>(value) || m.member.text != "group") {
    mistakes_.error(
        "E0303", m.member.span,
        fmt::format("{} has no member `{}` to be called", describe(value), m.member.text),
        edit_distance(m.member.text, "group") <= 2 ? "did you mean `group`?"
                                                   : "`slab.group(\"roof\")` is a group of a mesh");
    return std::nullopt;
  }
  auto args = evaluator_.match(path, call, "group", {"name"}, 1);
  if (!args) return std::nullopt;
  const auto* name = std::get_if<ast::String>(&(*args)[0]->node);
  if (!name) {
    mistakes_.error("E0306", (*args)[0]->span,
                    "the name of a group is a text: `slab.group(\"roof\")`");
    return std::nullopt;
  }
  const auto& mesh = std::get<MeshValue>(value);
  std::string group = group_named(mesh, name->text, (*args)[0]->span);
  if (group.empty()) return std::nullopt;
  if (mesh.index > 0) {
    const std::string& piece = groups_.pieces[static_cast<std::size_t>(mesh.index) - 1];
    if (std::string own = MeshGroups::of_file(piece, name->text); groups_.has(own)) group = own;
  }
  if (groups_.known && !groups_.has(group)) {
    const std::vector<std::string> known = groups_.of(mesh);
    const std::string near = did_you_mean(name->text, known);
    mistakes_.error("E0602", (*args)[0]->span,
                    fmt::format("the mesh `{}` has no group \"{}\"", object->name, name->text),
                    near.empty()
                        ? (known.empty() ? std::string("it has no groups")
                                         : fmt::format("there are: {}", solver::joined(known)))
                        : near);
    return std::nullopt;
  }
  return group_region(group, path.span);
}

std::optional<RegionSpec> Parts::point_region(const ast::Expr& path, const ast::Call& call) {
  auto args = evaluator_.match(path, call, "point", {"mesh", "at"}, 2);
  if (!args) return std::nullopt;
  Scope none;
  Value value = evaluator_.expr(*(*args)[0], none);
  auto at = evaluator_.constant_list(*(*args)[1], "a point");
  if (is_poison(value) || !at) return std::nullopt;
  if (!std::holds_alternative<MeshValue>(value)) {
    mistakes_.error("E0306", (*args)[0]->span,
                    fmt::format("a mesh is expected here, not {}", describe(value)));
    return std::nullopt;
  }
  if (static_cast<int>(at->size()) != model_.dim) {
    mistakes_.error("E0307", (*args)[1]->span,
                    fmt::format("a point in {0}D has {0} coordinates", model_.dim));
    return std::nullopt;
  }
  RegionSpec spec;
  spec = whole(std::get<MeshValue>(value), path.span); // of a piece: among its nodes
  spec.kind = RegionSpec::Kind::point;
  for (int i = 0; i < model_.dim; ++i) spec.point[i] = (*at)[i];
  return spec;
}

std::optional<int> Parts::index_of(const ast::Name& name) {
  Scope none;
  none.what = "a place";
  ast::Expr as_expr;
  as_expr.span = name.span;
  Value value = evaluator_.reference(as_expr, name.text, none);
  if (is_poison(value)) return std::nullopt;
  if (const auto* part = std::get_if<PartValue>(&value)) return part->index;
  if (const auto* mesh = std::get_if<MeshValue>(&value)) {
    if (auto found = part_of_.find(name.text); found != part_of_.end()) return found->second;
    RegionSpec spec = whole(*mesh, name.span);
    model_.parts.push_back({name.text, name.span, spec, Group::Kind::cells});
    part_of_[name.text] = static_cast<int>(model_.parts.size()) - 1;
    return part_of_[name.text];
  }
  mistakes_.error("E0306", name.span,
                  fmt::format("a part of a mesh is expected here, not {}", describe(value)));
  return std::nullopt;
}

/// The group of the whole mesh that a piece's group is. Of the whole mesh itself: the one that a
/// single piece has. "" (reported): of several pieces.
std::string Parts::group_named(const MeshValue& mesh, const std::string& name, const Span& span) {
  if (mesh.index > 0)
    return MeshGroups::of_piece(groups_.pieces[static_cast<std::size_t>(mesh.index) - 1], name);
  std::vector<std::string> found;
  for (const std::string& piece : groups_.pieces)
    if (auto whole = MeshGroups::of_piece(piece, name); groups_.has(whole))
      found.push_back(std::move(whole));
  if (groups_.has(name) || found.empty()) return name;
  if (found.size() == 1) return found.front();
  mistakes_.error("E0440", span,
                  fmt::format("`{}` is in several pieces of `{}`", name, groups_.mesh_name),
                  fmt::format("write `{}`, or their sum `{}`", solver::joined(found, "`, `"),
                              solver::joined(found, " + ")));
  return {};
}

/// A group of the mesh; one along which it is cut is a pair.
RegionSpec Parts::group_region(const std::string& group, const Span& span) {
  RegionSpec spec;
  spec.kind = RegionSpec::Kind::group;
  spec.origin = model_.origin(span);
  spec.name = group;
  if (!groups_.cuts.contains(group)) return spec;
  RegionSpec pair;
  pair.kind = RegionSpec::Kind::pair;
  pair.origin = spec.origin;
  pair.children = {spec, spec};
  pair.children[0].name += ".first";
  pair.children[1].name += ".second";
  return pair;
}

/// All cells of the mesh, or of a piece.
RegionSpec Parts::whole(const MeshValue& mesh, const Span& span) {
  RegionSpec spec;
  spec.origin = model_.origin(span);
  if (mesh.index == 0) return spec;
  spec.kind = RegionSpec::Kind::group;
  spec.name = groups_.pieces[static_cast<std::size_t>(mesh.index) - 1];
  return spec;
}

/// pair(first, second, reach = ..)
std::optional<RegionSpec> Parts::pair_region(const ast::Expr& path, const ast::Call& call) {
  const auto args = evaluator_.match(path, call, "pair", {"first", "second", "reach"}, 2);
  if (!args) return std::nullopt;
  auto first = side_of_pair(*(*args)[0]), second = side_of_pair(*(*args)[1]);
  RegionSpec spec;
  spec.kind = RegionSpec::Kind::pair;
  spec.origin = model_.origin(path.span);
  if ((*args)[2]) {
    const auto reach = evaluator_.constant(*(*args)[2], "the reach of a pair");
    if (!reach) return std::nullopt;
    if (!(*reach > 0.0)) {
      mistakes_.error("E0408", (*args)[2]->span, "the reach of a pair is positive");
      return std::nullopt;
    }
    spec.reach = *reach;
  }
  if (!first || !second) return std::nullopt;
  if (model_.dim == 1) {
    mistakes_.error("E0441", path.span, "a pair is of two sides in 2D or 3D");
    return std::nullopt;
  }
  spec.children = {std::move(*first), std::move(*second)};
  return spec;
}

/// A side, or sides put together: `upper.left + upper.bottom`, a part by its name.
std::optional<RegionSpec> Parts::side_of_pair(const ast::Expr& e) {
  std::optional<RegionSpec> out;
  const auto* sum = std::get_if<ast::Binary>(&e.node);
  if (sum && (sum->op == ast::BinaryOp::add || sum->op == ast::BinaryOp::subtract)) {
    auto left = side_of_pair(*sum->left), right = side_of_pair(*sum->right);
    if (!left || !right) return std::nullopt;
    out.emplace();
    out->kind =
        sum->op == ast::BinaryOp::add ? RegionSpec::Kind::unite : RegionSpec::Kind::subtract;
    out->origin = model_.origin(e.span);
    out->children = {std::move(*left), std::move(*right)};
    return out;
  }
  out = region_path(e);
  if (!out) return std::nullopt;
  const auto kind = groups_.kind_of(*out);
  if (out->kind != RegionSpec::Kind::pair && (!kind || *kind == Group::Kind::facets)) return out;
  mistakes_.error("E0441", e.span,
                  out->kind == RegionSpec::Kind::pair ? "a pair is no side of a pair"
                                                      : "a pair is of two parts of the boundary",
                  "`pair(upper.bottom, lower.top)`");
  return std::nullopt;
}

} // namespace hvi::lang
