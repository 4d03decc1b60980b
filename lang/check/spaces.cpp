#include "lang/check/spaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace hvi::lang {

namespace {

bool is_of_same_parts(const solver::DirichletSpec& a, const solver::DirichletSpec& b) {
  return a.part == b.part;
}

bool is_of_same_parts(const solver::PeriodicSpec& a, const solver::PeriodicSpec& b) {
  return std::minmax(a.first, a.second) == std::minmax(b.first, b.second);
}

/// The first one that says what this one says, of a component at least: `zero on p, zero.x on p`.
template <class Condition>
const Condition* said_before(const Condition& now, const std::vector<Condition>& before) {
  const auto found = std::ranges::find_if(before, [&](const Condition& one) {
    const bool both = one.component == now.component || one.component < 0 || now.component < 0;
    return both && is_of_same_parts(one, now);
  });
  return found == before.end() ? nullptr : &*found;
}

} // namespace

std::optional<int> component_index(const ast::Name& name, int dim) {
  if (name.text.size() != 1) return std::nullopt;
  const int i = name.text[0] - 'x';
  return i >= 0 && i < dim ? std::optional(i) : std::nullopt;
}

std::optional<solver::DirichletSpec> Spaces::zero_condition(const ast::ZeroCondition& zero,
                                                            bool vector) {
  solver::DirichletSpec d;
  d.origin = model_.origin(zero.span);
  auto part = parts_.index_of(zero.part);
  bool good = part && !pairs_.refuse(*part, zero.part.span, "a zero value");
  d.part = part.value_or(0);
  if (part && !zero.component &&
      model_.parts[*part].region.kind == solver::RegionSpec::Kind::all_cells) {
    mistakes_.error("E0423", zero.part.span, "zero on the whole mesh: nothing is left to solve for",
                    "the space is zero on a part of the boundary");
    good = false;
  }
  const auto component = component_of_space(zero.component, vector);
  d.component = component.value_or(0);
  return good && component ? std::optional(std::move(d)) : std::nullopt;
}

/// -1: all components. Nothing where there is no such component (reported).
std::optional<int> Spaces::component_of_space(const std::optional<ast::Name>& written,
                                              bool vector) {
  if (!written) return -1;
  const auto c = vector ? component_index(*written, model_.dim) : std::nullopt;
  if (!c)
    mistakes_.error(
        "E0315", written->span,
        vector ? fmt::format("there is no component `{}` in {}D", written->text, model_.dim)
               : "a scalar space has no components",
        vector
            ? fmt::format("components are {}", std::string("x, y, z").substr(0, 3 * model_.dim - 2))
            : "");
  return c;
}

std::optional<solver::PeriodicSpec>
Spaces::periodic_condition(const ast::PeriodicCondition& periodic, bool vector) {
  solver::PeriodicSpec out;
  out.origin = model_.origin(periodic.span);
  const auto component = component_of_space(periodic.component, vector);
  bool good = component.has_value();
  out.component = component.value_or(-1);
  const auto side = [&](const ast::Name& written) {
    const auto part = parts_.index_of(written);
    good = good && part && !pairs_.refuse(*part, written.span, "a periodic condition");
    if (!good) return -1;
    const auto kind = model_.parts[static_cast<std::size_t>(*part)].kind;
    if (kind && *kind != solver::Group::Kind::facets) {
      mistakes_.error(
          "E0306", written.span, fmt::format("`{}` is no part of the boundary", written.text),
          "values repeat from one side of the body to another: `periodic left = right`");
      good = false;
    }
    return *part;
  };
  out.first = side(periodic.first);
  out.second = side(periodic.second);
  if (good && out.first == out.second) {
    mistakes_.error("E0423", periodic.second.span,
                    fmt::format("`{}` is on both sides of the sign", periodic.second.text),
                    "write the part on the other side of the body: `periodic left = right`");
    good = false;
  }
  return good ? std::optional(out) : std::nullopt;
}

/// E0302 at the second one.
void Spaces::refuse_again(const char* what, solver::Origin now, solver::Origin before) {
  const auto place = [&](solver::Origin of) {
    return model_.origins[static_cast<std::size_t>(of.id)];
  };
  mistakes_.add(diagnose("E0302", place(now), fmt::format("{} is stated twice", what))
                    .with_secondary(place(before), "first stated here")
                    .with_help("without a component, as in `zero on part`, all are meant"));
}

