// Internals of the inequality solver, shared by its parts: the points' data, the linearised graph,
// the Newton loop (active_set.cpp), the fallback (fallback.cpp), releases (release.cpp) and the
// certificate (certificate.cpp).
#pragma once

#include "solver/inequality/equilibrium_curve.hpp"
#include "solver/inequality/inequality.hpp"
#include "solver/inequality/inverse.hpp"
#include "solver/inequality/prepared_law.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>

namespace hvi::solver {

using Small = std::array<double, 3>;

struct InequalityEngine {
  /// What is fixed about a point.
  struct PointData {
    int law = 0; ///< index into prepared
    int first = 0, rows = 1;
    double weight = 0.0;
    double local = 0.0;     ///< compliance of the body there with everything else held, per weight
    double gamma = 0.0;     ///< resolvent parameter, about the compliance of the body at the point
    bool single = false;    ///< each row touches at most one unknown
    bool exclusive = false; ///< and nothing else touches those unknowns
    double penalty = 0.0;   ///< stiffness (per weight) that holds a resting point at its break
  };
  /// Outcome of one of the two methods on fixed components.
  enum class Outcome { solved, failed, indefinite };

  InequalityEngine(const ReducedProblem& problem, ReducedOperator& s, InequalityOptions options);
  InequalityReport solve(const Vector& r, InequalityState& io);
  void solve_at_once(InequalityState& io);
  void solve_and_follow(InequalityState& io);
  void note_start(const InequalityState& io);

  // ---- set-up (inequality.cpp)
  std::string verdict(Outcome outcome) const;
  void prepare_points();
  void estimate_compliance();
  void prepare_pattern();
  void refresh_laws();
  void load(const InequalityState& from);
  void move_to_guess(const InequalityState& from);
  void store(InequalityState& to) const;

  // ---- points (points.cpp): vectors of up to 3 rows, graph states, products with G
  Small at(const Vector& v, int p) const;
  void put(Vector& v, int p, const Small& value) const;
  void update_z();               ///< z = G c + g
  void gather(const Vector& xi); ///< force = G^T W xi
  void gather_with_magnitude(const Vector& xi);
  void enter_state(int p);             ///< linearise about the given state near the current z
  void classify(int p, double shrink); ///< resolvent of z + gamma xi: new state, new linearisation
  double least_at_break(int p, int i) const;
  void linearise(int p, const GraphPoint& hit, const Small& direction);
  Small apply_d(int p, const Small& v) const;
  /// The multiplier that stands for certain at the current z: slopes inside, clipped xi at breaks.
  Small multiplier(int p) const;
  double snap(int p) const;
  void update_reach();
  void settle(int p);
  bool resting(int p) const;
  bool balance(int p);

  // ---- Newton on graph states (active_set.cpp)
  Outcome newton(int limit);
  Outcome newton_step();
  void assemble();
  bool factor_if_needed();
  bool solve_linear();
  double try_multipliers();
  void update_product();
  double worst_ratio() const;
  double target() const { return 1e-2 * options.tolerance; } ///< what Newton aims at
  double residual_ratio(const Vector& x); ///< of r - S c - G^T W x, componentwise, with S c known

  // ---- solves with the last factor (conjugate_gradients.cpp)
  /// An entry of Delta on the changed unknowns (conjugate_gradients.cpp).
  struct DeltaEntry {
    int row, column;
    double value;
    bool held; ///< the diagonal entry of a row that is held now
  };
  bool factor_is_close();
  bool add_far(int p);
  std::span<const int> held_unknowns();
  void solve_far_columns();
  bool prepare_far();
  void prepare_freed();
  void prepare_drift();
  void forget_far(); ///< the factor is another one
  void precondition(const Vector& r, Vector& out);
  bool conjugate_gradients();
  void accept_direction();
  void take_rest(int p);

  // ---- laws of straight pieces from a guess (inverse.cpp)
  void prepare_inverse();
  bool take_piece(int p, int at_state);
  bool make_inverse(const std::vector<int>& states);
  bool update_inverse(int p, int to_state);
  bool bring_inverse(const std::vector<int>& states);
  int follow_pieces();
  void multipliers_on_pieces();
  void measure_inverse(double solved);
  bool iterate_with_inverse();
  bool solve_with_inverse(InequalityState& io);

  // ---- globally convergent method (fallback.cpp)
  struct Penalised; ///< the augmented function of one outer step
  Outcome fallback();

  // ---- bounds that are other laws' multipliers (coupled.cpp, coupled_path.cpp)
  struct Coupled; ///< what one solve needs
  InequalityReport solve_coupled(const Vector& r, InequalityState& io);

  // ---- components (release.cpp)
  Outcome solve_components();
  Outcome solve_branch();
  int release_next(double window);
  void count_events(const std::vector<int>& before);
  void count_crossings(int p, int before);
  double energy() const;
  void start_from(const InequalityState& from);

  // ---- uniqueness (convexity.cpp)
  bool convex();

