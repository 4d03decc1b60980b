// What is stated: mesh, parts, space, the terms of the inequality and time. How it is solved and
// what is asked of it stand in options.hpp and report.hpp.
//
// With u the unknown and v the test function (paper, eq. (111) and Problem P):
//
//   sum_forms  int_region  C(x, nu) D(field) . D(v)     field in { u, u', u'', w_m = int q_m u }
// + sum_laws   int_region  factor j^0( arg(u); arg'(v) )
// >= sum_loads int_region  F(x, t, nu) . D(v)
#pragma once

#include "solver/common/failure.hpp"
#include "solver/kernel/kernel_spec.hpp"
#include "solver/law/law.hpp"
#include "solver/mesh/mesh.hpp"
#include "solver/plan/tensor.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

/// ---- where -------------------------------------------------------------------------------------

/// How the mesh comes to be. `size` and `cells` as the kind needs them.
struct MeshSpec {
  enum class Kind { interval, rectangle, box, file, geometry, pieces };
  std::string name;
  Origin origin;
  Kind kind = Kind::rectangle;
  std::array<double, 3> low{0, 0, 0}, high{1, 1, 1};
  std::array<int, 3> cells{1, 1, 1};
  std::array<std::vector<double>, 3> grading; ///< explicit coordinates per axis, or empty
  bool crossed = false;                       ///< rectangle: both diagonals, four triangles a cell
  std::string path;                           ///< file: absolute, already checked to be allowed
  bool allow_geo = false;
  std::string geometry;        ///< geometry: a gmsh model of ours ("disk", "bracket"...)
  std::vector<double> numbers; ///< its numbers
  /// file: a .geo file, of which these constants have other values.
  std::vector<std::pair<std::string, double>> constants;
  int refinements = 0;       ///< uniform refinements after that
  bool axisymmetric = false; ///< x is r, y is z: Mesh::axisymmetric
  int adapted = 0; ///< then bisected to so many cells where an error indicator says; 0: not
  Point at{};      ///< file and geometry: then moved by this vector
  /// file: then cut along these groups, of which `crack` becomes `crack.first`, `crack.second`.
  std::vector<std::string> split;
  /// pieces: meshes side by side, which share no node. Group `top` of the piece `upper` is called
  /// `upper.top`, its boundary `upper.boundary`, its cells `upper`.
  std::vector<MeshSpec> pieces;
};

/// A part of the mesh as a small tree; resolved to entities by solver/mesh/region.hpp. A pair is
/// the root of its tree: the first side, whose integral and normal it has, and the second one. Laws
/// on it act on jumps: there a value of a field is that of the first side minus that of the second.
struct RegionSpec {
  enum class Kind { all_cells, boundary, group, point, unite, subtract, where, pair };
  Kind kind = Kind::all_cells;
  Origin origin;
  std::string name; ///< group (sides of generated meshes are groups); point: the piece meant, or ""
  Point point{};
  std::vector<RegionSpec> children; ///< unite, subtract, pair: two; where: one
  Expr predicate;                   ///< where: non-zero inside, of slot::x
  double reach = 0.0; ///< pair: partners are no farther; 0: the size of the first side
};

/// A named part; everything below refers to parts by index.
struct PartSpec {
  std::string name;
  Origin origin;
  RegionSpec region;
};

/// ---- space -------------------------------------------------------------------------------------

/// Zero or imposed values on a part. `component` -1: all components.
struct DirichletSpec {
  Origin origin;
  int part = 0;
  int component = -1;
  std::vector<Expr> value; ///< of slot::x and slot::t, one per imposed component; empty: zero
  int unknown = 0;
};

/// Values on one part are those at the same places of the other, which is the first one moved.
struct PeriodicSpec {
  Origin origin;
  int first = 0, second = 0; ///< parts of facets
  int component = -1;        ///< -1: all
  int unknown = 0;
};