/// The mesh, a piece of it or a part of its cells.
bool Spaces::space_domain(const ast::Name& written, int declaration, solver::SpaceSpec& spec) {
  const Value domain = evaluator_.value_of(declaration, written.span);
  if (is_poison(domain)) return false;
  const auto* mesh = std::get_if<MeshValue>(&domain);
  if (mesh != nullptr && mesh->index == 0) return true;
  const auto part = mesh != nullptr || std::holds_alternative<PartValue>(domain)
                        ? parts_.index_of(written)
                        : std::nullopt;
  const auto kind = part ? model_.parts[static_cast<std::size_t>(*part)].kind : std::nullopt;
  if (!part || (kind && *kind != solver::Group::Kind::cells)) {
    mistakes_.error(
        "E0306", written.span,
        fmt::format("a space lives on a mesh, a piece of it or a part of its cells, not on {}",
                    describe(domain)));
    return false;
  }
  if (pairs_.refuse(*part, written.span, "a space")) return false;
  spec.domain = *part;
  return true;
}

std::optional<int> Spaces::space(const ast::Space& s) {
  solver::SpaceSpec spec;
  spec.name = s.name.text;
  spec.origin = model_.origin(s.span);
  spec.vector = s.vector;
  ast::Expr element;
  element.span = s.element.span;
  element.node = ast::Reference{s.element.text};
  auto order = evaluator_.word(element, "element", {"P1", "P2"});
  spec.order = order && *order == "P2" ? 2 : 1;
  const int domain = names_.find(s.domain.text);
  if (domain < 0) {
    Scope none;
    names_.report_unknown(s.domain.span, s.domain.text, none);
    return std::nullopt;
  }
  bool good = order.has_value() && space_domain(s.domain, domain, spec);
  for (const ast::ZeroCondition& zero : s.zero) {
    auto d = zero_condition(zero, s.vector);
    good = good && d;
    if (const auto* before = d ? said_before(*d, spec.dirichlet) : nullptr) {
      refuse_again("this zero value", d->origin, before->origin);
      good = false;
    }
    if (d) spec.dirichlet.push_back(std::move(*d));
  }
  for (const ast::PeriodicCondition& periodic : s.periodic) {
    const auto p = periodic_condition(periodic, s.vector);
    good = good && p;
    if (const auto* before = p ? said_before(*p, spec.periodic) : nullptr) {
      refuse_again("this periodic condition", p->origin, before->origin);
      good = false;
    }
    if (p) spec.periodic.push_back(*p);
  }
  if (!good) return std::nullopt;
  declared_.push_back(std::move(spec));
  return static_cast<int>(declared_.size()) - 1;
}

/// The space of the problem: that of the unknown, or the product of those of all.
void Spaces::take_unknowns(const ast::Find& find) {
  unknowns_.known = true;
  solver::SpaceSpec product;
  for (std::size_t b = 0; b < find.unknowns.size(); ++b) {
    const ast::Unknown& written = find.unknowns[b];
    const int index = names_.find(written.space.text);
    if (index < 0) {
      Scope none;
      names_.report_unknown(written.space.span, written.space.text, none);
      unknowns_.known = false;
      continue;
    }
    Value value = evaluator_.value_of(index, written.space.span);
    const auto* space = std::get_if<SpaceValue>(&value);
    unknowns_.known = unknowns_.known && space != nullptr;
    if (space == nullptr) {
      if (!is_poison(value))
        mistakes_.error("E0306", written.space.span,
                        fmt::format("a space is expected here, not {}", describe(value)));
      continue;
    }
    solver::SpaceSpec one = declared_[static_cast<std::size_t>(space->index)];
    for (solver::DirichletSpec& d : one.dirichlet) d.unknown = static_cast<int>(b);
    for (solver::PeriodicSpec& p : one.periodic) p.unknown = static_cast<int>(b);
    one.unknown = written.unknown.text;
    if (b == 0) {
      product = std::move(one);
      continue;
    }
    product.more.push_back({one.unknown, one.name, one.origin, one.vector, one.order, one.domain});
    std::ranges::move(one.dirichlet, std::back_inserter(product.dirichlet));
    std::ranges::move(one.periodic, std::back_inserter(product.periodic));
  }
  if (unknowns_.known) model_.space = std::move(product);
}

} // namespace hvi::lang
