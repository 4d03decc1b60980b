#include "lang/check/imposed_values.hpp"

#include "lang/check/spaces.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang {

namespace slot = solver::slot;

/// Whether every point of `part` lies in `larger`, as far as the way they are written tells.
bool ImposedValues::contains(const solver::RegionSpec& larger,
                             const solver::RegionSpec& part) const {
  using Kind = solver::RegionSpec::Kind;
  const auto some = [&](const std::vector<solver::RegionSpec>& children) {
    return std::any_of(children.begin(), children.end(),
                       [&](const auto& child) { return contains(child, part); });
  };
  if (part.kind == Kind::unite)
    return contains(larger, part.children[0]) && contains(larger, part.children[1]);
  if (larger.kind == Kind::unite && some(larger.children)) return true;
  if (larger.kind == Kind::boundary) {
    const auto kind = groups_.kind_of(part);
    if (kind && *kind == solver::Group::Kind::facets) return true;
  }
  const bool same = larger.kind == part.kind && larger.name == part.name &&
                    (larger.kind == Kind::group || larger.kind == Kind::boundary);
  if (same) return true;
  return (part.kind == Kind::where || part.kind == Kind::subtract) &&
         contains(larger, part.children[0]);
}

/// The entry of an unknown's space that a value on a part fills in: the one of the part itself, or
/// a new one inside a larger part on which the space is zero. Null when the space is not zero
/// there.
solver::DirichletSpec* ImposedValues::imposed_entry(int unknown, int part, int component) {
  auto& entries = model_.space.dirichlet;
  const auto acts = [&](const solver::DirichletSpec& d) {
    return d.unknown == unknown && (d.component == component || d.component == -1);
  };
  for (solver::DirichletSpec& d : entries)
    if (d.part == part && acts(d)) return &d;
  const auto& region = model_.parts[static_cast<std::size_t>(part)].region;
  const bool inside = std::any_of(entries.begin(), entries.end(), [&](const auto& d) {
    return acts(d) && contains(model_.parts[static_cast<std::size_t>(d.part)].region, region);
  });
  if (!inside) return nullptr;
  solver::DirichletSpec entry;
  entry.part = part;
  entry.component = component;
  entry.unknown = unknown;
  entries.push_back(entry);
  return &entries.back();
}

void ImposedValues::read(const ast::Find& find) {
  std::set<std::array<int, 3>> before; // unknown, part and component
  for (const ast::ImposedValue& imposed : find.imposed) imposed_value(imposed, before);
}

/// Which component of the unknown, -1 for all; nothing (reported) where there is no such.
std::optional<int> ImposedValues::imposed_component(const ast::ImposedValue& imposed, int unknown) {
  if (!imposed.component) return -1;
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  const auto c = vector ? component_index(*imposed.component, model_.dim) : std::nullopt;
  if (!c)
    mistakes_.error(
        "E0315", imposed.component->span,
        fmt::format("`{}` has no component `{}`", imposed.unknown.text, imposed.component->text));
  return c;
}

/// A number or a vector, as the unknown or its component is (else reported)?
bool ImposedValues::has_shape_of(const ast::ImposedValue& imposed, const Field& value, int unknown,
                                 int component) {
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  const int wanted = component >= 0 ? 1 : unknowns_.components_of(unknown);
  const bool zero = value.rank == 0 && value.scalar().is(0.0);
  if (zero || (static_cast<int>(value.components.size()) == wanted && value.rank <= 1 &&
               (value.rank == 1) == (wanted > 1 || (component < 0 && vector))))
    return true;
  mistakes_.error("E0307", imposed.value.span,
                  fmt::format("{} is imposed where {} is expected", describe(value),
                              wanted == 1 ? "a scalar" : fmt::format("a vector of {}", wanted)));
  return false;
}

/// E0416 where a value is imposed twice on a component, or where the space is not zero.
solver::DirichletSpec* ImposedValues::place_of_imposed(const ast::ImposedValue& imposed,
                                                       int unknown, int part, int component,
                                                       std::set<std::array<int, 3>>& before) {
  bool twice = false;
  const int end = component < 0 ? unknowns_.components_of(unknown) : component + 1;
  for (int c = std::max(component, 0); c < end; ++c)
    twice = !before.insert({unknown, part, c}).second || twice;
  if (twice) {
    mistakes_.error("E0416", imposed.span,
                    fmt::format("a value of `{}` is imposed twice on `{}`", imposed.unknown.text,
                                imposed.part.text));
    return nullptr;
  }
  solver::DirichletSpec* found = imposed_entry(unknown, part, component);
  if (found != nullptr) return found;
  mistakes_.error(
      "E0416", imposed.span,
      fmt::format("the space is not zero on `{}`{}", imposed.part.text,
                  component >= 0 ? fmt::format(" in component `{}`", imposed.component->text) : ""),
      fmt::format("add `, zero{} on {}` to the space",
                  component >= 0 ? "." + imposed.component->text : "", imposed.part.text) +
          ": values are imposed on a part where the space is zero, or inside one");
  return nullptr;
}

void ImposedValues::imposed_value(const ast::ImposedValue& imposed,
                                  std::set<std::array<int, 3>>& before) {
  const std::string& u = imposed.unknown.text;
  const int unknown = unknowns_.named(u);
  if (unknown < 0) {
    mistakes_.error(
        "E0301", imposed.unknown.span,
        fmt::format("values are imposed on the unknown {}, not on `{}`", unknowns_.names(), u));
    return;
  }
  auto part = parts_.index_of(imposed.part);
  Scope scope;
  scope.what = "an imposed value";
  scope.position = scope.time = true;
  auto value = evaluator_.field(imposed.value, scope);
  if (!part || !value || pairs_.refuse(*part, imposed.part.span, "an imposed value")) return;
  const auto component = imposed_component(imposed, unknown);
  if (!component || !has_shape_of(imposed, *value, unknown, *component)) return;
  if (!find_->time)
    for (const Symbol& c : value->components)
      if (c.depends_on(slot::t))
        mistakes_.error("E0412", imposed.value.span, "a static problem has no time `t`",
                        "add `for t in [0, T] by N steps from u = 0`");
  solver::DirichletSpec* found = place_of_imposed(imposed, unknown, *part, *component, before);
  if (found == nullptr) return;
  found->origin = model_.origin(imposed.span);
  if (found->component == -1 && *component >= 0) {
    // One component of a clamped part moves, the others stay zero.
    if (found->value.empty()) found->value.assign(unknowns_.components_of(unknown), Symbol(0.0));
    found->value[*component] = value->scalar();
  } else {
    found->value = value->components;
    if (value->rank == 0 && value->scalar().is(0.0)) found->value.clear();
  }
}

} // namespace hvi::lang
