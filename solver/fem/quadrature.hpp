// Quadrature on simplices. Used by every weak term; nothing here knows a mesh.
#pragma once

#include "solver/plan/problem.hpp"

#include <array>
#include <span>
#include <vector>

namespace hvi::solver {

using Barycentric = std::array<double, 4>; ///< dim + 1 of them used, sum 1

/// integral over a simplex of f  =  measure * sum_q weights[q] f(points[q]); weights sum to 1.
struct Quadrature {
  int dim = 0; ///< of the simplex: 0 point, 1 interval, 2 triangle, 3 tetrahedron
  std::vector<Barycentric> points;
  std::vector<double> weights;
  std::size_t size() const { return weights.size(); }
};

/// Nodes and weights on [0, 1] for the weight function (1 - x)^alpha, n points, exact for degree
/// 2 n - 1; the weights sum to 1 / (alpha + 1).
struct IntervalRule {
  std::vector<double> points, weights;
};
IntervalRule gauss_jacobi(int n, int alpha);

/// A rule with positive weights and interior or boundary points, exact for polynomials of `degree`
/// (any degree >= 0). Symmetric rules up to degree 8 (triangles) and 6 (tetrahedra), conical
/// products of Gauss-Jacobi rules beyond.
Quadrature simplex_rule(int dim, int degree);

/// Points on the nodes of the Lagrange element of `order`, weights positive:
/// order 1: the vertices (degree 1). Order 2: intervals Simpson (degree 3); triangles the edge
/// midpoints only, 1/3 each (degree 2: the vertices have weight 0 in the six-node rule, and a
/// weight of zero is no contact condition); tetrahedra vertices 1/32 and edge midpoints 7/48
/// (the trapezoidal rule on the eight halves, degree 1: the ten-node rule of degree 2 has vertex
/// weights -1/20).
Quadrature nodal_rule(int dim, int order);
/// For each point of nodal_rule(dim, order) the local node it lies on.
std::vector<int> nodal_rule_nodes(int dim, int order);

/// The weights of nodal_rule(dim, order), on intervals and triangles, against the affine function
/// with the values r >= 0 at the corners: sum_q w_q f(node_q) ~ mean of f r. Order 1: the means of
/// phi_i r, positive where r is not zero throughout. Order 2: on intervals these means too, exact
/// for f of degree 2; an end with r = 0 has the weight 0. On triangles those of the phi_i of the
/// middles, which are positive and sum to the mean of r.
std::vector<double> weighted_nodal_rule(int dim, int order, std::span<const double> r);

/// The rule a plan names. `exact` needs the degree to integrate; `gauss` is of degree 2 order.
Quadrature make_rule(Rule rule, int dim, int order, int exact_degree);

} // namespace hvi::solver
