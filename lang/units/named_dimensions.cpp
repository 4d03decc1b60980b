#include "lang/units/named_dimensions.hpp"

#include "solver/plan/problem.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::lang::units {

NamedDimensions::NamedDimensions(const std::vector<ast::Program>& programs,
                                 const ScriptUnits& units, const Model& model, Inference& inference)
    : of_form(inference.fresh()), model_(model), inference_(inference) {
  declare(programs);
  const auto unknowns = solver::unknowns_of(model.space);
  for (std::size_t b = 0; find != nullptr && b < find->unknowns.size(); ++b) {
    const auto& declared = find->unknowns[b].unit;
    const auto unit = declared ? units.read.find(declared->text) : units.read.end();
    // A vector is a displacement unless the script says otherwise; of a scalar its forms tell.
    const bool displacement = b < unknowns.size() && unknowns[b].vector;
    of_unknown.push_back(unit != units.read.end() ? unit->second.dimension
                         : displacement           ? length()
                                                  : inference.fresh());
    of_test.push_back(inference.fresh());
  }
}

void NamedDimensions::declare(const std::vector<ast::Program>& programs) {
  for (const ast::Program& program : programs)
    for (const ast::Statement& statement : program.statements) {
      if (const auto* f = std::get_if<ast::Find>(&statement)) find = f;
      const std::string name = std::visit(
          [](const auto& s) -> std::string {
            if constexpr (requires { s.name.text; })
              return s.name.text;
            else
              return {};
          },
          statement);
      if (name.empty()) continue;
      const auto [known, fresh] =
          declarations.try_emplace(name, MeasuredDeclaration{&statement, program.library});
      if (!fresh && known->second.library && !program.library)
        known->second = MeasuredDeclaration{&statement, false}; // the script's own names win
    }
}

MeasuredDeclaration* NamedDimensions::declaration(const std::string& name) {
  const auto found = declarations.find(name);
  return found == declarations.end() ? nullptr : &found->second;
}

std::optional<std::size_t> NamedDimensions::unknown(const std::string& name) const {
  for (std::size_t b = 0; find != nullptr && b < find->unknowns.size(); ++b)
    if (find->unknowns[b].unknown.text == name) return b;
  return std::nullopt;
}

std::size_t NamedDimensions::vector_unknown() const {
  std::size_t b = 0;
  const auto unknowns = solver::unknowns_of(model_.space);
  while (b + 1 < unknowns.size() && !unknowns[b].vector) ++b;
  return b;
}

namespace {

/// Points on the axis of a body of revolution are points; those away from it stand for circles.
/// Groups of a mesh file are taken for the latter.
bool is_on_axis(const solver::RegionSpec& region) {
  using Kind = solver::RegionSpec::Kind;
  constexpr double rounding = 1e-10;
  if (region.kind == Kind::point)
    return std::abs(region.point[0]) <= rounding * std::abs(region.point[1]);
  return !region.children.empty() && std::ranges::all_of(region.children, is_on_axis);
}

} // namespace

/// In 2D volumes are areas, so that forces are for one unit of thickness; circles of an
/// axisymmetric mesh count as the length that they are.
Dimension NamedDimensions::measure_of(const std::string& part) {
  const int around = model_.mesh.axisymmetric ? 1 : 0;
  const int dim = model_.dim + around;
  if (part.empty()) return length().to(dim);
  using Kind = solver::Group::Kind;
  for (const ModelPart& known : model_.parts) {
    if (known.name != part || !known.kind) continue;
    return length().to(*known.kind == Kind::cells    ? dim
                       : *known.kind == Kind::facets ? dim - 1
                       : is_on_axis(known.region)    ? 0
                                                     : around);
  }
  if (declared_as<ast::Mesh>(part)) return length().to(dim);
  return of_measure_.try_emplace(part, inference_.fresh()).first->second;
}

/// sqrt(int eps(u) : eps(u) dx)
std::optional<Dimension> NamedDimensions::norm_of_space(std::size_t unknown) {
  const solver::SpaceSpec& space = model_.space;
  const bool held = std::ranges::any_of(space.dirichlet, [&](const solver::DirichletSpec& one) {
    return static_cast<std::size_t>(one.unknown) == unknown;
  });
  if (!held && !solver::unknowns_of(space)[unknown].vector) return std::nullopt;
  return of_unknown[unknown] / length() * measure_of({}).to(Rational(1, 2));
}

/// Every integral over the unknown's test function.
Dimension NamedDimensions::force(std::size_t unknown) const { return of_form / of_test[unknown]; }

/// Force over v is sigma : eps(v) over the cells.
std::optional<Dimension> NamedDimensions::stress() {
  if (of_unknown.empty()) return std::nullopt;
  return force(vector_unknown()) * length() / measure_of({});
}

Dimension NamedDimensions::multiplier(const std::string& law) {
  return of_multiplier.try_emplace(law, inference_.fresh()).first->second;
}

Dimension NamedDimensions::state(const std::string& name) {
  return of_state.try_emplace(name, inference_.fresh()).first->second;
}

std::optional<Dimension> NamedDimensions::column(const std::string& name) const {
  auto found = of_column.find(name);
  const bool component =
      name.size() > 2 && name[name.size() - 2] == '_' && name.back() >= 'x' && name.back() <= 'z';
  if (found == of_column.end() && component)
    found = of_column.find(name.substr(0, name.size() - 2));
  return found == of_column.end() ? std::nullopt : std::optional(found->second);
}

} // namespace hvi::lang::units
