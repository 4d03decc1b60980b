// Quadrature rules against the exact moments of a simplex (analytic).
#include "solver/fem/element.hpp"
#include "solver/fem/quadrature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

/// Mean of lambda_0^a lambda_1^b lambda_2^c over a simplex: a! b! c! dim! / (a + b + c + dim)!.
double exact_moment(int dim, int a, int b, int c) {
  return std::exp(std::lgamma(a + 1) + std::lgamma(b + 1) + std::lgamma(c + 1) +
                  std::lgamma(dim + 1) - std::lgamma(a + b + c + dim + 1));
}

double moment(const Quadrature& rule, int a, int b, int c) {
  double sum = 0;
  for (std::size_t q = 0; q < rule.size(); ++q) {
    const auto& p = rule.points[q];
    sum += rule.weights[q] * std::pow(p[0], a) * std::pow(p[1], b) * std::pow(p[2], c);
  }
  return sum;
}

/// The largest relative error of a moment of this total degree. In `dim` dimensions the powers of
/// dim barycentric coordinates span all polynomials.
double worst_error(const Quadrature& rule, int degree) {
  double worst = 0;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; a + b <= degree; ++b) {
      const int c = degree - a - b;
      if ((rule.dim < 2 && b > 0) || (rule.dim < 3 && c > 0)) continue;
      const double exact = exact_moment(rule.dim, a, b, c);
      worst = std::max(worst, std::abs(moment(rule, a, b, c) / exact - 1));
    }
  }
  return worst;
}

TEST(Quadrature, IsExactToItsDegreeAndPositive) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (int degree = 0; degree <= 14; ++degree) {
      const Quadrature rule = simplex_rule(dim, degree);
      for (int d = 0; d <= degree; ++d) {
        EXPECT_LT(worst_error(rule, d), 4e-14)
            << "dim " << dim << " rule " << degree << " at " << d;
      }
      for (std::size_t q = 0; q < rule.size(); ++q) {
        EXPECT_GT(rule.weights[q], 0);
        double sum = 0;
        for (int k = 0; k <= dim; ++k) {
          EXPECT_GE(rule.points[q][k], 0);
          sum += rule.points[q][k];
        }
        EXPECT_NEAR(sum, 1, 1e-15);
      }
    }
  }
}

TEST(Quadrature, SizesArePublished) {
  const std::vector<std::size_t> triangle{1, 1, 3, 6, 6, 7, 12, 16, 16};
  const std::vector<std::size_t> tetrahedron{1, 1, 4, 8, 14, 14, 24};
  for (int d = 0; d <= 8; ++d) EXPECT_EQ(simplex_rule(2, d).size(), triangle[d]);
  for (int d = 0; d <= 6; ++d) EXPECT_EQ(simplex_rule(3, d).size(), tetrahedron[d]);
}

TEST(Quadrature, GaussJacobiHasKnownNodes) {
  // Two points of Gauss and Legendre on [0, 1]; the two-point rule for (1 - x): (4 -+ sqrt 6)/10.
  const IntervalRule legendre = gauss_jacobi(2, 0), jacobi = gauss_jacobi(2, 1);
  EXPECT_NEAR(legendre.points[0], 0.5 - std::sqrt(3.0) / 6, 1e-15);
  EXPECT_NEAR(jacobi.points[0], (4 - std::sqrt(6.0)) / 10, 1e-15);
  EXPECT_NEAR(jacobi.weights[0] + jacobi.weights[1], 0.5, 1e-15);
}

