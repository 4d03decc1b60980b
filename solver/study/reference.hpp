// What a study measures errors against: an exact solution, or the steps of a finer run.
#pragma once

#include "solver/time/run.hpp"

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace hvi::solver {

/// Errors of a run in the norm of V, || eps(u - u_ref) || (scalar unknowns: || grad(u - u_ref) ||),
/// and in L2: the largest over the steps and the last one; and how large u_ref is in V.
struct StudyError {
  double v_max = 0.0, v_final = 0.0, l2_max = 0.0, l2_final = 0.0, size = 0.0;
  double relative() const { return size > 0.0 ? v_max / size : v_max; }
};

/// What the norm of V is made of for one unknown: || eps(w) || (or || grad w ||), || w ||, or both.
struct UnknownNorm {
  bool slopes = true, values = false;
};
/// One unknown alone: of slopes. Of several each has its own: of slopes where it is held, with
/// values where it is not, of values alone where it has no form of its own (a pressure, whose
/// inf-sup condition is stated in L2).
std::vector<UnknownNorm> norms_of(const Problem& problem, const Discretisation& discretisation);

/// Of several unknowns, which have different units: the root of the sum of the squares of their
/// relative errors, of size 1 (L2: nan). Of one its own.
StudyError together(std::span<const StudyError> errors);

/// Is shown every step of a run, through RunSettings::on_step, and keeps the errors. A run that
/// starts again is shown to it from its first step on, after `forget`.
class Gauge {
public:
  explicit Gauge(std::vector<UnknownNorm> norms)
      : errors_(norms.size()), norms_(std::move(norms)) {}
  virtual ~Gauge() = default;
  virtual void step(double t, const Vector& u) = 0;
  void forget() { errors_.assign(errors_.size(), {}); }
  const std::vector<StudyError>& errors() const { return errors_; } ///< by unknown
  StudyError error() const { return together(errors_); }

protected:
  /// Squares at one time, of w = u - u_ref and of u_ref, of their slopes and values.
  struct Squares {
    double slopes = 0.0, values = 0.0, size_slopes = 0.0, size_values = 0.0;
  };
  void note(int unknown, const Squares& squares);
  int n_unknowns() const { return static_cast<int>(errors_.size()); }

private:
  std::vector<StudyError> errors_;
  std::vector<UnknownNorm> norms_;
};

/// Against an exact solution: components of slot::x and slot::t, of all unknowns. Integrals by the
/// rule for integrands that are no polynomials.
std::unique_ptr<Gauge> exact_gauge(const Discretisation& discretisation,
                                   std::span<const Expr> exact,
                                   std::vector<UnknownNorm> norms = std::vector<UnknownNorm>(1));

/// The steps of a run, kept to be compared with.
struct Trajectory {
  std::shared_ptr<const Discretisation> discretisation;
  std::vector<double> times; ///< increasing, the initial one included; one entry: static
  std::vector<Vector> states;
  /// u at t by the piecewise affine interpolant.
  Vector at(double t) const;
};

/// Values of one space's functions at the nodes of another, dof by dof (its interpolant there).
/// Throws Failure(bad_value) for a node outside the first mesh.
SparseMatrix transfer(const Space& from, const Space& to);

/// Is every cell of the fine mesh inside one of the coarse mesh?
bool is_nested(const Mesh& coarse, const Mesh& fine);

/// Against a finer run. Where its mesh is a refinement, the coarse function is one of the finer
/// space's and norms are matrices; elsewhere both are compared at quadrature points of the finer
/// mesh. Throws Failure(bad_value) where the meshes cover different bodies.
std::unique_ptr<Gauge>
trajectory_gauge(std::shared_ptr<const Trajectory> reference, const Discretisation& coarse,
                 std::vector<UnknownNorm> norms = std::vector<UnknownNorm>(1));

} // namespace hvi::solver
