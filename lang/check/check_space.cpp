// The space, imposed values, the time grid and the initial state of a find statement.
#include "lang/check/builtins.hpp"
#include "lang/check/checker.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

constexpr int most_steps = 20'000'000;

std::optional<int> component_index(const ast::Name& name, int dim) {
  if (name.text.size() != 1) return std::nullopt;
  const int i = name.text[0] - 'x';
  return i >= 0 && i < dim ? std::optional(i) : std::nullopt;
}

} // namespace

std::optional<solver::DirichletSpec> Checker::zero_condition(const ast::ZeroCondition& zero,
                                                             bool vector) {
  solver::DirichletSpec d;
  d.origin = model_.origin(zero.span);
  auto part = part_index(zero.part);
  bool good = part && !refuse_pair(*part, zero.part.span, "a zero value");
  d.part = part.value_or(0);
  if (part && !zero.component &&
      model_.parts[*part].region.kind == solver::RegionSpec::Kind::all_cells) {
    error("E0423", zero.part.span, "zero on the whole mesh: nothing is left to solve for",
          "the space is zero on a part of the boundary");
    good = false;
  }
  const auto component = component_of_space(zero.component, vector);
  d.component = component.value_or(0);
  return good && component ? std::optional(std::move(d)) : std::nullopt;
}

/// -1: all components. Nothing where there is no such component (reported).
std::optional<int> Checker::component_of_space(const std::optional<ast::Name>& written,
                                               bool vector) {
  if (!written) return -1;
  const auto c = vector ? component_index(*written, model_.dim) : std::nullopt;
  if (!c)
    error("E0315", written->span,
          vector ? fmt::format("there is no component `{}` in {}D", written->text, model_.dim)
                 : "a scalar space has no components",
          "components are x, y, z");
  return c;
}

std::optional<solver::PeriodicSpec>
Checker::periodic_condition(const ast::PeriodicCondition& periodic, bool vector) {
  solver::PeriodicSpec out;
  out.origin = model_.origin(periodic.span);
  const auto component = component_of_space(periodic.component, vector);
  bool good = component.has_value();
  out.component = component.value_or(-1);
  const auto side = [&](const ast::Name& written) {
    const auto part = part_index(written);
    good = good && part && !refuse_pair(*part, written.span, "a periodic condition");
    if (!good) return -1;
    const auto kind = model_.parts[static_cast<std::size_t>(*part)].kind;
    if (kind && *kind != solver::Group::Kind::facets) {
      error("E0306", written.span, fmt::format("`{}` is no part of the boundary", written.text),
            "values repeat from one side of the body to another: `periodic left = right`");
      good = false;
    }
    return *part;
  };
  out.first = side(periodic.first);
  out.second = side(periodic.second);
  if (good && out.first == out.second) {
    error("E0423", periodic.second.span,
          fmt::format("`{}` is on both sides of the sign", periodic.second.text),
          "write the part on the other side of the body: `periodic left = right`");
    good = false;
  }
  return good ? std::optional(out) : std::nullopt;
}

/// The mesh, a piece of it or a part of its cells.
bool Checker::space_domain(const ast::Name& written, int declaration, solver::SpaceSpec& spec) {
  const Value domain = value_of(declaration, written.span);
  if (is_poison(domain)) return false;
  const auto* mesh = std::get_if<MeshValue>(&domain);
  if (mesh != nullptr && mesh->index == 0) return true;
  const auto part = mesh != nullptr || std::holds_alternative<PartValue>(domain)
                        ? part_index(written)
                        : std::nullopt;
  const auto kind = part ? model_.parts[static_cast<std::size_t>(*part)].kind : std::nullopt;
  if (!part || (kind && *kind != solver::Group::Kind::cells)) {
    error("E0306", written.span,
          fmt::format("a space lives on a mesh, a piece of it or a part of its cells, not on {}",
                      describe(domain)));
    return false;
  }
  if (refuse_pair(*part, written.span, "a space")) return false;
  spec.domain = *part;
  return true;
}

