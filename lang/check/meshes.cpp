#include "lang/check/meshes.hpp"

#include "lang/check/allowed_path.hpp"
#include "lang/check/mesh_findings.hpp"
#include "lang/diag/failures.hpp"
#include "lang/diag/suggest.hpp"
#include "lang/diag/unreadable.hpp"
#include "solver/common/joined.hpp"
#include "solver/common/read_file.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/gmsh_module.hpp"
#include "solver/mesh/read_msh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <utility>

namespace hvi::lang {

using solver::Group;
using solver::MeshSpec;

namespace {

/// Sides of the structured meshes by dimension.
std::vector<std::string> sides(int dim) {
  std::vector<std::string> all = {"left", "right", "bottom", "top", "back", "front"};
  all.resize(2 * dim);
  return all;
}

} // namespace

std::vector<std::string> mesh_arguments(const std::string& name) {
  if (name == "gmsh") return {"file", "refinements", "adapted", "at", "split", "axisymmetric"};
  std::vector<std::string> names;
  if (name == "interval") names = {"width", "cells", "origin", "grading"};
  if (name == "rectangle") names = {"width", "height", "cells", "origin", "grading", "pattern"};
  if (name == "box") names = {"width", "height", "depth", "cells", "origin", "grading"};
  for (const auto& geometry : solver::geometries())
    if (geometry.name == name) names = geometry.parameters;
  if (!names.empty()) names.insert(names.end(), {"at", "adapted", "axisymmetric"});
  return names;
}

void Meshes::report_second(const Span& span) {
  if (!names_.all_readable()) return; // what puts them together may be what cannot be read
  mistakes_.error(
      "E0427", span, fmt::format("a second mesh: the script has `{}` already", groups_.mesh_name),
      "a problem lives on one mesh; regions of it are parts, and several meshes are put together "
      "by `mesh both = upper + lower`");
}

Value Meshes::mesh(const ast::Mesh& m) {
  if (std::holds_alternative<ast::Binary>(m.value.node)) return mesh_of_pieces(m);
  const auto* call = std::get_if<ast::Call>(&m.value.node);
  const auto* callee = call ? std::get_if<ast::Reference>(&call->callee->node) : nullptr;
  if (!callee) {
    mistakes_.error("E0306", m.value.span, "a mesh is made by a call",
                    "`rectangle(2, 1, cells = [32, 16])`, `box(...)` or `gmsh(\"file.msh\")`");
    return Poison{};
  }
  if (!groups_.mesh_name.empty() && !making_pieces_) {
    report_second(m.name.span);
    return Poison{};
  }
  if (!making_pieces_) groups_.mesh_name = m.name.text;
  if (!mesh_of_call(m, *call, callee->name)) return Poison{};
  return MeshValue{making_pieces_ ? static_cast<int>(groups_.pieces.size()) + 1 : 0};
}

bool Meshes::mesh_of_call(const ast::Mesh& m, const ast::Call& call, const std::string& name) {
  if (name == "rectangle" || name == "box" || name == "interval")
    return structured_mesh(m, call, name);
  if (name == "gmsh") return file_mesh(m, call);
  const auto& known = solver::geometries();
  if (std::any_of(known.begin(), known.end(), [&](const auto& g) { return g.name == name; }))
    return geometry_mesh(m, call, name);
  std::vector<std::string> candidates = {"rectangle", "box", "interval", "gmsh"};
  for (const auto& g : known) candidates.push_back(g.name);
  const std::string near = did_you_mean(name, candidates);
  mistakes_.error("E0301", call.callee->span, fmt::format("there is no mesh `{}`", name),
                  near.empty() ? fmt::format("meshes: {}", solver::joined(candidates)) : near);
  return false;
}

/// A list of `dim` numbers, in 1D the number alone, too, where it is written. `wrong`: of a list of
/// another length.
bool Meshes::coordinates(const ast::Expr* written, int dim, const std::string& what,
                         const std::string& wrong, solver::Point& out) {
  if (!written) return true;
  if (dim == 1 && !std::holds_alternative<ast::List>(written->node)) {
    const auto number = evaluator_.constant(*written, what);
    out[0] = number.value_or(0.0);
    return number.has_value();
  }
  const auto list = evaluator_.constant_list(*written, what);
  if (list && static_cast<int>(list->size()) != dim) mistakes_.error("E0307", written->span, wrong);
  if (!list || static_cast<int>(list->size()) != dim) return false;
  std::copy(list->begin(), list->end(), out.begin());
  return true;
}

/// `at = [x, y]`, where it is written: the vector by which the mesh is moved.
bool Meshes::move_to(const ast::Expr* written, int dim, solver::Point& at) {
  return coordinates(written, dim, "the place of a mesh",
                     fmt::format("the place of a mesh has {} coordinates", dim), at);
}

/// `adapted = CELLS`, where it is written; 0: not adapted.
bool Meshes::adapted_cells(const ast::Expr* written, MeshSpec& spec) {
  if (!written) return true;
  const auto n = evaluator_.constant(*written, "the number of cells");
  if (n && !(*n >= 0 && *n == std::floor(*n))) {
    mistakes_.error("E0406", written->span,
                    fmt::format("the number of cells is a whole number, not {}", *n));
    return false;
  }
  if (n && *n > 5e7) {
    mistakes_.error("E0607", written->span, "more than 50 million elements");
    return false;
  }
  spec.adapted = static_cast<int>(n.value_or(0));
  return n.has_value();
}

/// `axisymmetric = true`, where it is written: for 2D.
bool Meshes::axisymmetric(const ast::Expr* written, int dim, MeshSpec& spec) {
  if (!written) return true;
  const auto yes = evaluator_.word(*written, "axisymmetric", {"true", "false"});
  if (!yes) return false;
  spec.axisymmetric = yes == "true" && dim == 2;
  if (yes == "false" || dim == 2) return true;
  mistakes_.error("E0442", written->span, fmt::format("a mesh in {}D is no section of a body", dim),
                  "`axisymmetric` is for meshes in 2D: the half of a section, x is r and y is z");
  return false;
}

/// From the sizes, `origin` and `at`: the box that the mesh fills.
bool Meshes::box_of_mesh(std::span<const ast::Expr* const> sizes, const ast::Expr* origin,
                         const ast::Expr* at, MeshSpec& spec) {
  const int dim = static_cast<int>(sizes.size());
  solver::Point moved{};
  bool good = coordinates(origin, dim, "the origin",
                          fmt::format("the origin has {} coordinates", dim), spec.low);
  good = move_to(at, dim, moved) && good;
  for (int a = 0; a < dim; ++a) {
    const auto size = evaluator_.constant(*sizes[a], "a length of the mesh");
    good = good && size;
    if (size && *size <= 0.0) {
      constexpr std::array names = {"width", "height", "depth"};
      mistakes_.error("E0408", sizes[a]->span,
                      fmt::format("the {} of a mesh is positive", names[a]));
      good = false;
    }
    spec.low[a] += moved[a];
    spec.high[a] = spec.low[a] + size.value_or(1.0);
  }
  if (!good || !spec.axisymmetric || spec.low[0] >= 0.0) return good;
  mistakes_.error("E0442", (origin ? origin : at)->span,
                  fmt::format("the mesh begins at x = {}", spec.low[0]),
                  "x is the distance from the axis, at least 0");
  return false;
}

/// `cells = n` of an interval or `cells = [n, m]`, and `pattern` in 2D.
bool Meshes::cells_of_mesh(const ast::Expr& cells, const ast::Expr* pattern, int dim,
                           MeshSpec& spec) {
  const auto* list = std::get_if<ast::List>(&cells.node);
  if (dim == 1 && !list) {
    const auto n = evaluator_.positive_integer(cells, "the number of cells");
    spec.cells[0] = n.value_or(1);
    return n.has_value();
  }
  if (!list || static_cast<int>(list->items.size()) != dim) {
    mistakes_.error("E0307", cells.span, fmt::format("`cells` is a list of {} numbers", dim));
    return false;
  }
  bool good = true;
  double total = 1.0;
  for (int a = 0; a < dim; ++a) {
    const auto n = evaluator_.positive_integer(list->items[a], "the number of cells");
    good = good && n;
    spec.cells[a] = n.value_or(1);
    total *= spec.cells[a];
  }
  if (pattern) {
    const auto chosen = evaluator_.word(*pattern, "pattern", {"diagonal", "crossed"});
    good = good && chosen;
    spec.crossed = chosen == "crossed";
  }
  if (total * (dim == 3 ? 6 : spec.crossed ? 4 : 2) <= 5e7) return good;
  mistakes_.error("E0607", cells.span, "more than 50 million elements");
  return false;
}

/// `grading`, where it is written: grid lines symmetric about the middle, denser towards both ends,
/// where the distance from an end is that power of the even one.
bool Meshes::grading_of_mesh(const ast::Expr* written, int dim, MeshSpec& spec) {
  solver::Point powers{1.0, 1.0, 1.0};
  if (!coordinates(written, dim, "the grading",
                   fmt::format("`grading` is a list of {} numbers", dim), powers))
    return false;
  for (int a = 0; a < dim; ++a) {
    const double p = powers[a], low = spec.low[a], length = spec.high[a] - low;
    if (!(p > 0.0)) {
      mistakes_.error("E0408", item_span(*written, static_cast<std::size_t>(a)),
                      "the grading of a mesh is positive");
      return false;
    }
    if (p == 1.0) continue;
    for (int i = 0; i <= spec.cells[a]; ++i) {
      const double s = double(i) / spec.cells[a];
      const double g = s <= 0.5 ? 0.5 * std::pow(2 * s, p) : 1.0 - 0.5 * std::pow(2 * (1 - s), p);
      spec.grading[a].push_back(low + length * g);
    }
    spec.grading[a].back() = spec.high[a];
  }
  return true;
}

bool Meshes::structured_mesh(const ast::Mesh& m, const ast::Call& call, const std::string& name) {
  const int dim = name == "interval" ? 1 : name == "rectangle" ? 2 : 3;
  const auto names = mesh_arguments(name);
  const auto args = evaluator_.match(m.value, call, name, names, dim + 1);
  if (!args) return false;
  const auto argument = [&](std::string_view wanted) -> const ast::Expr* {
    const auto at = std::ranges::find(names, wanted);
    return at == names.end() ? nullptr : (*args)[static_cast<std::size_t>(at - names.begin())];
  };
  MeshSpec spec;
  spec.name = m.name.text;
  spec.origin = model_.origin(m.value.span);
  spec.kind = dim == 1   ? MeshSpec::Kind::interval
              : dim == 2 ? MeshSpec::Kind::rectangle
                         : MeshSpec::Kind::box;
  bool good = axisymmetric(argument("axisymmetric"), dim, spec);
  good = box_of_mesh(std::span(*args).first(static_cast<std::size_t>(dim)), argument("origin"),
                     argument("at"), spec) &&
         good;
  good = cells_of_mesh(*argument("cells"), argument("pattern"), dim, spec) && good;
  good = grading_of_mesh(argument("grading"), dim, spec) && good;
  good = adapted_cells(argument("adapted"), spec) && good;
  if (!good) return false;
  model_.mesh = std::move(spec);
  model_.dim = dim;
  for (const std::string& side : sides(dim)) groups_.kinds[side] = Group::Kind::facets;
  groups_.known = true;
  return true;
}

namespace {

bool is_geometry(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".geo";
}

bool is_geometry_file(const ast::Call& call) {
  if (call.arguments.empty()) return false;
  const auto* path = std::get_if<ast::String>(&call.arguments.front().value.node);
  return path && is_geometry(path->text);
}

} // namespace

/// Of a geometry, `gmsh("plate.geo", r = 0.1)`: arguments with names of no other meaning are
/// constants of the file. They are taken out of the call.
bool Meshes::constants_of_geometry(ast::Call& call, const std::vector<std::string>& names,
                                   solver::GeoConstants& out) {
  bool good = true;
  std::erase_if(call.arguments, [&](const ast::Argument& argument) {
    if (!argument.name || std::ranges::find(names, argument.name->text) != names.end())
      return false;
    const std::string& name = argument.name->text;
    const auto value = evaluator_.constant(argument.value, fmt::format("the constant `{}`", name));
    if (std::ranges::find(out, name, &std::pair<std::string, double>::first) != out.end()) {
      mistakes_.error("E0305", argument.span,
                      fmt::format("the constant `{}` is given twice", name));
      good = false;
    }
    good = good && value;
    if (value) out.emplace_back(name, *value);
    return true;
  });
  return good;
}

bool Meshes::file_mesh(const ast::Mesh& m, const ast::Call& written) {
  const auto names = mesh_arguments("gmsh");
  ast::Call call = written;
  MeshSpec spec;
  if (is_geometry_file(call) && !constants_of_geometry(call, names, spec.constants)) return false;
  auto args = evaluator_.match(m.value, call, "gmsh", names, 1);
  if (!args) return false;
  const auto* path = std::get_if<ast::String>(&(*args)[0]->node);
  if (!path) {
    mistakes_.error("E0306", (*args)[0]->span, "`gmsh` takes a file: `gmsh(\"part.msh\")`");
    return false;
  }
  auto full = allowed_path(path->text, (*args)[0]->span, options_, mistakes_);
  if (!full) return false;
  spec.name = m.name.text;
  spec.origin = model_.origin((*args)[0]->span);
  spec.kind = MeshSpec::Kind::file;
  spec.path = *full;
  spec.allow_geo = options_.allow_geo;
  if ((*args)[1]) {
    auto n = evaluator_.constant(*(*args)[1], "the number of refinements");
    if (!n) return false;
    if (!(*n >= 0 && *n <= 20 && *n == std::floor(*n))) {
      mistakes_.error(
          "E0406", (*args)[1]->span,
          fmt::format("the number of refinements is a whole number from 0 to 20, not {}", *n));
      return false;
    }
    spec.refinements = static_cast<int>(*n);
  }
  if (!adapted_cells((*args)[2], spec)) return false;
  const bool geo = is_geometry(*full);
  if (geo && !options_.allow_geo) {
    mistakes_.error("E0606", (*args)[0]->span, "a `.geo` file can run programs and is not read",
                    "mesh it with gmsh, or " + options_.words.allow_geometry);
    return false;
  }
  try {
    solver::Straightening lost;
    const solver::Mesh mesh =
        geo ? solver::mesh_geo_file(*full, &lost, spec.constants) : solver::read_msh(*full, &lost);
    for (const auto& f : straightened_cells(mesh, lost))
      mistakes_.add(diagnose(f.code, (*args)[0]->span, f.message).with_help(f.help));
    model_.dim = mesh.dim;
    if (!move_to((*args)[3], mesh.dim, spec.at)) return false;
    if (!axisymmetric((*args)[5], mesh.dim, spec)) return false;
    for (const auto& [name, group] : mesh.groups) groups_.kinds[name] = group.kind;
    groups_.known = true;
    if (!split_along((*args)[4], spec)) return false;
  } catch (const solver::Failure& failure) {
    const bool missing = failure.kind == solver::FailureKind::missing_file;
    mistakes_.error(ending_of(failure.kind).code, (*args)[0]->span,
                    missing && !solver::read_file(*full) ? why_unreadable(*full, path->text)
                                                         : said_of_file(path->text, failure.what()),
                    missing && failure.help.empty() ? meant_file(options_.folder, path->text)
                                                    : failure.help);
    return false;
  }
  model_.mesh = spec;
  return true;
}

bool Meshes::geometry_mesh(const ast::Mesh& m, const ast::Call& call, const std::string& name) {
  const auto& known = solver::geometries();
  const auto& info =
      *std::find_if(known.begin(), known.end(), [&](const auto& g) { return g.name == name; });
  const auto names = mesh_arguments(name);
  auto args = evaluator_.match(m.value, call, name, names, 0);
  if (!args) return false;
  MeshSpec spec;
  spec.name = m.name.text;
  spec.origin = model_.origin(m.value.span);
  spec.kind = MeshSpec::Kind::geometry;
  spec.geometry = name;
  spec.numbers = info.defaults;
  bool good = adapted_cells((*args)[names.size() - 2], spec);
  good = move_to((*args)[names.size() - 3], info.dim, spec.at) && good;
  good = axisymmetric(args->back(), info.dim, spec) && good;
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    if (!(*args)[i]) continue;
    auto v = evaluator_.constant(*(*args)[i], info.parameters[i]);
    good = good && v;
    spec.numbers[i] = v.value_or(0.0);
    // A finer size that is left out is the size of all cells, which comes before it.
    if (info.parameters[i] == "size") spec.numbers.back() = spec.numbers[i];
  }
  if (!good) return false;
  model_.mesh = spec;
  model_.dim = info.dim;
  for (const std::string& group : info.groups) {
    const bool point =
        std::find(info.points.begin(), info.points.end(), group) != info.points.end();
    groups_.kinds[group] = group == "body" ? Group::Kind::cells
                           : point         ? Group::Kind::points
                                           : Group::Kind::facets;
  }
  groups_.known = true;
  return true;
}

} // namespace hvi::lang