/// An unknown of a problem with several, and its space.
struct UnknownSpec {
  std::string name;  ///< "theta"
  std::string space; ///< "W"
  Origin origin;
  bool vector = false; ///< dim components, or 1
  int order = 1;       ///< P1 or P2
  int domain = -1;     ///< the part of cells it lives on; -1: the whole mesh
};

struct SpaceSpec {
  std::string name;
  Origin origin;
  bool vector = true; ///< dim components, or 1
  int order = 1;      ///< P1 or P2
  std::vector<DirichletSpec> dirichlet;
  std::string unknown = "u";
  std::vector<UnknownSpec> more{}; ///< further unknowns: the space is a product
  int domain = -1;                 ///< as of UnknownSpec
  std::vector<PeriodicSpec> periodic{};
};

/// All of them, the first one too.
inline std::vector<UnknownSpec> unknowns_of(const SpaceSpec& space) {
  std::vector<UnknownSpec> out{
      {space.unknown, space.name, space.origin, space.vector, space.order, space.domain}};
  out.insert(out.end(), space.more.begin(), space.more.end());
  return out;
}
inline int components_of(const UnknownSpec& unknown, int dim) { return unknown.vector ? dim : 1; }
/// Of all unknowns together: values of functions of the product, one unknown behind the other.
inline int components_of(const SpaceSpec& space, int dim) {
  int out = 0;
  for (const UnknownSpec& unknown : unknowns_of(space)) out += components_of(unknown, dim);
  return out;
}

/// ---- forms -------------------------------------------------------------------------------------

enum class Rule { exact, nodal, midpoint, gauss };

/// Fields a form acts on, in the numbering of slot::field: u, its derivatives in time up to this
/// order, then the memories.
inline constexpr int highest_derivative = 2;
/// u (order 0), u' (order 1), u'' (order 2).
constexpr int field_of_u(int order) { return order; }
constexpr int field_of_memory(int m) { return highest_derivative + 1 + m; }
constexpr bool is_rate(int field) { return field > 0 && field <= highest_derivative; }
constexpr bool is_memory(int field) { return field > highest_derivative; }
constexpr int memory_of(int field) { return field - field_of_memory(0); }

/// What an effect is called in `plan` and `check`.
enum class Effect {
  inertia,
  viscosity,
  elasticity,
  memory,
  body_force,
  traction,
  normal_law,
  friction,
  other
};

/// int_part  sum_e coefficient_e(x, nu)  D_{trial_e}(field)  D_{test_e}(v);  D_i numbered as in
/// slot::value / slot::gradient.
struct FormTerm {
  struct Entry {
    int test = 0, trial = 0;
    Expr coefficient; ///< of slot::x, slot::normal
  };
  /// factor * C : eps(field) : eps(v), field and v of one unknown.
  struct Tensor {
    int index = 0; ///< into Problem::tensors
    Expr factor = 1.0;
    int unknown = 0;
  };
  Origin origin;
  int part = 0;
  int field = field_of_u(0);
  Rule rule = Rule::exact;
  Effect effect = Effect::other;
  std::vector<Entry> entries;
  std::optional<Tensor> tensor{}; ///< where it was written so, with all its entries
};

/// int_part  sum_e F_e(x, t, nu) D_{test_e}(v), on the right-hand side.
struct LoadTerm {
  struct Entry {
    int test = 0;
    Expr value; ///< of slot::x, slot::t, slot::normal; in Problem::state_loads of states, too
  };
  Origin origin;
  int part = 0;
  Rule rule = Rule::exact;
  Effect effect = Effect::body_force;
  std::vector<Entry> entries;
};

/// Memory field m: w_m(t) = int_0^t q_m(t, s) u(s) ds. Forms use it as field_of_memory(m).
struct HistoryTerm {
  Origin origin;
  KernelSpec kernel;
  std::optional<HistoryRoute> route{}; ///< instead of SolverOptions::route
};

/// So many times a field.
struct SeenField {
  int field = field_of_u(0);
  double times = 1.0;
  bool operator==(const SeenField&) const = default;
};

