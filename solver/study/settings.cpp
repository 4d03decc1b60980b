// Plans of a family of settings; see settings.hpp.
#include "solver/study/settings.hpp"

#include "solver/fem/region.hpp"
#include "solver/plan/couplings.hpp"

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

/// Lines denser towards both ends, as `grading` of the language makes them.
std::vector<double> graded(double low, double high, int cells, double power) {
  std::vector<double> out;
  for (int i = 0; i <= cells; ++i) {
    const double s = static_cast<double>(i) / cells;
    const double g =
        s <= 0.5 ? 0.5 * std::pow(2 * s, power) : 1.0 - 0.5 * std::pow(2 * (1 - s), power);
    out.push_back(low + (high - low) * g);
  }
  out.back() = high;
  return out;
}

/// The power of such lines, or 0.
double grade_of(const std::vector<double>& lines) {
  const int cells = static_cast<int>(lines.size()) - 1;
  const double length = lines.back() - lines.front();
  if (cells < 3) return 0.0;
  const double p = std::log(2 * (lines[1] - lines[0]) / length) / std::log(2.0 / cells);
  if (!(p > 0.0) || !std::isfinite(p)) return 0.0;
  const auto again = graded(lines.front(), lines.back(), cells, p);
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (std::abs(again[i] - lines[i]) > 1e-9 * length) return 0.0;
  return p;
}

/// A part that is the same entities whatever the lines of a mesh.
bool is_whole(const RegionSpec& region) {
  using K = RegionSpec::Kind;
  if (region.kind == K::where || region.kind == K::point) return false;
  return std::all_of(region.children.begin(), region.children.end(), is_whole);
}

bool is_uneven(const std::vector<double>& times) {
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (std::size_t n = 1; n < times.size(); ++n)
    if (std::abs(times[n] - times[n - 1] - step) > 1e-6 * step) return true;
  return false;
}

} // namespace

namespace {

bool is_made_elsewhere(const MeshSpec& mesh) {
  return mesh.kind == MeshSpec::Kind::file || mesh.kind == MeshSpec::Kind::geometry;
}

/// "16 x 8 cells"; of pieces: "16 x 8 and 12 x 6 cells".
std::string cells_of(const MeshSpec& mesh) {
  if (mesh.kind == MeshSpec::Kind::pieces) {
    std::string out;
    for (const MeshSpec& piece : mesh.pieces) out += (out.empty() ? "" : " and ") + cells_of(piece);
    return out;
  }
  if (is_made_elsewhere(mesh) || mesh.refinements > 0)
    return fmt::format("mesh refined {} times", mesh.refinements);
  std::string out;
  for (int a = 0; a < dimension(mesh); ++a)
    out += fmt::format("{}{}", a ? " x " : "", cells_along(mesh, a));
  return out + " cells";
}

/// "P2"; of several unknowns that differ: "P2 and P1".
std::string elements_of(const Setting& setting, const Problem& problem) {
  std::string out = fmt::format("P{}", setting.order);
  for (const UnknownSpec& unknown : problem.space.more)
    if (unknown.order != setting.order) out += fmt::format(" and P{}", unknown.order);
  return out;
}

} // namespace

std::string to_string(const Setting& setting, const Problem& problem) {
  std::string mesh = cells_of(problem.mesh);
  if (problem.mesh.adapted > 0)
    mesh = fmt::format("adapted to {} cells", problem.mesh.adapted);
  else if (setting.grade != 1.0)
    mesh += fmt::format(" graded {}", setting.grade);
  std::string out = elements_of(setting, problem) + ", ";
  if (problem.time.is_static) return out + mesh;
  return out + fmt::format("{}, {}, {}{} steps", in_prose(setting.scheme), mesh, setting.steps,
                           is_uneven(problem.time.grid) ? " uneven" : "");
}

