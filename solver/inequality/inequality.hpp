// The reduced inequality of one step: find c with
//
//     S c + sum_p w_p G_p^T xi_p = r,     xi_p in dj_p(z_p),   z_p = s_p G_p c + g_p        (*)
//
// S is the Schur complement on the contact unknowns, p runs over the quadrature points of all laws,
// G_p (of up to slot::most_arguments rows) takes the contact unknowns to the law's argument, g_p is
// what is known of it. s_p > 0 is 1 where c is what the law sees; where it sees a rate and c is an
// increment, it is about 1 / k. With rows s_p G_p and weights w_p / s_p that is the same problem
// with s = 1.
#pragma once

#include "solver/law/branch.hpp"
#include "solver/law/law.hpp"
#include "solver/linear/sparse.hpp"

#include <functional>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

class Factorisation;
class IterativeOperator;

/// The operator of the reduced problem: a dense Schur complement, or a sparse matrix when the
/// laws act in the whole domain. Symmetric unless `symmetric()` is false.
class ReducedOperator {
public:
  virtual ~ReducedOperator() = default;
  virtual int size() const = 0;
  virtual bool symmetric() const = 0;
  virtual void apply(const Vector& c, Vector& out) const = 0;
  /// out_i = sum_j |S_ij c_j|: the scale of rounding in (S c)_i.
  virtual void apply_magnitude(const Vector& c, Vector& out) const = 0;
  virtual Vector diagonal() const = 0;
  /// How stiff the body is at each unknown, about; 0: it is not.
  virtual Vector own_stiffness() const { return diagonal().cwiseAbs(); }
  virtual void column(int j, double* out) const = 0; ///< S e_j, size() doubles
  /// Factors S + H for a symmetric H = sum_p w_p G_p^T D_p G_p given as a sparse matrix with a
  /// pattern inside that of G^T G. `held`, in ascending order: unknowns with a row of H that is a
  /// diagonal entry beyond all of S; a factor for rough solves may leave them out. False when the
  /// result is not (positive definite and) regular.
  virtual bool factor(const SparseMatrix& h, std::span<const int> held) = 0;
  virtual void solve(const Vector& b, Vector& x) const = 0; ///< with the last factor
  /// Is the last factor a rounded one, so that `solve` refines what `solve_rough` gives?
  virtual bool rounded() const { return false; }
  /// The same to two or three digits, for sizes and estimates.
  virtual void estimate(const Vector& b, Vector& x) const { solve(b, x); }
  /// In place, S^-1 columns as well as that; false where S has no factor. The last factor may be
  /// another one then. `zero`: an H that is 0.
  virtual bool estimate_alone(const SparseMatrix& zero, DenseMatrix& columns);
  /// Is the last sum that was factored positive definite, as far as `factor` does not tell?
  virtual bool definite() { return true; }
  /// The part of the certificate's tolerance that solves aim at.
  virtual double aim() const { return 1e-2; }
  /// Set: linear systems are solved by iterations, to the accuracy that is asked for.
  virtual const IterativeOperator* iterative() const { return nullptr; }
  /// The same to about six digits: what preconditioners need, at half the memory read.
  virtual void solve_rough(const Vector& b, Vector& x) const { solve(b, x); }
  /// Many more rough solves with the last factor are to come: they may be prepared for.
  virtual void expect_rough_solves() {}
  /// In place, all columns at once.
  virtual void solve_rough(DenseMatrix& columns) const;
  /// The lower triangle of (S + H)^-1, or false where it cannot be had. Leaves the factor alone.
  virtual bool inverse(const SparseMatrix&, DenseMatrix&) const { return false; }
  /// The same operator, to be factored by LU: for an H that is not symmetric.
  virtual std::unique_ptr<ReducedOperator> unsymmetric() const = 0;
  /// Sign of the determinant of the last factor; 0 where it is not known.
  virtual int determinant_sign() const { return 0; }
  /// How many products and solves cost about as much as one factorisation.
  virtual int patience() const = 0;
  virtual double bytes() const = 0; ///< held
};
/// Reads S where the factor holds it.
std::unique_ptr<ReducedOperator> dense_operator(std::shared_ptr<const Factorisation> of,
                                                bool symmetric);
std::unique_ptr<ReducedOperator> dense_operator(DenseMatrix s, bool symmetric);
std::unique_ptr<ReducedOperator> sparse_operator(const SparseMatrix& k, bool symmetric);

/// One quadrature point of one law.
struct ContactPoint {
  int law = 0;         ///< index into ReducedProblem::laws
  int application = 0; ///< which term of the form (for reports)
  int first_row = 0;   ///< its rows of G: first_row .. first_row + rows
  int rows = 1;
  double weight = 0.0; ///< quadrature weight times the factor before the integral, > 0
  int graph = 0;       ///< index into ReducedProblem::graphs
};

/// A point whose law reads the multiplier of a scalar law at the same place: Coulomb's bound.
struct CoupledPoint {
  int point = 0, row = 0; ///< its law's multiplier is that in `row`
  Point x{};              ///< where both act
};