/// factor * int_part law^0( arg(w); arg'(v) ), w the field. Argument component c is
///   sum_i rows[c].u[i] D_i w + rows[c].offset,   coefficients of slot::x, slot::normal, offset
///   also of t, D_i w the components of one unknown and, inside a body, of its gradient
///   (slot::value, slot::gradient). Laws that see gradients have their points inside the cells.
/// One row: a scalar law. dim rows: a radial law of a vector; the engine reduces the rows to an
/// orthonormal basis of their range (2D u.tau: one row, 3D: two).
struct LawTerm {
  struct Row {
    std::array<Expr, slot::own_derivatives> u{}; ///< by derivative index
    Expr offset = 0.0;

    bool sees_gradient() const {
      return std::any_of(u.begin() + slot::gradient(0, 0), u.end(),
                         [](const Expr& of) { return !of.is(0.0); });
    }
  };
  Origin origin;
  std::string name; ///< of the law, for `layer.xi`
  int law = 0;      ///< index into Problem::laws
  int part = 0;
  int field = field_of_u(0); ///< what the law sees: u, u', or a memory
  int unknown = 0;           ///< of which unknown
  bool mean = false;         ///< on a pair: w is the mean of both sides, not the jump
  /// By row: the fields of which w is the sum, where that is more than `field` (one of them, not u)
  /// or another sum for each row. Empty: w is `field`.
  std::vector<std::vector<SeenField>> seen;
  Rule rule = Rule::nodal;
  /// The unknown whose elements the rule is of, if not its own: what reads a law's multiplier has
  /// the points of that law.
  std::optional<int> rule_of;
  Effect effect = Effect::normal_law;
  Expr factor = 1.0;     ///< positive, of slot::x and slot::normal
  std::vector<Row> rows; ///< offsets: of states of the part, too

  bool sees_gradient() const {
    return std::any_of(rows.begin(), rows.end(), [](const Row& of) { return of.sees_gradient(); });
  }
};

/// ---- states --------------------------------------------------------------------------------

/// A state z at every point of the laws on a part: z' = rate, z(t0) = initial, kept in [low, high]
/// by projection: where the rate would take it out, it stays at the end.
///
/// Or, where it is `algebraic`, z = rate at every time: what a load reads of the solution. It lives
/// at points of its own or with the states inside the body, is read by Problem::state_loads alone,
/// and stands behind those with rates. Those of one part and name are entries of one quantity,
/// as the components of a stress, and have one size. Then a static problem has states, too.
struct StateTerm {
  Origin origin;
  std::string name;
  int part = 0;
  Expr rate;    ///< of slot::x, t, normal, states, values of u and u', multipliers of this part
  Expr initial; ///< of slot::x
  double low = -std::numeric_limits<double>::infinity(),
         high = std::numeric_limits<double>::infinity();
  /// Inside a body it lives where this rate needs it, if that is not its own one: in the start of a
  /// run, where states stand still, at the points of the run.
  std::optional<Expr> placed_by{};
  bool algebraic = false;
};

/// ---- time --------------------------------------------------------------------------------------

/// How a step advances (time_scheme.hpp); the last three are for problems with u''.
enum class Scheme { backward_euler, bdf2, newmark, hht, midpoint };
/// Of its error in the step for smooth solutions; `laws`: do any act? Those of `midpoint` are taken
/// at the end of a step.
constexpr int order_of(Scheme scheme, bool laws) {
  return scheme == Scheme::backward_euler || (scheme == Scheme::midpoint && laws) ? 1 : 2;
}
/// Memories take u to be affine on a step, else constant.
constexpr bool affine_on_steps(Scheme scheme) { return scheme != Scheme::backward_euler; }
constexpr bool needs_inertia(Scheme scheme) {
  return scheme != Scheme::backward_euler && scheme != Scheme::bdf2;
}
/// As scripts write it.
constexpr const char* name_of(Scheme scheme) {
  constexpr const char* names[] = {"backward_euler", "bdf2", "newmark", "hht", "midpoint"};
  return names[static_cast<int>(scheme)];
}
/// f(t_n), or the Rothe problem's mean over the step.
enum class LoadSampling { endpoint, average };

