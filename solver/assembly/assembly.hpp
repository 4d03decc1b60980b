// From weak terms to matrices and vectors. All act on full vectors (free and eliminated dofs).
#pragma once

#include "solver/fem/pointwise.hpp"
#include "solver/fem/space.hpp"
#include "solver/linear/sparse.hpp"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace hvi::solver {

/// Which dofs a matrix has, and where: entry_of[dof], -1: not at all. Entries below n_rows have a
/// row and a column, those up to n_columns (imposed values) a column. Both follow the order of the
/// dofs. Without entries: all dofs, as they are numbered.
struct DofSelection {
  std::span<const std::int32_t> entry_of;
  int n_rows = 0, n_columns = 0;
};

/// K_ij = int_region sum_e C_e(x, nu) D_{trial_e}(phi_j) D_{test_e}(phi_i).
/// `exact` integrates polynomial coefficients exactly and others with a rule of degree
/// 2 (order + 1). All forms on cells have the pattern of space.graph, whatever their region; forms
/// on facets and points a part of it. A point region sums over its nodes with weight 1.
/// Throws Failure(bad_value) naming the point where a coefficient is not finite.
SparseMatrix assemble_form(const Space& space, const Region& region, const FormTerm& term,
                           const DofSelection& dofs = {});
/// Of the rule `exact` for a form; states count as constants.
int degree_of(const Space& space, const FormTerm& term);
/// Several forms on one region: they share the pattern and, where they can, the pass over the
/// cells. The matrices have the same bits as one by one.
std::vector<SparseMatrix> assemble_forms(const Space& space, const Region& region,
                                         std::span<const FormTerm* const> terms,
                                         const DofSelection& dofs = {});
/// into += alpha matrix; every entry of `matrix` must be in the pattern of `into` (which stays as
/// it is), else std::invalid_argument.
void add_scaled(SparseMatrix& into, double alpha, const SparseMatrix& matrix);

/// The right-hand side as f(t) = sum_m g_m(t) F_m + terms that do not separate.
class LoadAssembler {
public:
  LoadAssembler(const Space& space, std::span<const Region> parts, std::span<const LoadTerm> loads);
  ~LoadAssembler();
  LoadAssembler(LoadAssembler&&) noexcept;
  /// f(t) added to `out` (full vector). Throws Failure(bad_value) with point and time at NaN.
  void add(double t, Vector& out) const;
  /// The mean of f over [t0, t1], added to `out`: exact for polynomials in t of degree 7 between
  /// the knots: those of tables, and where a comparison, min, max, abs or sign of a t + b changes
  /// sides. Other changes of side in a factor g_m(t) are closed in on by halving.
  void add_mean(double t0, double t1, Vector& out) const;
  /// From now on vectors have an entry per dof of this list, in its order; what acts on the dofs of
  /// links acts on those they are one with.
  void restrict_to(std::span<const std::int32_t> dofs, std::span<const DofLink> links);
  /// Every F_m becomes map(F_m): loads stated in other unknowns. Only where all terms separate.
  void map(const std::function<Vector(const Vector&)>& map);
  bool separable() const; ///< nothing is assembled again at each step
  /// What the load declared at this place costs.
  enum class Cost { nothing, once, once_per_factor, every_step };
  Cost cost(Origin origin) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The quadrature points of one law term on full dofs. Points on the same node with the same
/// normal and the same rows are merged (weights added). Radial laws: rows reduced to an orthonormal
/// basis of their range, kept in `frames` (dim x rows each) to turn xi back into the global frame.
struct LawPoints {
  int law_term = 0;
  std::vector<Point> x;
  std::vector<Point> normal;
  std::vector<double> weight;      ///< quadrature weight times factor; positive
  std::vector<std::int32_t> node;  ///< nodal rule: the node, else -1
  std::vector<std::int32_t> facet; ///< an entity (facet or cell) the point lies on
  int rows = 1;
  std::vector<DenseMatrix> frames;            ///< radial laws only
  std::vector<std::vector<SeenField>> seen{}; ///< LawTerm::seen, of these rows
  SparseMatrix g;                             ///< (points * rows) x n_dofs
  /// (points * 6 n_unknowns) x n_dofs: values at the points, if asked for; see `traced`.
  SparseMatrix trace;
  bool offset_depends_on_t = false;
  // What the offsets are evaluated with.
  int dim = 2;
  std::vector<std::int32_t> cell;             ///< the cell behind `facet`, or itself
  std::vector<double> gap{};                  ///< on a pair, where u is the jump of u
  std::shared_ptr<const SparseMatrix> jump{}; ///< on a pair: Pairing::jump
  Group::Kind kind = Group::Kind::facets;
  std::shared_ptr<const PartIndicators> indicators;

