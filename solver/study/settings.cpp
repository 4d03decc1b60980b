// Plans of a family of settings; see settings.hpp.
#include "solver/study/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

int dimension(const MeshSpec& mesh) {
  switch (mesh.kind) {
  case MeshSpec::Kind::interval:
    return 1;
  case MeshSpec::Kind::box:
    return 3;
  default:
    return 2; // of bisected meshes only the exponent of the cost depends on it
  }
}

/// Each interval of the lines cut into `parts` equal ones.
std::vector<double> subdivided(const std::vector<double>& lines, int parts) {
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i)
    for (int k = 0; k < parts; ++k) out.push_back(lines[i] + (lines[i + 1] - lines[i]) * k / parts);
  out.push_back(lines.back());
  return out;
}

/// Every second line.
std::vector<double> halved(const std::vector<double>& lines) {
  std::vector<double> out;
  for (std::size_t i = 0; i < lines.size(); i += 2) out.push_back(lines[i]);
  return out;
}

int cells_along(const MeshSpec& mesh, int axis) {
  const auto& lines = mesh.grading[axis];
  return lines.empty() ? mesh.cells[axis] : static_cast<int>(lines.size()) - 1;
}

/// The power p with t_n = t_0 + T (n/N)^p, or 0.
double power_of(const std::vector<double>& grid) {
  const auto steps = static_cast<double>(grid.size() - 1);
  const double length = grid.back() - grid.front();
  const double p = steps > 1 ? std::log((grid[1] - grid[0]) / length) / std::log(1.0 / steps) : 1.0;
  for (std::size_t n = 0; n < grid.size(); ++n)
    if (std::abs(grid[n] - grid[0] - length * std::pow(static_cast<double>(n) / steps, p)) >
        1e-9 * length)
      return 0.0;
  return std::abs(p - 1.0) < 1e-6 ? 1.0 : p;
}

} // namespace

std::string to_string(const Setting& setting, const Plan& plan) {
  std::string mesh;
  const int dim = dimension(plan.mesh);
  if (plan.mesh.kind == MeshSpec::Kind::file || plan.mesh.kind == MeshSpec::Kind::geometry) {
    mesh = fmt::format("mesh refined {} times", plan.mesh.refinements);
  } else {
    for (int a = 0; a < dim; ++a)
      mesh += fmt::format("{}{}", a ? " x " : "", cells_along(plan.mesh, a));
    mesh += " cells";
  }
  std::string out = fmt::format("P{}, ", setting.order);
  if (plan.time.is_static) return out + mesh;
  return out + fmt::format("{}, {}, {} steps",
                           setting.scheme == Scheme::bdf2 ? "bdf2" : "backward Euler", mesh,
                           setting.steps);
}

SettingFamily::SettingFamily(const Plan& plan) : plan_(plan), dim_(dimension(plan.mesh)) {
  find_coarsest_mesh();
  find_coarsest_grid();
}

void SettingFamily::find_coarsest_mesh() {
  MeshSpec& mesh = plan_.mesh;
  bisected_ = mesh.kind == MeshSpec::Kind::file || mesh.kind == MeshSpec::Kind::geometry;
  if (bisected_) return;
  for (int a = 0; a < dim_; ++a) {
    auto& lines = mesh.grading[a];
    if (lines.empty())
      mesh.cells[a] <<= mesh.refinements;
    else
      lines = subdivided(lines, 1 << mesh.refinements);
  }
  mesh.refinements = 0;
  const int fewest = dim_ == 3 ? 2 : 4;
  const auto can_halve = [&] {
    for (int a = 0; a < dim_; ++a)
      if (cells_along(mesh, a) % 2 != 0 || cells_along(mesh, a) / 2 < fewest) return false;
    return true;
  };
  while (can_halve())
    for (int a = 0; a < dim_; ++a) {
      mesh.cells[a] /= 2;
      if (!mesh.grading[a].empty()) mesh.grading[a] = halved(mesh.grading[a]);
    }
}

void SettingFamily::find_coarsest_grid() {
  if (plan_.time.is_static) return;
  const int steps = static_cast<int>(plan_.time.grid.size()) - 1;
  power_ = power_of(plan_.time.grid);
  coarsest_steps_ = power_ > 0.0 ? 4 : steps;
  step_unit_ = power_ > 0.0 ? 2 : 2 * steps;
}

MeshSpec SettingFamily::mesh_at(int level) const {
  MeshSpec out = plan_.mesh;
  if (bisected_) {
    out.refinements += static_cast<int>(std::lround(std::log2(level)));
    return out;
  }
  for (int a = 0; a < dim_; ++a) {
    const double cells = static_cast<double>(out.cells[a]) * level;
    // Beyond this no mesh is made; the limit of the mesh module then names it.
    out.cells[a] = static_cast<int>(std::min(cells, 1e9));
    if (!out.grading[a].empty()) out.grading[a] = subdivided(out.grading[a], level);
  }
  return out;
}

std::vector<double> SettingFamily::grid_at(int steps) const {
  const auto& grid = plan_.time.grid;
  const int listed = static_cast<int>(grid.size()) - 1;
  if (power_ <= 0.0) return subdivided(grid, std::max(1, steps / listed));
  std::vector<double> out;
  for (int n = 0; n < steps; ++n) {
    const double part = static_cast<double>(n) / steps; // the same double for 2n of 2N
    out.push_back(grid.front() +
                  (grid.back() - grid.front()) * (power_ == 1.0 ? part : std::pow(part, power_)));
  }
  out.push_back(grid.back());
  return out;
}

Plan SettingFamily::at(const Setting& setting) const {
  Plan out = plan_;
  out.mesh = mesh_at(setting.level);
  out.space.order = setting.order;
  if (is_static()) return out;
  const double more =
      static_cast<double>(setting.steps) / static_cast<double>(plan_.time.grid.size() - 1);
  out.time.grid = grid_at(setting.steps);
  out.time.scheme = setting.scheme;
  const auto thinned = [&](int every) {
    return std::max(1, static_cast<int>(std::lround(every * more)));
  };
  for (auto& table : out.report.tables) table.every = thinned(table.every);
  for (auto& fields : out.report.fields) fields.every = thinned(fields.every);
  return out;
}

} // namespace hvi::solver
