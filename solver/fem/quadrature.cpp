// Quadrature on simplices: symmetric rules by orbits, conical products, nodal rules.
#include "solver/fem/quadrature.hpp"

#include "solver/linear/dense.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// A rule under construction: every orbit adds all distinct permutations of one point.
class OrbitRule {
public:
  explicit OrbitRule(int dim) { rule_.dim = dim; }

  /// `labels` says which coordinates are equal by structure, so that two labels whose values
  /// happen to coincide are still permuted as different.
  OrbitRule& add(double weight, std::vector<int> labels, const std::array<double, 3>& values) {
    std::sort(labels.begin(), labels.end());
    do {
      Barycentric point{};
      for (std::size_t k = 0; k < labels.size(); ++k) {
        point[k] = values[labels[k]];
      }
      rule_.points.push_back(point);
      rule_.weights.push_back(weight);
    } while (std::next_permutation(labels.begin(), labels.end()));
    return *this;
  }
  OrbitRule& centroid(double weight) {
    return add(weight, std::vector<int>(rule_.dim + 1, 0), {1.0 / (rule_.dim + 1), 0, 0});
  }
  /// (a, ..., a, 1 - dim a): on the lines from the centroid to the vertices.
  OrbitRule& median(double weight, double a) {
    std::vector<int> labels(rule_.dim + 1, 0);
    labels.back() = 1;
    return add(weight, labels, {a, 1.0 - rule_.dim * a, 0});
  }
  Quadrature take() { return std::move(rule_); }

private:
  Quadrature rule_;
};

/// Degree 2: P. C. Hammer, A. H. Stroud, Numerical integration over simplexes, Math. Tables Aids
/// Comput. 10 (1956) 137-139. 4: G. Strang, G. J. Fix, An analysis of the finite element method,
/// 1973; 5: J. Radon, Zur mechanischen Kubatur, Monatsh. Math. 52 (1948) 286-300; both in closed
/// form. 6 and 8: D. A. Dunavant, High degree efficient symmetrical Gaussian quadrature rules for
/// the triangle, Int. J. Numer. Methods Eng. 21 (1985) 1129-1148, whose 15 digits were extended to
/// 20 by Newton's method on the moment equations.
Quadrature triangle_rule(int degree) {
  OrbitRule rule(2);
  if (degree <= 1) {
    return rule.centroid(1.0).take();
  }
  if (degree == 2) {
    return rule.median(1.0 / 3.0, 1.0 / 6.0).take();
  }
  if (degree <= 4) {
    const double root = std::sqrt(38.0 - 44.0 * std::sqrt(0.4)), s = std::sqrt(10.0);
    const double split = std::sqrt(213125.0 - 53320.0 * s);
    return rule.median((620.0 + split) / 3720.0, (8.0 - s + root) / 18.0)
        .median((620.0 - split) / 3720.0, (8.0 - s - root) / 18.0)
        .take();
  }
  if (degree == 5) {
    const double s = std::sqrt(15.0);
    return rule.centroid(9.0 / 40.0)
        .median((155.0 - s) / 1200.0, (6.0 - s) / 21.0)
        .median((155.0 + s) / 1200.0, (6.0 + s) / 21.0)
        .take();
  }
  if (degree == 6) {
    const double a = 0.05314504984481695003, b = 0.31035245103378440262;
    return rule.median(0.11678627572637935976, 0.24928674517091042488)
        .median(0.05084490637020681581, 0.06308901449150222754)
        .add(0.08285107561837357888, {0, 1, 2}, {a, b, 1.0 - a - b})
        .take();
  }
  const double a = 0.00839477740995760894, b = 0.26311282963463810352;
  return rule.centroid(0.14431560767778717238)
      .median(0.09509163426728462137, 0.45929258829272315935)
      .median(0.10321737053471825082, 0.17056930775176021073)
      .median(0.03245849762319808025, 0.05054722831703097571)
      .add(0.02723031417443499506, {0, 1, 2}, {a, b, 1.0 - a - b})
      .take();
}

