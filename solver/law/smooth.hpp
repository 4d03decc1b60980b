// One smooth branch of a law, compiled: slope, curvature, potential, and its Taylor coefficients
// where the slope is a polynomial in r.
#pragma once

#include "solver/law/law.hpp"
#include "solver/law/point_tape.hpp"
#include "solver/law/supremum.hpp"

#include <mutex>

namespace hvi::solver {

class SmoothFunction {
public:
  /// `expression` holds no switch any more; it is the slope, or the potential.
  SmoothFunction(const Expr& expression, bool by_slope);

  const Expr& expression() const { return expression_; }
  int degree() const { return degree_; } ///< of the slope in r, at most 5; -1: not a polynomial
  double slope(double r, const Point& x, LawTime t) const;
  void slope_and_curvature(double r, const Point& x, LawTime t, double& s, double& c) const;
  double potential(double r, const Point& x, LawTime t) const { return potential_(r, x, t); }
  /// Slope as a polynomial about `centre`; degree lowered where leading coefficients vanish.
  LawGraph::Smooth expand(double centre, const Point& x, LawTime t) const;
  const Expr& slope_expression() const { return slope_expression_; }
  /// sup of -slope' over a range of r at a fixed x and t. The last answer is kept: a run asks
  /// several times.
  LargestValue descent(const SupremumRange& range, const Point& x, const LawTime& t,
                       const SearchEffort& effort) const;

private:
  Expr expression_, slope_expression_;
  int degree_ = -1;
  PointTape slope_, potential_, taylor_;
  struct LastDescent {
    Supremum search;
    bool made = false, answered = false;
    double low = 0.0, high = 0.0;
    Point x{};
    LawTime t{};
    int evaluations = 0;
    LargestValue answer;
  };
  mutable std::mutex descent_lock_;
  mutable LastDescent descent_;
};

/// Degree of an expression in slot::argument(0) by its structure; -1 when it is no polynomial.
int polynomial_degree(const Expr& e);

/// Real roots of sum a[k] s^k inside (low, high), by the roots of its derivative and bisection.
std::vector<double> polynomial_roots(std::span<const double> a, double low, double high);

double polynomial(const LawGraph::Smooth& p, double r);
double polynomial_slope(const LawGraph::Smooth& p, double r);
double polynomial_primitive(const LawGraph::Smooth& p, double r); ///< 0 at the centre

} // namespace hvi::solver