  /// Which row of a point's in `trace` is that of a value (slot::value, slot::of_unknown), or on a
  /// pair of a mean (slot::mean).
  static constexpr int traced(int derivative) {
    return 6 * slot::unknown_of(derivative) + slot::component_of(derivative) +
           (slot::is_value(derivative) ? 0 : 3);
  }
};
/// Throws Failure(bad_value) when the factor is not positive or a row not finite, naming the point.
LawPoints assemble_law(const Space& space, const Region& region, const LawTerm& term, int law_term,
                       bool radial, bool with_trace = false);
/// Offsets of the argument rows at time t, points * rows. Throws Failure(bad_value) when one is not
/// finite, or (radial laws) not in the range of the rows: |R u + o| would not be |Q^T (R u + o)|.
/// `more`: the values of other slots at the points (states).
void law_offsets(const LawPoints& points, const LawTerm& term, double t, Vector& out,
                 const std::function<const double*(Slot)>& more = {});
/// The points as those of a region: for expressions of place, normal, time and parts.
PointBlock as_block(const LawPoints& points);

/// Gram matrices. V: eps : eps (vector) or grad . grad (scalar) of each unknown, plus the mass of
/// those that ask for it. Mass: u . v. Boundary mass of a part with a rule; with several unknowns
/// Trace::normal and tangential are of the first one.
SparseMatrix gram_v(const Space& space, std::span<const char> with_mass);
SparseMatrix gram_of_unknown(const Space& space, int unknown, bool with_mass);
SparseMatrix mass(const Space& space);
/// The integral of eps(u) : eps(u), or of |grad u|^2, on these cells of a body that is no body of
/// revolution. Exact, and several times as fast as an Integrator, which takes any expression.
double squares_of_strain(const Space& space, const SpaceBlock& block, const Region& cells,
                         const Vector& u);
/// int_region  (u . nu)(v . nu)  |  u_tau . v_tau  |  u . v; of jumps on a pair.
enum class Trace { normal, tangential, full };
SparseMatrix boundary_mass(const Space& space, const Region& region, Rule rule, Trace trace);

/// Values of fields at points, for probes and output. fields[k] is the full vector of field k
/// (slot::field numbering); absent fields may be empty.
struct FieldValues {
  std::span<const Vector* const> fields;
  double t = 0.0;
};
/// An expression at a point given by cell and barycentric coordinates: prepared once, evaluated at
/// many steps. The space must outlive it. Throws Failure(bad_value) when a field it needs is
/// absent.
class PointValue {
public:
  PointValue(const Space& space, const Expr& expression, int cell,
             const std::array<double, 4>& barycentric);
  ~PointValue();
  PointValue(PointValue&&) noexcept;
  double operator()(const FieldValues& values);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
/// Integral of an expression over a region (cells: fields and gradients of the cell; facets: of the
/// cell behind, with slot::normal). No multipliers. Prepared once, evaluated at many steps:
/// integrands affine in the fields with coefficients independent of t cost one sparse dot product.
/// The space must outlive it. Throws Failure(bad_value) when a field the integrand needs is absent.
class Integrator {
public:
  Integrator(const Space& space, const Region& region, Rule rule, std::vector<Expr> integrands);
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  void integrate(const FieldValues& values, std::span<double> out) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
/// The largest value of an expression on a region, or the least: of those at the nodes of each of
/// its entities, with the gradients of that cell (of the cell behind a facet). Those of P1 are
/// constant on it, those of P2 largest there. NaN where a value is.
enum class Extreme { largest, smallest };
double extreme_value(const Space& space, const Region& region, const Expr& expression,
                     const FieldValues& values, Extreme which);
/// Of these values.
double extreme_of(std::span<const double> values, Extreme which);
/// Cell averages (n_cells x components, component fastest) and nodal values of expressions;
/// a nodal value of an expression with gradients is the measure-weighted mean over its cells.
std::vector<double> cell_values(const Space& space, std::span<const Expr> components,
                                const FieldValues& values);
std::vector<double> nodal_values(const Space& space, std::span<const Expr> components,
                                 const FieldValues& values);

} // namespace hvi::solver
