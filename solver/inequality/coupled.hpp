// Laws whose bounds are other laws' multipliers (Coulomb's friction), all at once. Internal to
// solver/inequality.
//
// Semismooth Newton on the natural map of the coupled laws (P. Alart, A. Curnier, A mixed
// formulation for frictional contact problems prone to Newton like solution methods, Computer
// Methods in Applied Mechanics and Engineering 92, 1991): with y_p = z_p + gamma_p xi_p
//
//     F1 = r - S c - G^T W xi,        F2_p = z_p - J_p(y_p; b_p),
//
// J_p the resolvent of p's law, b_p = share times the multiplier that its normal law's resolvent
// gives. The matrix S + G^T W D G has the derivative by b_p, too, so that it is not symmetric.
// Steps are shortened until the merit function |F1|^2 / S_ii + |F2|^2 w / gamma falls. `share` < 1
// makes the bounds smaller: at 0 the laws are plain ones, from there solutions are followed, and
// where they turn back the way goes on by arc length (coupled_path.cpp).
#pragma once

#include "solver/inequality/engine.hpp"

#include <vector>

namespace hvi::solver {

struct InequalityEngine::Coupled {
  /// A coupled point with the graph that its bound gives it.
  struct Bound {
    int point = 0, normal = 0; ///< points
    Point x{};
    LawGraph graph;
    double multiplier = 0.0; ///< of the normal law
    double rate = 0.0;       ///< d slope / d multiplier at the point's place on its graph
    bool known = false;      ///< graph belongs to multiplier
  };
  /// Where a search stands.
  struct Place {
    Vector c, xi;
    std::vector<int> state, component;
  };

  explicit Coupled(InequalityEngine& engine);
  ~Coupled(); ///< gives the engine its own graphs and penalties back
  Coupled(const Coupled&) = delete;
  Coupled& operator=(const Coupled&) = delete;

  Place here() const { return {w.c, w.xi, w.state, w.component}; }
  void go(const Place& place);
  void set_share(double value);

  // ---- methods, from the present place; false: they do not get there
  bool newton(int limit);
  bool newton_with_scales(int limit);
  bool solve(int limit);  ///< Newton, with points that leave a component of their law moved on
  bool solve_uncoupled(); ///< at share 0
  bool raise_share();     ///< to 1, by Newton's method at ever larger shares
  /// On from there by arc length, wherever the share goes; true when it is 1.
  bool follow_share();

  // ---- pieces of a step along the path of solutions (coupled_path.cpp)
  /// A solution on the path and a direction from it.
  struct Waypoint {
    Place place;
    double share = 0.0;
  };
  /// Of the path, with unit length in (c, share); xi belongs to c.
  struct Heading {
    Vector c, xi;
    double share = 0.0;
  };
  Waypoint waypoint() const { return {here(), share}; }
  void go(const Waypoint& to);
  double product(const Vector& a, const Vector& b) const; ///< of displacements, without a unit
  double product(const Heading& a, const Heading& b) const;
  bool step_on_path(const Waypoint& last, const Heading& along, double length);
  bool look_ahead(Heading& out);
  bool keeps_to_path(const Waypoint& last, const Heading& along, double length, Heading& next);
  bool turn_on_path(const Waypoint& last, const Heading& along);
  bool share_direction();

  // ---- pieces of a step
  void set_bound(Bound& b, double multiplier);
  double slope_rate(const Bound& b) const;
  double projected(int point) const; ///< the multiplier that the last `classify` gave the point
  Small slip(const Bound& b) const;  ///< its direction; 0 where the point rests
  void classify();
  void linear_multipliers(Vector& out) const;
  void assemble();
  bool direction();
  void add_slip(const Bound& b, double size);
  double merit();
  double line_search(double limit, double& after);
  double multipliers();
  bool finish(double& ratio);

  InequalityEngine& w;
  std::unique_ptr<ReducedOperator> lu;
  std::vector<Bound> bounds;
  std::vector<double> penalties; ///< the engine's
  std::vector<int> bound_of;     ///< by point; -1: a law of its own
  double share = 1.0;
  Vector path_c, path_xi; ///< what c and xi change with the share
  double energy = 1.0;    ///< of displacements: their unit
  double scale = 1.0;     ///< factor of gamma in the natural map
  Vector target_xi;
  SparseMatrix matrix; ///< H
  std::vector<Eigen::Triplet<double>> entries;
};

} // namespace hvi::solver