/// Its index in spaces_.
std::optional<int> Checker::space(const ast::Space& s) {
  solver::SpaceSpec spec;
  spec.name = s.name.text;
  spec.origin = model_.origin(s.span);
  spec.vector = s.vector;
  ast::Expr element;
  element.span = s.element.span;
  element.node = ast::Reference{s.element.text};
  auto order = word(element, "element", {"P1", "P2"});
  spec.order = order && *order == "P2" ? 2 : 1;
  const int domain = find_declaration(s.domain.text);
  if (domain < 0) {
    Scope none;
    unknown_name(s.domain.span, s.domain.text, none);
    return std::nullopt;
  }
  bool good = order.has_value() && space_domain(s.domain, domain, spec);
  for (const ast::ZeroCondition& zero : s.zero) {
    auto d = zero_condition(zero, s.vector);
    good = good && d;
    if (d) spec.dirichlet.push_back(std::move(*d));
  }
  for (const ast::PeriodicCondition& periodic : s.periodic) {
    const auto p = periodic_condition(periodic, s.vector);
    good = good && p;
    if (p) spec.periodic.push_back(*p);
  }
  if (!good) return std::nullopt;
  spaces_.push_back(std::move(spec));
  return static_cast<int>(spaces_.size()) - 1;
}

/// Whether every point of `part` lies in `larger`, as far as the way they are written tells.
bool Checker::contains(const solver::RegionSpec& larger, const solver::RegionSpec& part) const {
  using Kind = solver::RegionSpec::Kind;
  const auto some = [&](const std::vector<solver::RegionSpec>& children) {
    return std::any_of(children.begin(), children.end(),
                       [&](const auto& child) { return contains(child, part); });
  };
  if (part.kind == Kind::unite)
    return contains(larger, part.children[0]) && contains(larger, part.children[1]);
  if (larger.kind == Kind::unite && some(larger.children)) return true;
  if (larger.kind == Kind::boundary) {
    const auto kind = kind_of(part);
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
solver::DirichletSpec* Checker::imposed_entry(int unknown, int part, int component) {
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

void Checker::imposed_values(const ast::Find& find) {
  std::set<std::array<int, 3>> before; // unknown, part and component
  for (const ast::ImposedValue& imposed : find.imposed) imposed_value(imposed, before);
}

/// Which component of the unknown, -1 for all; nothing (reported) where there is no such.
std::optional<int> Checker::imposed_component(const ast::ImposedValue& imposed, int unknown) {
  if (!imposed.component) return -1;
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  const auto c = vector ? component_index(*imposed.component, model_.dim) : std::nullopt;
  if (!c)
    error("E0315", imposed.component->span,
          fmt::format("`{}` has no component `{}`", imposed.unknown.text, imposed.component->text));
  return c;
}

/// A number or a vector, as the unknown or its component is (else reported)?
bool Checker::has_shape_of(const ast::ImposedValue& imposed, const Field& value, int unknown,
                           int component) {
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  const int wanted = component >= 0 ? 1 : components_of(unknown);
  const bool zero = value.rank == 0 && value.scalar().is(0.0);
  if (zero || (static_cast<int>(value.components.size()) == wanted && value.rank <= 1 &&
               (value.rank == 1) == (wanted > 1 || (component < 0 && vector))))
    return true;
  error("E0307", imposed.value.span,
        fmt::format("{} is imposed where {} is expected", describe(value),
                    wanted == 1 ? "a scalar" : fmt::format("a vector of {}", wanted)));
  return false;
}

/// E0416 where a value is imposed twice on a component, or where the space is not zero.
solver::DirichletSpec* Checker::place_of_imposed(const ast::ImposedValue& imposed, int unknown,
                                                 int part, int component,
                                                 std::set<std::array<int, 3>>& before) {
  bool twice = false;
  const int end = component < 0 ? components_of(unknown) : component + 1;
  for (int c = std::max(component, 0); c < end; ++c)
    twice = !before.insert({unknown, part, c}).second || twice;
  if (twice) {
    error("E0416", imposed.span,
          fmt::format("a value of `{}` is imposed twice on `{}`", imposed.unknown.text,
                      imposed.part.text));
    return nullptr;
  }
  solver::DirichletSpec* found = imposed_entry(unknown, part, component);
  if (found != nullptr) return found;
  error(
      "E0416", imposed.span,
      fmt::format("the space is not zero on `{}`{}", imposed.part.text,
                  component >= 0 ? fmt::format(" in component `{}`", imposed.component->text) : ""),
      fmt::format("add `, zero{} on {}` to the space",
                  component >= 0 ? "." + imposed.component->text : "", imposed.part.text) +
          ": values are imposed on a part where the space is zero, or inside one");
  return nullptr;
}

void Checker::imposed_value(const ast::ImposedValue& imposed,
                            std::set<std::array<int, 3>>& before) {
  const std::string& u = imposed.unknown.text;
  const int unknown = unknown_named(u);
  if (unknown < 0) {
    error("E0301", imposed.unknown.span,
          fmt::format("values are imposed on the unknown {}, not on `{}`", names_of_unknowns(), u));
    return;
  }
  auto part = part_index(imposed.part);
  Scope scope;
  scope.what = "an imposed value";
  scope.position = scope.time = true;
  auto value = field(imposed.value, scope);
  if (!part || !value || refuse_pair(*part, imposed.part.span, "an imposed value")) return;
  const auto component = imposed_component(imposed, unknown);
  if (!component || !has_shape_of(imposed, *value, unknown, *component)) return;
  if (!find_->time)
    for (const Symbol& c : value->components)
      if (c.depends_on(slot::t))
        error("E0412", imposed.value.span, "a static problem has no time `t`",
              "add `for t in [0, T] by N steps from u = 0`");
  solver::DirichletSpec* found = place_of_imposed(imposed, unknown, *part, *component, before);
  if (found == nullptr) return;
  found->origin = model_.origin(imposed.span);
  if (found->component == -1 && *component >= 0) {
    // One component of a clamped part moves, the others stay zero.
    if (found->value.empty()) found->value.assign(components_of(unknown), Symbol(0.0));
    found->value[*component] = value->scalar();
  } else {
    found->value = value->components;
    if (value->rank == 0 && value->scalar().is(0.0)) found->value.clear();
  }
}

void Checker::time_grid(const ast::TimeClause& clause) {
  auto range = constant_list(clause.range, "the time interval");
  if (!range) return;
  if (range->size() != 2 || !((*range)[0] < (*range)[1])) {
    error("E0426", clause.range.span, "the time interval is `[t0, T]` with t0 < T");
    return;
  }
  const double t0 = (*range)[0], t1 = (*range)[1];
  std::vector<double>& grid = model_.time.grid;
  if (clause.by_steps) {
    auto n = positive_integer(clause.steps, "the number of steps");
    if (!n) return;
    if (*n > most_steps) {
      error("E0607", clause.steps.span, fmt::format("more than {} steps", most_steps));
      return;
    }
    grid.resize(*n + 1);
    for (int i = 0; i <= *n; ++i) grid[i] = t0 + (t1 - t0) * i / *n;
    return;
  }
  // Listed times, or `graded(N, power)`: t0 + (T - t0) (i/N)^power.
  const auto* call = std::get_if<ast::Call>(&clause.steps.node);
  const auto* callee = call ? std::get_if<ast::Reference>(&call->callee->node) : nullptr;
  if (callee && callee->name == "graded") {
    auto args = match(clause.steps, *call, "graded", {"steps", "power"}, 2);
    if (!args) return;
    auto n = positive_integer(*(*args)[0], "the number of steps");
    auto power = constant(*(*args)[1], "the grading power");
    if (!n || !power) return;
    if (*power < 1.0 || *n > most_steps) {
      error("E0408", (*args)[1]->span, "the grading power is at least 1");
      return;
    }
    grid.resize(*n + 1);
    for (int i = 0; i <= *n; ++i) grid[i] = t0 + (t1 - t0) * std::pow(double(i) / *n, *power);
    grid.back() = t1;
    return;
  }
  auto times = constant_list(clause.steps, "the times");
  if (!times) return;
  grid = {t0};
  for (std::size_t i = 0; i < times->size(); ++i) {
    const double t = (*times)[i];
    if (i == 0 && t == t0) continue;
    if (!(grid.back() < t) || t > t1) {
      error("E0426", item_span(clause.steps, i),
            fmt::format("times increase within [{}, {}]; {} does not", t0, t1, t));
      grid.clear();
      return;
    }
    grid.push_back(t);
  }
  if (grid.back() < t1) grid.push_back(t1);
}

void Checker::time_clause(const ast::Find& find) {
  model_.has_time = find.time.has_value();
  model_.time.is_static = !find.time;
  if (!find.time) return;
  model_.time.origin = model_.origin(find.time->span);
  time_grid(*find.time);
  initial_state(find);
  check_static_start(find);
}

/// `u = static`, where nothing of the script has that name.
bool Checker::is_static_start(const ast::InitialValue& initial) const {
  const auto* name = std::get_if<ast::Reference>(&initial.value.node);
  return name && name->name == "static" && !initial.rate && find_declaration("static") < 0;
}

/// All unknowns together are in equilibrium.
void Checker::check_static_start(const ast::Find& find) {
  if (!model_.starts_at_rest) return;
  for (const ast::Unknown& u : find.unknowns) {
    const auto given = std::ranges::find_if(find.time->initial, [&](const auto& initial) {
      return initial.unknown.text == u.unknown.text && !initial.rate;
    });
    if (given != find.time->initial.end() && is_static_start(*given)) continue;
    error(
        "E0449", given == find.time->initial.end() ? find.time->initial.front().span : given->span,
        fmt::format("`{}` does not start in equilibrium, and another unknown does", u.unknown.text),
        fmt::format("write `{} = static`, or give all of them values", u.unknown.text));
    return;
  }
}

/// u(t0) and u'(t0) by component of all unknowns; what is not given is 0.
void Checker::initial_state(const ast::Find& find) {
  if (!spaces_known_) return;
  std::vector<Symbol> none;
  for (std::size_t b = 0; b < find.unknowns.size(); ++b)
    none.insert(none.end(), components_of(static_cast<int>(b)), Symbol(0.0));
  std::map<std::pair<int, bool>, const ast::InitialValue*> given;
  for (const ast::InitialValue& initial : find.time->initial) {
    const int unknown = unknown_named(initial.unknown.text);
    if (unknown < 0) {
      error("E0301", initial.unknown.span,
            fmt::format("the initial {} is of the unknown {}, not of `{}`",
                        initial.rate ? "velocity" : "state", names_of_unknowns(),
                        initial.unknown.text));
      continue;
    }
    if (!given.try_emplace({unknown, initial.rate}, &initial).second) {
      error("E0302", initial.span,
            fmt::format("the initial {} of `{}` is given twice",
                        initial.rate ? "velocity" : "state", initial.unknown.text));
      continue;
    }
    if (is_static_start(initial)) {
      model_.starts_at_rest = true;
      continue;
    }
    const auto value = initial_value(initial, unknown);
    if (!value) continue;
    (initial.rate ? model_.time.velocity_origin : model_.time.origin) = model_.origin(initial.span);
    if (initial.rate && !model_.time.velocity) model_.time.velocity = none;
    if (value->empty()) continue;
    auto& all = initial.rate ? *model_.time.velocity : model_.time.initial;
    if (all.empty()) all = none;
    int first = 0;
    for (int b = 0; b < unknown; ++b) first += components_of(b);
    std::ranges::copy(*value, all.begin() + first);
  }
}

/// By component; empty: 0. Nothing where it is wrong (reported).
std::optional<std::vector<Symbol>> Checker::initial_value(const ast::InitialValue& initial,
                                                          int unknown) {
  const std::string what = initial.rate ? "initial velocity" : "initial state";
  Scope scope;
  scope.what = "an " + what;
  scope.position = true;
  auto value = field(initial.value, scope);
  if (!value) return std::nullopt;
  const int n = components_of(unknown);
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  if (value->rank == 0 && value->scalar().is(0.0)) return std::vector<Symbol>{};
  if ((value->rank == 1) != vector || static_cast<int>(value->components.size()) != n ||
      value->rank > 1) {
    error("E0307", initial.value.span,
          fmt::format("the {} is {}, the unknown {}", what, describe(*value),
                      vector ? fmt::format("a vector of {}", n) : "a scalar"));
    return std::nullopt;
  }
  return value->components;
}

} // namespace hvi::lang