struct ReducedProblem {
  std::vector<const Law*> laws;
  std::vector<LawGraph> graphs; ///< shared by the points of a law that depends on neither x nor t
  std::vector<ContactPoint> points;
  SparseMatrix g; ///< rows of all points by contact unknowns
  Vector offset;  ///< known part of z, a row each: set before every step
  std::vector<CoupledPoint> coupled;
  /// What |offset| was before anything cancelled in it, a row each; empty: |offset|.
  Vector offset_size;
  /// By contact unknown: of which of several unknowns it is; empty: there is one.
  std::vector<std::uint8_t> of_unknown;
};

struct InequalityOptions {
  double tolerance = 1e-10; ///< of the certificate
  int max_iterations = 200;
  Branch branch = Branch::continuing;
  bool force_fallback = false; ///< tests: the globally convergent method only
  /// Called before every iteration of Newton's methods, and every solve for the compliance of the
  /// points; what it throws ends the search.
  std::function<void()> before_iteration{};
};

/// With `least_energy`: no other state has less energy by more than this part of the energies
/// involved, where the report says that this is proved.
inline constexpr double proved_least_gap = 1e-9;

/// What a solve did. `events` counts the downward jumps that points crossed, `reattached` those of
/// them that were crossed to the side with the larger multiplier: what was released holds again.
struct InequalityReport {
  bool converged = false;
  int iterations = 0, factorisations = 0;
  bool used_fallback = false;
  double inclusion = 0.0; ///< worst scaled distance of (z_p, xi_p) to the graph
  double residual = 0.0;  ///< componentwise backward error of the contact rows
  int worst_point = -1;
  int events = 0, reattached = 0;
  std::string verdict; ///< a sentence when not converged
  /// Steps along the equilibrium curve from the last state to this one (equilibrium_curve.hpp); 0:
  /// there was no need of them.
  int inner_steps = 0;
  /// Where branches ended on that way: 0 at the last state, 1 at this one.
  std::vector<double> branch_ends;
  /// `least_energy`: another state may have less energy than this one by at most this part of the
  /// energies involved (least_energy.hpp); infinite: nothing is known; negative: it was not asked.
  double least_gap = -1.0;
  /// Several solutions are possible, and whether this one continues the last state is not known.
  bool not_followed = false;
};

/// The state that is carried from step to step: warm start and multipliers.
struct InequalityState {
  Vector c;  ///< contact unknowns (of the equation above: total or increment)
  Vector xi; ///< multipliers, a row each
  /// Per point: 2 i for "inside piece i", 2 i + 1 for "at break i", -1 for the origin of a radial
  /// law.
  std::vector<int> state;
  /// Where the search begins when something better than (c, xi) is known; c still says where the
  /// path to the solution starts. Empty: at (c, xi).
  Vector c_guess, xi_guess;
  Vector s_c_guess; ///< S c_guess where the caller has it, else empty
  /// The arguments of the last state, to follow the branch from where several solutions are
  /// possible; empty: it is not followed.
  Vector z_before;
  /// The last state's multipliers and places, where `xi` and `state` are not those (a step that is
  /// solved again with other bounds).
  Vector xi_before;
  std::vector<int> state_before;
};

class InequalitySolver {
public:
  /// `factors`: s_p of every application (ContactPoint), slot::most_arguments each, by row of a
  /// point; empty: they are 1. Where the rows of a point have different ones, S has to be given as
  /// not symmetric: with s = diag(s_p), (*) has the forces of rows G and the arguments of rows s G.
  InequalitySolver(const ReducedProblem& problem, ReducedOperator& s, InequalityOptions options,
                   std::span<const double> factors = {});
  ~InequalitySolver();
  /// Solves (*) from the warm start in `state`; on return `state` holds the solution.
  InequalityReport solve(const Vector& r, InequalityState& state);
  /// The same with the bounds of coupled laws unknown, too: their graphs are those of the
  /// solution's own multipliers, whatever `problem.graphs` says. A solution need not exist, nor be
  /// the only one.
  InequalityReport solve_coupled(const Vector& r, InequalityState& state);
  /// Is S - sum_p w_p m_p G_p^T G_p positive definite, m_p the steepest descent of p's law? Then
  /// the problem has one solution for every r. For a symmetric S, and a dense one of up to 1,500
  /// unknowns: its factor may be rounded beyond. Forgets the last factor.
  bool convex();
  /// How the solution in `at_state` moves, to first order, when the right-hand side moves by each
  /// r: change_c and change_xi. Every point keeps its place on its graph. False when S + H has no
  /// factor there. Forgets the last factor.
  bool respond(const InequalityState& at_state, std::span<const Vector> r,
               std::vector<Vector>& change_c, std::vector<Vector>& change_xi);
  /// What one solve leaves to the next: a restored solver goes on with the same bits.
  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace hvi::solver
