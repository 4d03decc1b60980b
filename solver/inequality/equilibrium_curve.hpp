// The equilibrium curve of the reduced inequality between two loads.
//
// With S invertible, (*) of inequality.hpp is a problem on the laws' arguments alone,
//
//     z + C W xi = b(l),   xi_p in dj_p(z_p),   C = G S^-1 G^T,   b(l) = b_0 + l (b_1 - b_0),
//
// l = 0 the last state, l = 1 the one that is looked for. With the graph's jumps filled in, its
// solutions (z, xi, l) form a curve. For laws of straight pieces it is a chain of straight
// segments, each found exactly: one linear solve, then on to the first point that leaves its piece
// (J. Katzenelson, An algorithm for solving nonlinear resistor networks, 1965; T. Fujisawa and
// E. S. Kuh, Piecewise-linear theory of nonlinear networks, 1970). Curved pieces are followed by
// steps along the tangent with Newton corrections (pseudo-arclength; H. B. Keller, Numerical
// solution of bifurcation and nonlinear eigenvalue problems, 1977).
//
// While l grows along the curve its states are stable (S + H positive definite; det changes sign
// where the curve turns). Where it turns back the branch has ended: a limit point. The state after
// the jump is the next one that the curve has at the same load and that is stable again.
#pragma once

#include "solver/inequality/prepared_law.hpp"
#include "solver/linear/sparse.hpp"

#include <Eigen/LU>

#include <functional>
#include <vector>

namespace hvi::solver {

/// The graph of a scalar law over all arguments; a radial law with one row as an odd one.
class CurveGraph {
public:
  explicit CurveGraph(const PreparedLaw& law);

  int pieces() const { return static_cast<int>(breaks_.size()) + 1; }
  double low(int piece) const;
  double high(int piece) const;
  double at(int b) const { return breaks_[b]; }
  double below(int b) const { return left_[b]; } ///< the slope's limit from below break b
  double above(int b) const { return right_[b]; }
  bool straight(int piece) const { return straight_[piece]; }
  /// Slope and its derivative on a piece, which goes on along its tangents beyond its ends.
  void slope(int piece, double z, double& s, double& d) const;
  double potential(int piece, double z) const;
  /// A proved lower bound of the slope's derivative on a part of a piece; -infinity where there is
  /// none.
  double least_curvature(int piece, double low, double high) const;
  /// The engine's state (InequalityState) of a place: 2 i inside piece i, 2 i + 1 at break i.
  int engine_state(int place) const;
  int component(int place) const; ///< and the law's component there

private:
  int own_piece(int piece) const; ///< of the law's own graph
  const PreparedLaw* law_;
  bool odd_;
  std::vector<double> breaks_, left_, right_;
  std::vector<char> straight_;
};

struct CurvePoint {
  const CurveGraph* graph;
  double weight;
};

class EquilibriumCurve {
public:
  /// Where a branch ended: the load, and whether at a downward jump (else by softening).
  struct End {
    double load;
    bool drop;
  };
  enum class Outcome {
    arrived, ///< at l = 1, on a branch that is stable
    lost     ///< the curve has no further stable state at a load where a branch ended
  };

  /// C dense and square, one point a row. `symmetric`: stability is positive definiteness; else
  /// only that det does not change its sign.
  EquilibriumCurve(DenseMatrix compliance, std::vector<CurvePoint> points, bool symmetric);
  const DenseMatrix& compliance() const { return compliance_; }

  /// From the state (z, xi), which is an equilibrium by the choice of b_0 = z + C W xi (xi is put
  /// on the graph first), to l = 1, where b = b_1.
  Outcome follow(const Vector& z, const Vector& xi, const Vector& b1);
  /// Along the whole curve, both ways, however often it turns: `solution` is called at each l = 1.
  void visit(const Vector& z, const Vector& xi, const Vector& b1,
             const std::function<void()>& solution);

  const Vector& z() const { return z_; }
  const Vector& xi() const { return xi_; }
  const std::vector<int>& places() const { return place_; } ///< 2 i or 2 i + 1, as above
  const std::vector<End>& ends() const { return ends_; }
  int steps() const { return steps_; } ///< segments, and steps on curved pieces

private:
  struct Event {
    double length; ///< to go along the tangent
    int point;     ///< `by_load`, `none`, or the point that reaches an end of its place
    int side;      ///< that end: 1 up, -1 down
  };
  enum class Step { crossed, at_load, moved, failed };
  static constexpr int by_load = -1, none = -2;

  void start(const Vector& z, const Vector& xi, const Vector& b1);
  void put_on_graph(int p, double noise);
  void move_off_corner(int p, double room);
  bool upright(int p) const { return place_[p] % 2 == 1; }
  bool drop(int p) const;
  bool curved(int p) const { return !upright(p) && !points_[p].graph->straight(place_[p] / 2); }
  double unknown(int p) const { return upright(p) ? xi_[p] * a_(p, p) : z_[p]; }
  double end(int p, int side) const; ///< of its place, as an `unknown`
  void update_xi();
  void make_jacobian();
  bool tangent();
  void reverse() { way_ = -way_, way_load_ = -way_load_; }
  Event next_event(double target) const;
  double longest_curved() const;
  bool go(double length);
  bool correct();
  Event overrun(double target, bool seeks_load) const;
  bool cross(const Event& e);
  bool to_load(double target);
  Step step(double target);
  Step step_on_curved(const Event& e, double target);
  void locate_turn();
  bool stable();
  bool jump_at(double load);
  void trace(const std::function<void()>& solution);

  DenseMatrix compliance_, a_; ///< C, C W
  DenseMatrix root_;           ///< L with C = L L^T, for stability; made when it is asked for
  std::vector<CurvePoint> points_;
  bool symmetric_;
  int n_;
  Vector z_, xi_, d_, b0_, db_;
  std::vector<int> place_;
  double load_ = 0.0, size_ = 1.0;
  Vector way_;            ///< tangent: of z, or of a_pp xi where a point is upright
  double way_load_ = 1.0; ///< and of the load
  double stride_ = 0.0;   ///< longest next step on curved pieces
  DenseMatrix jacobian_, bordered_;
  Eigen::PartialPivLU<DenseMatrix> lu_;
  std::vector<End> ends_;
  int steps_ = 0, most_ = 0;
};

} // namespace hvi::solver