TEST(Quadrature, NodalRulesLieOnNodesWithPositiveWeights) {
  const int degree[3][4] = {{}, {0, 1, 1, 1}, {0, 3, 2, 1}};
  for (int order = 1; order <= 2; ++order) {
    for (int dim = 0; dim <= 3; ++dim) {
      const Quadrature rule = nodal_rule(dim, order);
      const auto nodes = nodal_rule_nodes(dim, order);
      ASSERT_EQ(nodes.size(), rule.size());
      for (std::size_t q = 0; q < rule.size(); ++q) {
        EXPECT_GT(rule.weights[q], 0);
        std::array<double, max_cell_nodes> phi{};
        lagrange_values(dim, dim == 0 ? 1 : order, rule.points[q], phi.data());
        EXPECT_EQ(phi[nodes[q]], 1.0);
      }
      if (dim == 0) continue;
      const int exact = degree[order][dim];
      for (int d = 0; d <= exact; ++d) EXPECT_LT(worst_error(rule, d), 1e-14);
      // The stated degree is not an understatement: the next one fails.
      EXPECT_GT(worst_error(rule, exact + 1), 1e-3);
    }
  }
}

/// The means of phi_i r for the shape functions at the nodes of the rule, by a rule of degree 6.
std::vector<double> means_against(int dim, int order, const std::vector<double>& r) {
  const Quadrature exact = simplex_rule(dim, 6);
  const auto nodes = nodal_rule_nodes(dim, order);
  std::vector<double> out(nodes.size(), 0.0);
  for (std::size_t q = 0; q < exact.size(); ++q) {
    std::array<double, max_cell_nodes> phi{};
    lagrange_values(dim, order, exact.points[q], phi.data());
    double at = 0;
    for (int k = 0; k <= dim; ++k) at += exact.points[q][k] * r[k];
    for (std::size_t i = 0; i < nodes.size(); ++i) out[i] += exact.weights[q] * at * phi[nodes[i]];
  }
  return out;
}

TEST(Quadrature, NodalRulesAgainstAnAffineWeightAreMeansOfShapeFunctions) {
  const std::vector<std::vector<double>> weights[] = {
      {}, {{0.3, 1.1}, {0, 2}, {1.7, 0}}, {{0.3, 1.1, 0.7}, {0, 2, 1}, {0, 0, 1}, {1, 0, 0}}};
  for (int order = 1; order <= 2; ++order) {
    for (int dim = 1; dim <= 2; ++dim) {
      for (const auto& r : weights[dim]) {
        const auto expected = means_against(dim, order, r);
        const auto found = weighted_nodal_rule(dim, order, r);
        ASSERT_EQ(found.size(), expected.size());
        double sum = 0, mean = 0;
        for (std::size_t i = 0; i < found.size(); ++i) {
          EXPECT_NEAR(found[i], expected[i], 1e-15);
          sum += found[i];
          // Only ends of edges of P2 on the axis have no weight.
          const bool end_on_axis = order == 2 && dim == 1 && i < 2 && r[i] == 0;
          EXPECT_EQ(found[i] > 0, !end_on_axis);
        }
        for (const double value : r) mean += value / (dim + 1);
        EXPECT_NEAR(sum, mean, 1e-15);
      }
    }
  }
}

TEST(Element, ReproducesPolynomialsAndItsOwnSlopes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.05, 1);
  for (int dim = 1; dim <= 3; ++dim) {
    for (int order = 1; order <= 2; ++order) {
      Barycentric p{};
      double sum = 0;
      for (int k = 0; k <= dim; ++k) sum += p[k] = uniform(random);
      for (int k = 0; k <= dim; ++k) p[k] /= sum;
      const int n = lagrange_size(dim, order);
      std::array<double, max_cell_nodes> phi{}, moved{};
      std::array<double, 4 * max_cell_nodes> slopes{};
      lagrange_values(dim, order, p, phi.data());
      lagrange_slopes(dim, order, p, slopes.data());
      EXPECT_NEAR(std::accumulate(phi.begin(), phi.begin() + n, 0.0), 1, 1e-15);
      for (int k = 0; k <= dim; ++k) {
        Barycentric q = p;
        const double h = 1e-6;
        q[k] += h;
        lagrange_values(dim, order, q, moved.data());
        for (int i = 0; i < n; ++i) {
          EXPECT_NEAR((moved[i] - phi[i]) / h, slopes[i * (dim + 1) + k], 1e-5);
        }
      }
    }
  }
}

} // namespace
} // namespace hvi::solver