/// Degree 2: P. C. Hammer, A. H. Stroud (see triangle_rule). 3: vertices and face centroids,
/// A. H. Stroud, Approximate calculation of multiple integrals, 1971. 5: 14 points, N. J.
/// Walkington, Quadrature on simplices of arbitrary dimension, report, Carnegie Mellon University,
/// 2000. 6: 24 points, P. Keast, Moderate-degree tetrahedral quadrature formulas, Comput. Methods
/// Appl. Mech. Engrg. 55 (1986) 339-348. The last two were extended to 20 digits by Newton's method
/// on the moment equations.
Quadrature tetrahedron_rule(int degree) {
  OrbitRule rule(3);
  if (degree <= 1) {
    return rule.centroid(1.0).take();
  }
  if (degree == 2) {
    return rule.median(0.25, (5.0 - std::sqrt(5.0)) / 20.0).take();
  }
  if (degree == 3) {
    return rule.median(1.0 / 40.0, 0.0).median(9.0 / 40.0, 1.0 / 3.0).take();
  }
  if (degree <= 5) {
    const double a = 0.04550370412564964946;
    return rule.median(0.11268792571801585084, 0.31088591926330060982)
        .median(0.07349304311636194959, 0.09273525031089122643)
        .add(0.04254602077708146639, {0, 0, 1, 1}, {a, 0.5 - a, 0})
        .take();
  }
  const double a = 0.06366100187501752546, b = 0.26967233145831580771;
  return rule.median(0.03992275025816749076, 0.21460287125915203138)
      .median(0.01007721105532064281, 0.04067395853461135271)
      .median(0.05535718154365472280, 0.32233789014227551004)
      .add(27.0 / 560.0, {0, 0, 1, 2}, {a, b, 1.0 - 2.0 * a - b})
      .take();
}

/// The conical product (A. H. Stroud, Approximate calculation of multiple integrals, 1971): the
/// simplex as an image of the cube, x_1 = s_1, x_2 = (1 - s_1) s_2, ..., whose Jacobian goes into
/// the Gauss-Jacobi weights.
Quadrature conical_rule(int dim, int degree) {
  const int n = degree / 2 + 1;
  Quadrature rule{dim, {Barycentric{}}, {1.0}};
  std::vector<double> rest{1.0};
  for (int axis = 0; axis < dim; ++axis) {
    const int alpha = dim - 1 - axis;
    const IntervalRule line = gauss_jacobi(n, alpha);
    Quadrature next{dim, {}, {}};
    std::vector<double> next_rest;
    for (std::size_t q = 0; q < rule.size(); ++q) {
      for (int k = 0; k < n; ++k) {
        Barycentric point = rule.points[q];
        point[axis] = rest[q] * line.points[k];
        next.points.push_back(point);
        next.weights.push_back(rule.weights[q] * line.weights[k] * (alpha + 1));
        next_rest.push_back(rest[q] * (1.0 - line.points[k]));
      }
    }
    rule = std::move(next);
    rest = std::move(next_rest);
  }
  for (std::size_t q = 0; q < rule.size(); ++q) {
    rule.points[q][dim] = rest[q];
  }
  return rule;
}

Barycentric midpoint(int a, int b) {
  Barycentric point{};
  point[a] = point[b] = 0.5;
  return point;
}

} // namespace