SettingFamily::SettingFamily(const Plan& plan) : plan_(plan), dim_(dimension(plan.problem.mesh)) {
  find_coarsest_mesh();
  if (!plan_.problem.time.is_static) bases_ = {script_base(plan_.problem.time)};
}

void SettingFamily::follow_data(double negligible) {
  if (is_static()) return;
  bases_.front() = data_base(plan_.problem.time, data_times(plan_.problem, negligible));
}

int SettingFamily::add_base(TimeBase base) {
  bases_.push_back(std::move(base));
  return static_cast<int>(bases_.size()) - 1;
}

std::vector<int> SettingFamily::orders() const {
  const SpaceSpec& space = plan_.problem.space;
  const auto pressures = multipliers_of(plan_.problem);
  const bool alike = std::ranges::all_of(
      space.more, [&](const UnknownSpec& unknown) { return unknown.order == space.order; });
  const bool free =
      alike && (space.more.empty() || std::ranges::find(pressures, 1) == pressures.end());
  return free ? std::vector<int>{1, 2} : std::vector<int>{space.order};
}

int SettingFamily::nominal_order(int order) const {
  int out = order;
  const auto pressures = multipliers_of(plan_.problem);
  for (std::size_t b = 0; orders().size() == 1 && b < plan_.problem.space.more.size(); ++b)
    out = std::min(out, plan_.problem.space.more[b].order + (pressures[b + 1] != 0 ? 1 : 0));
  return out;
}

/// Numbers of cells, or lines, of structured meshes without their refinements, and the powers of
/// lines; halved together while all allow it.
void SettingFamily::find_coarsest_lines(const std::vector<MeshSpec*>& meshes) {
  const bool alone = meshes.front() == &plan_.problem.mesh;
  for (MeshSpec* mesh : meshes) {
    for (int a = 0; a < dim_; ++a) {
      auto& lines = mesh->grading[a];
      if (!lines.empty()) gradable_ = false;
      if (const double p = alone && !lines.empty() ? grade_of(lines) : 0.0; p > 0.0) {
        grades_[a] = p;
        mesh->cells[a] = static_cast<int>(lines.size()) - 1;
        mesh->low[a] = lines.front(), mesh->high[a] = lines.back();
        lines.clear();
      }
      if (lines.empty())
        mesh->cells[a] <<= mesh->refinements;
      else
        lines = subdivided(lines, 1 << mesh->refinements);
    }
    mesh->refinements = 0;
  }
  const int fewest = dim_ == 3 ? 2 : 4;
  const auto can_halve = [&](const MeshSpec* mesh) {
    for (int a = 0; a < dim_; ++a)
      if (cells_along(*mesh, a) % 2 != 0 || cells_along(*mesh, a) / 2 < fewest) return false;
    return true;
  };
  while (std::ranges::all_of(meshes, can_halve))
    for (MeshSpec* mesh : meshes)
      for (int a = 0; a < dim_; ++a) {
        mesh->cells[a] /= 2;
        if (!mesh->grading[a].empty()) mesh->grading[a] = halved(mesh->grading[a]);
      }
}

double SettingFamily::first_cells(const MeshSpec& mesh) const {
  double out = dim_ == 3 ? 6.0 : dim_ == 2 ? (mesh.crossed ? 4.0 : 2.0) : 1.0;
  for (int a = 0; a < dim_; ++a) out *= cells_along(mesh, a);
  return out;
}

