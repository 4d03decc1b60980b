// The least energy of a reduced problem that is not convex, with a proof: branch and bound.
//
// On the laws' arguments, C = G S^-1 G^T, b the arguments of the free body, the energy over that of
// the free body is
//
//     E(z) = (z - b)^T C^-1 (z - b) / 2 + sum_p w_p j_p(z_p).
//
// A diagonal D with C^-1 - D positive definite is taken from the body and given to the laws:
// phi_p(z) = w_p j_p(z) + d_p z^2 / 2. On a box of arguments each phi_p is bounded from below by a
// convex function (cells of the law with curvature >= k: + max(0, -k) (z - a)(z - b) / 2, then the
// convex hull). The minimum of that convex problem, bounded by Lagrangian duality, is a lower bound
// of E on the box. Boxes are halved where the bound is worst, the lowest bound first, until it
// meets the lowest energy found (J. E. Falk and R. M. Soland, An algorithm for separable nonconvex
// programming problems, 1969; I. P. Androulakis, C. D. Maranas and C. A. Floudas, alphaBB: a global
// optimization method for general constrained nonconvex problems, 1995).
#pragma once

#include "solver/inequality/equilibrium_curve.hpp"
#include "solver/inequality/inequality.hpp"

#include <Eigen/Cholesky>

#include <functional>
#include <vector>

namespace hvi::solver {

class LeastEnergy {
public:
  struct Result {
    double lowest = 0.0; ///< energy of the best state found, over that of the free body
    double bound = 0.0;  ///< no state has less; -infinity where nothing is known
    double scale = 0.0;  ///< the size of the energies that make up `lowest`, or b^T D b / 2
    int boxes = 0;
    /// (lowest - bound) / scale: by how much less another state may have.
    double gap() const;
    bool proved() const { return gap() <= proved_least_gap; }
  };

  /// C dense and square, one point a row; scalar laws only.
  LeastEnergy(const DenseMatrix& compliance, std::vector<CurvePoint> points);

  /// The energy, over that of the free body, of the body under the points' forces (w_p xi_p), and
  /// the size of its parts.
  double energy(const Vector& b, const Vector& force, double& scale) const;

  /// `force` is that of the best state known. `descend` goes from the forces of a candidate to a
  /// solution nearby, and gives its forces, or an empty vector.
  Result search(const Vector& b, const Vector& force,
                const std::function<Vector(const Vector&)>& descend);

private:
  /// A part of a law's graph inside one piece, with a lower bound of its curvature.
  struct Cell {
    double low, high, curvature;
    int piece;
    bool straight;
  };
  /// A cell within a box: phi there, made convex.
  struct Segment {
    double a, b, fa, fb, slope, curvature; ///< slope of phi at a, least curvature of phi
    int piece;
    bool straight;
  };
  struct Box {
    double bound;
    Vector low, high, multiplier;
    bool operator<(const Box& other) const { return bound > other.bound; }
  };

  bool take_from_body();
  bool first_box(Box& box);
  bool make_cells(const Box& box);
  void make_segments(const Box& box);
  double phi(int p, int piece, double z) const;
  double phi_slope(int p, int piece, double z) const;
  double phi_at(int p, double z) const;
  double least_on(int p, int piece) const;
  double conjugate_on(int p, const Segment& s, double slope, double& at) const;
  double conjugate(int p, double slope, double& at);
  void improve(int p, double box_low, double box_high);
  double dual_value();
  void maximise_dual(Box& box);
  int worst_point(const Box& box, double& at);
  void consider(const Vector& force);

  DenseMatrix c_, c_tilde_; ///< C, (C^-1 - D)^-1
  std::vector<CurvePoint> points_;
  int n_;
  Vector d_, root_;                              ///< D and its root
  Eigen::LLT<DenseMatrix> rest_;                 ///< of 1 - D^1/2 C D^1/2
  std::vector<double> domain_low_, domain_high_; ///< of finite energy
  std::vector<std::vector<Cell>> cells_;         ///< by point
  std::vector<std::vector<Segment>> segments_;
  Vector b_, b_tilde_;       ///< the free body's arguments; (1 - C D)^-1 b
  Vector lambda_, c_lambda_; ///< multipliers, and (C^-1 - D)^-1 times them
  double shift_ = 0.0;       ///< the energy where lambda = 0 and phi = 0
  Result result_;
  double work_ = 0.0; ///< segments looked at, and entries of products
  const std::function<Vector(const Vector&)>* descend_ = nullptr;
  int descents_ = 0;
};

} // namespace hvi::solver