IntervalRule gauss_jacobi(int n, int alpha) {
  // G. H. Golub, J. H. Welsch, Calculation of Gauss quadrature rules, Math. Comp. 23 (1969)
  // 221-230: eigenvalues of the Jacobi matrix of the monic polynomials orthogonal on [-1, 1] with
  // the weight (1 - y)^alpha, mapped to x = (y + 1) / 2.
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
  for (int k = 0; k < n; ++k) {
    const double s = 2.0 * k + alpha;
    jacobi(k, k) = s == 0.0 ? 0.0 : -double(alpha) * alpha / (s * (s + 2.0));
    if (k == 0) {
      continue;
    }
    // alpha = 0, k = 1 has s - 1 = 1, so no denominator vanishes.
    const double square = 4.0 * k * k * (k + alpha) * (k + alpha) / (s * s * (s * s - 1.0));
    jacobi(k, k - 1) = jacobi(k - 1, k) = std::sqrt(square);
  }
  const auto [values, vectors] = symmetric_spectrum(jacobi);
  IntervalRule rule;
  for (int k = 0; k < n; ++k) {
    const double first = vectors(0, k);
    rule.points.push_back(0.5 * (1.0 + values(k)));
    rule.weights.push_back(first * first / (alpha + 1.0));
  }
  return rule;
}

Quadrature simplex_rule(int dim, int degree) {
  if (dim == 0) {
    return {0, {Barycentric{1, 0, 0, 0}}, {1.0}};
  }
  if (dim == 2 && degree <= 8) {
    return triangle_rule(degree);
  }
  if (dim == 3 && degree <= 6) {
    return tetrahedron_rule(degree);
  }
  return conical_rule(dim, degree);
}

Quadrature nodal_rule(int dim, int order) {
  if (dim == 0) {
    return simplex_rule(0, 0);
  }
  Quadrature rule{dim, {}, {}};
  const auto add = [&rule](const Barycentric& point, double weight) {
    rule.points.push_back(point);
    rule.weights.push_back(weight);
  };
  const double vertex = order == 1 ? 1.0 / (dim + 1) : std::array{0.0, 1.0 / 6, 0.0, 1.0 / 32}[dim];
  const double edge = std::array{0.0, 2.0 / 3, 1.0 / 3, 7.0 / 48}[dim];
  for (int k = 0; k <= dim && vertex > 0; ++k) {
    Barycentric point{};
    point[k] = 1.0;
    add(point, vertex);
  }
  for (int a = 0; a <= dim && order == 2; ++a) {
    for (int b = a + 1; b <= dim; ++b) {
      add(midpoint(a, b), edge);
    }
  }
  return rule;
}

std::vector<int> nodal_rule_nodes(int dim, int order) {
  const std::size_t n = nodal_rule(dim, order).size();
  // Without the vertices the first edge is local node dim + 1.
  const int first = order == 2 && dim == 2 ? dim + 1 : 0;
  std::vector<int> nodes(n);
  for (std::size_t q = 0; q < n; ++q) {
    nodes[q] = first + static_cast<int>(q);
  }
  return nodes;
}

namespace {

std::vector<double> weighted_interval(int order, double a, double b) {
  if (order == 1) {
    return {(2.0 * a + b) / 6.0, (a + 2.0 * b) / 6.0};
  }
  return {a / 6.0, b / 6.0, (a + b) / 3.0};
}

std::vector<double> weighted_triangle(int order, double a, double b, double c) {
  const double sum = a + b + c;
  if (order == 1) {
    return {(sum + a) / 12.0, (sum + b) / 12.0, (sum + c) / 12.0};
  }
  return {(2.0 * sum - c) / 15.0, (2.0 * sum - b) / 15.0, (2.0 * sum - a) / 15.0};
}

} // namespace

std::vector<double> weighted_nodal_rule(int dim, int order, std::span<const double> r) {
  return dim == 1 ? weighted_interval(order, r[0], r[1])
                  : weighted_triangle(order, r[0], r[1], r[2]);
}

Quadrature make_rule(Rule rule, int dim, int order, int exact_degree) {
  switch (rule) {
  case Rule::exact:
    return simplex_rule(dim, exact_degree);
  case Rule::nodal:
    return nodal_rule(dim, order);
  case Rule::midpoint:
    return simplex_rule(dim, 1);
  case Rule::gauss:
    return simplex_rule(dim, 2 * order);
  }
  return simplex_rule(dim, exact_degree);
}

} // namespace hvi::solver