void SettingFamily::find_coarsest_mesh() {
  MeshSpec& mesh = plan_.problem.mesh;
  std::vector<MeshSpec*> meshes{&mesh};
  if (mesh.kind == MeshSpec::Kind::pieces) {
    meshes.clear();
    for (MeshSpec& piece : mesh.pieces) meshes.push_back(&piece);
    dim_ = dimension(mesh.pieces.front());
  }
  bisected_ = std::ranges::any_of(meshes, [](const MeshSpec* m) { return is_made_elsewhere(*m); });
  if (bisected_) {
    const Mesh first = make_mesh(mesh);
    dim_ = first.dim;
    first_cells_ = static_cast<double>(first.cells.size());
    return;
  }
  gradable_ = dim_ > 1 && meshes.front() == &mesh &&
              std::all_of(plan_.problem.parts.begin(), plan_.problem.parts.end(),
                          [](const PartSpec& p) { return is_whole(p.region); });
  find_coarsest_lines(meshes);
  for (const MeshSpec* one : meshes) first_cells_ += first_cells(*one);
}

MeshSpec SettingFamily::adapted_mesh_at(int level) const {
  MeshSpec out = plan_.problem.mesh;
  for (int a = 0; a < dim_ && !bisected_ && out.pieces.empty(); ++a)
    if (grades_[a] != 1.0)
      out.grading[a] = graded(out.low[a], out.high[a], out.cells[a], grades_[a]);
  out.adapted = static_cast<int>(std::min(2.0 * first_cells_ * std::pow(level, dim_), 2e9));
  return out;
}

/// A mesh of one piece, or a piece.
MeshSpec SettingFamily::refined(const MeshSpec& mesh, int level, double grade) const {
  MeshSpec out = mesh;
  if (bisected_) {
    out.refinements += static_cast<int>(std::lround(std::log2(level)));
    return out;
  }
  for (int a = 0; a < dim_; ++a) {
    const double cells = static_cast<double>(out.cells[a]) * level;
    // Beyond this no mesh is made; the limit of the mesh module then names it.
    out.cells[a] = static_cast<int>(std::min(cells, 1e9));
    const double power = std::max(grade, grades_[a]);
    if (!out.grading[a].empty())
      out.grading[a] = subdivided(out.grading[a], level);
    else if (power != 1.0 && cells < 1e6)
      out.grading[a] = graded(out.low[a], out.high[a], out.cells[a], power);
  }
  return out;
}

MeshSpec SettingFamily::mesh_at(int level, double grade) const {
  if (grade == adaptive || adapted()) return adapted_mesh_at(level);
  MeshSpec out = plan_.problem.mesh;
  if (out.kind != MeshSpec::Kind::pieces) return refined(out, level, grade);
  for (MeshSpec& piece : out.pieces) piece = refined(piece, level, 1.0);
  return out;
}

std::vector<double> SettingFamily::grid_at(int steps, int base) const {
  const auto& grid = bases_[base].grid;
  const double power = bases_[base].power;
  const int listed = static_cast<int>(grid.size()) - 1;
  if (power <= 0.0) return subdivided(grid, std::max(1, steps / listed));
  std::vector<double> out;
  for (int n = 0; n < steps; ++n) {
    const double part = static_cast<double>(n) / steps; // the same double for 2n of 2N
    out.push_back(grid.front() +
                  (grid.back() - grid.front()) * (power == 1.0 ? part : std::pow(part, power)));
  }
  out.push_back(grid.back());
  return out;
}

Plan SettingFamily::at(const Setting& setting) const {
  Plan out = plan_;
  out.problem.mesh = mesh_at(setting.level, setting.grade);
  if (orders().size() > 1) {
    out.problem.space.order = setting.order;
    for (UnknownSpec& unknown : out.problem.space.more) unknown.order = setting.order;
  }
  if (is_static()) return out;
  const double more =
      static_cast<double>(setting.steps) / static_cast<double>(plan_.problem.time.grid.size() - 1);
  out.problem.time.grid = grid_at(setting.steps, setting.base);
  out.problem.time.scheme = setting.scheme;
  const auto thinned = [&](int every) {
    return std::max(1, static_cast<int>(std::lround(every * more)));
  };
  for (auto& table : out.report.tables) table.every = thinned(table.every);
  for (auto& fields : out.report.fields) fields.every = thinned(fields.every);
  return out;
}

} // namespace hvi::solver
