// The settings a problem can be solved at: element, scheme, mesh and steps, as changes of its plan.
// What `study` varies through parameters of the script, the search for an accuracy varies here.
#pragma once

#include "solver/plan/plan.hpp"
#include "solver/study/time_base.hpp"

#include <string>
#include <vector>

namespace hvi::solver {

/// Setting::grade of a mesh that is bisected where an error indicator says (MeshSpec::adapted).
inline constexpr double adaptive = 0.0;

/// `level`: how many times finer than the coarsest mesh the cells are along each axis.
struct Setting {
  int order = 1;
  Scheme scheme = Scheme::backward_euler;
  int level = 1, steps = 1;
  /// Lines of a structured mesh as distances to both its sides to this power; or `adaptive`.
  double grade = 1.0;
  int base = 0; ///< which of the family's bases of time
  friend auto operator<=>(const Setting&, const Setting&) = default;
};
/// The scheme's name as sentences have it.
inline const char* in_prose(Scheme scheme) {
  return scheme == Scheme::backward_euler ? "backward Euler" : name_of(scheme);
}

/// "P2, bdf2, 32 x 16 cells, 40 steps"; meshes from files: "refined 2 times".
std::string to_string(const Setting& setting, const Problem& problem);

/// The family of settings around a plan. Structured meshes are coarsened while all numbers of cells
/// are even, so that lines the data follow (kinks of a load, ends of parts) stay mesh lines, and
/// refined by whole factors of the coarsest; other meshes are refined uniformly. Pieces side by
/// side are coarsened and refined together. Adaptive ones have level^dim times the cells of level
/// 1, twice the coarsest mesh's. Uniform and power-graded time grids take any number of steps,
/// listed times whole fractions of their steps. Base 0 is the script's grid, or one that sees the
/// data; others can be added.
class SettingFamily {
public:
  explicit SettingFamily(const Plan& plan);

  /// The plan at a setting. Tables keep their rows: `every` grows with the steps.
  Plan at(const Setting& setting) const;
  bool is_static() const { return plan_.problem.time.is_static; }
  /// Orders of the first unknown's element that may be chosen. Of several unknowns in one order: of
  /// all of them; where they differ, or one is a pressure, elements stay as written.
  std::vector<int> orders() const;
  int first_order() const { return orders().front(); }
  /// Of the error in the norm of V at such an order: the least of all unknowns.
  int nominal_order(int order) const;
  /// Levels are powers of two only (a mesh that is bisected).
  bool bisected() const { return bisected_; }
  /// Does the script itself ask for an adapted mesh? Then all settings do.
  bool adapted() const { return plan_.problem.mesh.adapted > 0; }
  /// May a mesh be graded? A uniform structured one whose parts are named sides or everything:
  /// predicates and points rely on where the lines are.
  bool gradable() const { return gradable_; }
  int dim() const { return dim_; }
  /// Fewest steps on a base.
  int coarsest_steps(int base = 0) const { return bases_[base].coarsest; }
  /// Settings whose steps are multiples of this have the steps of half as many among theirs.
  int step_unit(int base = 0) const { return bases_[base].unit; }
  const Plan& plan() const { return plan_; }
  const TimeBase& base(int which) const { return bases_[which]; }
  /// Base 0 becomes one that sees the data; parts smaller than `negligible` are left out.
  void follow_data(double negligible);
  int add_base(TimeBase base);
  /// The intervals that a base's fewest steps have.
  std::vector<double> intervals(int base) const { return grid_at(bases_[base].coarsest, base); }

private:
  void find_coarsest_mesh();
  void find_coarsest_lines(const std::vector<MeshSpec*>& meshes);
  double first_cells(const MeshSpec& mesh) const;
  MeshSpec refined(const MeshSpec& mesh, int level, double grade) const;
  MeshSpec mesh_at(int level, double grade) const;
  std::vector<double> grid_at(int steps, int base) const;
  MeshSpec adapted_mesh_at(int level) const;

  Plan plan_; ///< with the coarsest mesh
  int dim_ = 2;
  double first_cells_ = 0.0; ///< of the coarsest mesh
  bool bisected_ = false, gradable_ = false;
  std::array<double, 3> grades_{1.0, 1.0, 1.0};             ///< of the script's own lines
  std::vector<TimeBase> bases_ = {TimeBase{{}, 1.0, 1, 1}}; ///< a static problem's has one step
};

} // namespace hvi::solver