  // ---- how a solution moves (tangent.cpp)
  bool respond(const InequalityState& at_state, std::span<const Vector> r,
               std::vector<Vector>& change_c, std::vector<Vector>& change_xi);
  // ---- the branch that continues the last state (follow.cpp)
  /// A solution that the equilibrium curve found; c from S c = r - G^T W xi.
  struct CurveSolution {
    Vector c, z, xi;
    std::vector<int> places;
  };
  void prepare_following();
  bool may_have_left(const InequalityState& now) const;
  bool prepare_curve();
  Vector curve_start(const InequalityState& io) const;
  CurveSolution on_curve(const Vector& free) const;
  void follow(InequalityState& io);
  bool is_same(const Vector& on_the_curve, const InequalityState& now) const;
  bool settle_on(const CurveSolution& found, InequalityState& io);
  bool accept_found(InequalityState& io);

  // ---- the state of least energy (least_state.cpp)
  Vector forces_of(const InequalityState& now) const;
  Vector descend(const Vector& force, const Vector& free, InequalityState& found);
  void find_least_energy(const Vector& b, const Vector& free, InequalityState& io);
  void least_on_curve(const Vector& z0, const Vector& xi0, const Vector& b1, const Vector& free,
                      InequalityState& io);

  // ---- what one solve leaves to the next (saved_solver.cpp)
  void save(std::ostream& out) const;
  void restore(std::istream& in);
  void restore_inverse(std::istream& in);

  // ---- certificate (certificate.cpp)
  void certify();

  const ReducedProblem& problem;
  ReducedOperator& op;
  InequalityOptions options;
  int n = 0, n_rows = 0, n_points = 0;
  std::vector<PointData> points;
  std::vector<PreparedLaw> prepared;      ///< one per graph in use
  std::vector<int> prepared_of, graph_of; ///< graph to prepared (-1: unused) and back
  SparseMatrix force_of;                  ///< G^T W: unknowns by rows
  SparseMatrix h;                         ///< sum_p w_p G_p^T D_p G_p on a fixed pattern
  struct Contribution {
    int value, entry; ///< h.value[value] += coefficient * D_p[entry]
    double coefficient;
  };
  std::vector<Contribution> contributions;
  std::vector<int> first_contribution;

  // state of a solve
  const Vector* rhs = nullptr;
  Vector c, z, xi, sc, magnitude, force, force_magnitude, residual, row_size, dc, dz, trial, cg_r,
      cg_z, cg_p, cg_mp, cg_q, cg_kept, diagonal;
  SparseMatrix drift;              ///< what H has that the preconditioner does not know
  std::vector<int> freed, changed; ///< unknowns of points far from the factored stiffness
  std::vector<int> freed_before;   ///< those of far_y and freed_block
  std::vector<int> left_out;       ///< unknowns that the last factor holds (held_unknowns)
  std::vector<char> far_point;
  std::vector<DeltaEntry> delta;
  std::unordered_map<int, Vector> far_columns; ///< by unknown, of the last factor
  DenseMatrix far_y, far_z, far_y_q, freed_block;
  Eigen::LLT<DenseMatrix> freed_factor;
  Eigen::PartialPivLU<DenseMatrix> changed_factor;
  double block_unit = 1.0;
  int preconditioned = 0; ///< times since the factor was made
  /// A factor that has served so often serves on: the slopes change little.
  static constexpr int served_long = 16;
  int last_cg = 0; ///< iterations of the last conjugate gradients
  std::vector<int> state, states_before, component;
  std::vector<int> components_before, state_at_start; ///< of solve_components
  Vector c_at_start, xi_at_start;
  Vector far_t, far_x, far_pull, far_force, far_free; ///< of precondition
  Vector z_hat, xi_hat;                               ///< the graph points of the linearisation
  std::vector<std::array<double, 9>> d;               ///< their stiffnesses, row by row
  std::vector<std::array<double, 9>> d_factored;
  bool factored = false;
  bool idle = false;   ///< no law acts at the start: the first solve is that of the linear problem
  Vector c_of_product; ///< sc = S c_of_product
  Vector s_dc;         ///< S dc, where conjugate gradients found dc
  bool have_s_dc = false;
  bool settled = false;        ///< no point changed its place in the last step of Newton's
  bool have_magnitude = false; ///< magnitude belongs to it
  KeptInverse kept;
  /// A law's slope against the body's stiffness from which rounding of z shows in xi.
  static constexpr double far_stiffer = 1e4;
  /// z within this part of its size of a break counts as on it; Newton aims closer at first.
  static constexpr double tight_snap = 2e-14, certificate_snap = 1e-12;
  double snap_factor = certificate_snap;
  Vector reach;   ///< by unknown: a displacement, the scale of its rounding (update_reach)
  Vector z_start; ///< where the path to the present solution began

  // the branch that continues the last state
  bool may_soften = false;  ///< some law has a slope that falls
  bool newton_only = false; ///< the globally convergent method waits until the curve was asked
  std::optional<bool> known_convex;
  InequalityState followed_from; ///< where the step began
  std::vector<int> state_before;
  Vector xi_before;
  std::vector<CurveGraph> curve_graphs; ///< by prepared law
  std::optional<EquilibriumCurve> curve;
  DenseMatrix response; ///< S^-1 G^T
  InequalityReport report;
};

} // namespace hvi::solver
