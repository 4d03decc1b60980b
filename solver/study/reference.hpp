// What a study measures errors against: an exact solution, or the steps of a finer run.
#pragma once

#include "solver/time/run.hpp"

#include <memory>
#include <span>
#include <vector>

namespace hvi::solver {

/// Errors of a run in the norm of V, || eps(u - u_ref) || (scalar unknowns: || grad(u - u_ref) ||),
/// and in L2: the largest over the steps and the last one; and how large u_ref is in V.
struct StudyError {
  double v_max = 0.0, v_final = 0.0, l2_max = 0.0, l2_final = 0.0, size = 0.0;
  double relative() const { return size > 0.0 ? v_max / size : v_max; }
};

/// Is shown every step of a run, through RunSettings::on_step, and keeps the errors.
class Gauge {
public:
  virtual ~Gauge() = default;
  virtual void step(double t, const Vector& u) = 0;
  const StudyError& error() const { return error_; }

protected:
  /// Squares of the error's and the reference's norms at one time.
  void note(double v_squared, double l2_squared, double size_squared);
  StudyError error_;
};

/// Against an exact solution: components of slot::x and slot::t. Integrals by the rule for
/// integrands that are no polynomials.
std::unique_ptr<Gauge> exact_gauge(const Discretisation& discretisation,
                                   std::span<const Expr> exact);

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
std::unique_ptr<Gauge> trajectory_gauge(std::shared_ptr<const Trajectory> reference,
                                        const Discretisation& coarse);

} // namespace hvi::solver