/// What stands between grid times: u_tau (affine) or bar u_tau (u_n on (t_{n-1}, t_n]).
enum class Interpolant { affine, constant };

inline constexpr double default_hht_alpha = -0.1;

/// What a run has found to begin with.
struct StartState {
  std::vector<double> u;  ///< of all degrees of freedom
  std::vector<int> terms; ///< the law terms whose multipliers are known,
  /// and these, term by term and point by point: a component for each row of the term where the law
  /// is radial.
  std::vector<double> xi;
};

struct TimeSpec {
  Origin origin;
  bool is_static = true;    ///< one step, no u', no memory
  std::vector<double> grid; ///< t_0 < t_1 < ... < t_N; empty when static
  Scheme scheme = Scheme::backward_euler;
  LoadSampling sampling = LoadSampling::endpoint;
  Interpolant interpolant = Interpolant::affine; ///< read by probes at times of their own
  std::vector<Expr> initial; ///< u(t0) by component of all unknowns, of slot::x; empty: 0
  std::shared_ptr<const StartState> start; ///< set by a run (Plan::start): instead of `initial`
  /// u'(t0), where there is u''. None: 0, and what imposed values say.
  std::optional<std::vector<Expr>> velocity;
  Origin velocity_origin;
  double hht_alpha = default_hht_alpha; ///< of Scheme::hht, from -1/3 to 0
};

/// ---- all of it ---------------------------------------------------------------------------------

/// An effect of the theory and what became of it.
struct EffectNote {
  enum class State { on, off, dropped, asleep };
  std::string name; ///< "viscosity", "normal law `layer` on `ground`"
  State state = State::on;
  Origin origin; ///< the line that declares or drops it
  std::string why;
};

struct Problem {
  std::string title;
  MeshSpec mesh;
  std::vector<PartSpec> parts;
  SpaceSpec space;
  std::vector<TensorSpec> tensors;
  std::vector<FormTerm> forms;
  std::vector<HistoryTerm> histories;
  std::vector<LawSpec> laws;
  std::vector<LawTerm> law_terms;
  std::vector<StateTerm> states;
  std::vector<LoadTerm> loads;
  /// Those that read states inside the body of their part, or algebraic ones.
  std::vector<LoadTerm> state_loads;
  TimeSpec time;
  std::vector<EffectNote> effects;
};

/// Those that read states, too.
inline std::vector<const LoadTerm*> all_loads(const Problem& problem) {
  std::vector<const LoadTerm*> out;
  for (const LoadTerm& load : problem.loads) out.push_back(&load);
  for (const LoadTerm& load : problem.state_loads) out.push_back(&load);
  return out;
}

/// Of state_loads: one that reads an algebraic state.
inline bool reads_solution(const Problem& problem, const LoadTerm& load) {
  return std::ranges::any_of(load.entries, [&](const LoadTerm::Entry& entry) {
    return std::ranges::any_of(entry.value.slots(), [&](Slot s) {
      return slot::is_state(s) &&
             problem.states[static_cast<std::size_t>(s - slot::first_state)].algebraic;
    });
  });
}

/// How fast row `row` moves with the increment of u, fields moving by these factors.
template <class Factors>
double factor_of_row(const LawTerm& term, std::size_t row, const Factors& of_field) {
  if (term.seen.empty()) return of_field(term.field);
  double sum = 0.0;
  for (const SeenField& seen : term.seen[row]) sum += seen.times * of_field(seen.field);
  return sum;
}

/// Of one unknown: with its derivatives and memories.
inline int count_fields(const Problem& problem) {
  return field_of_memory(static_cast<int>(problem.histories.size()));
}

/// Does a form act on u''?
inline bool in_motion(const Problem& problem) {
  for (const auto& form : problem.forms)
    if (form.field == field_of_u(2)) return true;
  return false;
}

} // namespace hvi::solver
