// Superpotentials j(r; x, t): value, Clarke subdifferential, and the numbers of hypothesis H(J).
#pragma once

#include "solver/common/failure.hpp"
#include "solver/kernel/expr.hpp"
#include "solver/mesh/mesh.hpp"

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

/// The values of what a law reads, in the order of LawSpec::readings.
using Readings = std::array<double, slot::most_readings>;

/// When a law is asked: the time; for a law whose bound is another law's multiplier at the same
/// point (Coulomb's friction), that multiplier; and what it reads of the solution there.
struct LawTime {
  double t = 0.0, coupled = 0.0;
  Readings readings{};
  std::array<double, slot::most_law_states> states{}; ///< that it reads there
  LawTime(double time = 0.0, double multiplier = 0.0, const Readings& read = {})
      : t(time), coupled(multiplier), readings(read) {}
  /// Of a variable of a law other than its argument.
  double value(Slot s, const Point& x) const {
    if (s == slot::t) return t;
    if (s == slot::coupled) return coupled;
    if (s >= slot::reading(0)) return readings[static_cast<std::size_t>(s - slot::reading(0))];
    if (s >= slot::law_state(0)) return states[static_cast<std::size_t>(s - slot::law_state(0))];
    return x[static_cast<std::size_t>(s)];
  }
  friend bool operator==(const LawTime&, const LawTime&) = default;
};

/// A law as data. The argument is slot::argument(0): the scalar r, or for a radial law |xi| >= 0
/// (a vector argument enters through its norm, paper H(j_tau)). May depend on x and t.
struct LawSpec {
  std::string name;
  Origin origin;
  bool radial = false;
  bool by_slope = false; ///< `expression` is the slope j', else the potential j
  Expr expression;
  std::string coupled{}; ///< the law whose multiplier slot::coupled stands for; "": none
  /// What slot::reading(i) stands for: of slot::x, slot::t, slot::normal, the values (no gradients)
  /// of the unknowns, their rates and memories at the point of the law, and slot::multiplier of
  /// laws at the same points.
  std::vector<Expr> readings{};
  std::vector<int> states{}; ///< the states of the plan that slot::law_state(k) stand for
};

/// The graph of r -> dj(r) at one point of space and time, jumps filled in. Piece i is smooth on
/// [breaks[i-1], breaks[i]]; at breaks[i] the subdifferential is the interval between the limits.
/// For a radial law r >= 0 and at r = 0 the subdifferential is the ball of radius |slope(0+)|.
/// Breaks of a radial law are > 0: its origin is a state of its own, not a break.
struct LawGraph {
  /// Piece i as the solvers evaluate it: a polynomial sum a[k] (r - centre)^k of degree <= 5 where
  /// the slope is one at this x and t, else (degree -1) the compiled expression. The primitive of
  /// a piece vanishes at its centre (its point nearest 0), except for a law by potential that is no
  /// polynomial.
  struct Smooth {
    int degree = -1;
    double centre = 0.0;
    std::array<double, 6> a{};
  };
  std::vector<Smooth> smooth;
  std::vector<double> breaks;
  std::vector<int> functions;      ///< which smooth function of the law piece i uses
  std::vector<double> left, right; ///< slope limits at breaks[i]
  std::vector<double> offsets;     ///< potential of piece i = its primitive + offsets[i]
  double origin = 0.0;             ///< of a radial law: the slope at 0, or its limit
  Point x{};
  LawTime t;
  int pieces() const { return static_cast<int>(functions.size()); }
};

/// A slope beyond this stands for infinity: unilateral contact is the law that jumps from 0 to it
/// at the gap. It is no scale for certificates, and the growth of such a law is infinite.
constexpr double unbounded_slope = 1e250;

/// Where a law's numbers hold, and how they were found.
struct LawConstants {
  double m = 0.0;          ///< steepest descent of the slope, m_J of H(J)(iii); may be infinite
  bool jumps_down = false; ///< it is, and not since the slope falls infinitely steeply
  double c = 0.0;          ///< growth: |xi| <= c (1 + |r|), c_J of H(J)(ii); inf if superlinear
  double steepest_ascent = 0.0; ///< sup of the slope's derivative; inf at an upward jump
  double slope_scale = 0.0;     ///< a typical |xi|: scales the certificate
  bool exact = false;           ///< by symbolic derivative and interval bound; else sampled
  bool clarke_regular = true;   ///< j or -j regular (finite m: always, since j + m r^2/2 is convex)
  bool convex = false;          ///< m == 0
  double worst_at = 0.0;        ///< an argument where m is (nearly) attained
};

class Law {
public:
  /// Finds the switches (cases, abs, min, max) and compiles each smooth branch.
  /// Throws Failure(bad_law) when the potential jumps or its slope is infinite at a finite point.
  explicit Law(LawSpec spec);
  ~Law();
  Law(Law&&) noexcept;
  Law& operator=(Law&&) noexcept;

  const LawSpec& spec() const;
  /// The first two also where the law is coupled or reads the solution or states: a graph for each
  /// point, found again in each step.
  bool depends_on_x() const;
  bool depends_on_t() const;
  bool coupled() const;
  bool reads() const; ///< the solution
  bool reads_states() const;

  /// The graph at a point. Throws Failure(bad_law) as the constructor does, for this point.
  LawGraph graph(const Point& x, LawTime t) const;
  double slope(const LawGraph& graph, int piece, double r) const;
  double curvature(const LawGraph& graph, int piece, double r) const; ///< d slope / dr
  double potential(const LawGraph& graph, int piece, double r) const;
  /// Slope and curvature in one evaluation: what a Newton step asks for.
  void slope_and_curvature(const LawGraph& graph, int piece, double r, double& slope,
                           double& curvature) const;
  /// Range of the curvature on the part [low, high] of a piece (either end may be infinite).
  struct CurvatureRange {
    double low = 0.0, high = 0.0;
    double low_at = 0.0; ///< where `low` is (nearly) attained
    bool exact = true;   ///< closed form or interval bound; else sampled
  };
  CurvatureRange curvature_range(const LawGraph& graph, int piece, double low, double high) const;

  /// An end of the piece at which the slope falls infinitely steeply.
  std::optional<double> steep_fall(const LawGraph& graph, int piece) const;

  LawConstants constants(const Point& x, LawTime t) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// End points of piece i: -inf and inf outside the breaks; a radial law starts at 0.
double piece_low(const LawGraph& graph, int piece, bool radial);
double piece_high(const LawGraph& graph, int piece);
/// The piece that holds r (the lower one at a break).
int piece_of(const LawGraph& graph, double r);
/// Has the graph a step or a rigid part, where one argument has many slopes?
bool has_jumps(const LawGraph& graph, bool radial);
/// dj(r) as an interval [low, high] (scalar laws; for radial laws at r > 0 the radial slope).
struct Interval {
  double low, high;
};
Interval clarke(const Law& law, const LawGraph& graph, double r, double snap = 0.0);
/// Distance of (z, xi) to the graph of dj: min over the graph near z of the error in xi, where
/// z within `snap` of a break counts as on it. z and xi have `rows` entries (1, or a radial law).
/// Not more than `enough` is as good as 0: it may then be anything up to that.
double inclusion_distance(const Law& law, const LawGraph& graph, const double* z, const double* xi,
                          int rows, double snap, double enough = 0.0);

} // namespace hvi::solver
