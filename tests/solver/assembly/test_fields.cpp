// Integrals, point values, cell averages and nodal values of expressions of fields.
#include "tests/solver/assembly/reference.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

using namespace test;

Expr u(int i) { return Expr::variable(slot::field(0, slot::value(i))); }
Expr du(int i, int j) { return Expr::variable(slot::field(0, slot::gradient(i, j))); }
Expr rate(int i) { return Expr::variable(slot::field(1, slot::value(i))); }

struct FieldCase : ::testing::TestWithParam<std::tuple<int, int>> {
  int dim = std::get<0>(GetParam()), order = std::get<1>(GetParam());
  Mesh mesh = skew_mesh(dim, 2);
  Space space = make_space(mesh, order, dim);
  std::vector<Expr> exact = field();
  Vector displacement = interpolate(space, exact, 0, Origin{});
  Vector velocity = 2 * displacement;
  std::vector<const Vector*> vectors{&displacement, &velocity};
  FieldValues values{vectors, 0.5};

  std::vector<Expr> field() const {
    const Expr q = order == 1 ? Expr(0.5) : x;
    const std::vector<Expr> all{x * q + Expr(1.0), Expr(2.0) * x - y * q, z - q};
    return {all.begin(), all.begin() + dim};
  }
  /// The same expression with the fields replaced by the polynomials they are.
  Expr in_position(const Expr& e) const {
    std::vector<std::pair<Slot, Expr>> replace;
    for (int i = 0; i < dim; ++i) {
      replace.emplace_back(slot::field(0, i), exact[i]);
      replace.emplace_back(slot::field(1, i), Expr(2.0) * exact[i]);
      for (int j = 0; j < dim; ++j) {
        replace.emplace_back(slot::field(0, slot::gradient(i, j)), derivative(exact[i], j));
      }
    }
    return substitute(e, replace);
  }
  double slow_integral(const Region& region, const Expr& e) const {
    const Expr g = in_position(e);
    double sum = 0;
    for (const auto& entity : slow_entities(mesh, region)) {
      for (const auto& [p, w] : slow_points(entity.corners)) {
        sum += w * slow_value(g, p, entity.normal, values.t);
      }
    }
    return sum;
  }
};

TEST_P(FieldCase, IntegralsOfPolynomialsAreExact) {
  const Expr n = Expr::variable(slot::normal(0)), last = u(dim - 1), slope = du(0, dim - 1);
  const std::vector<Expr> integrands{
      Expr(1.0),                            // constant
      u(0) + Expr(2.0) * rate(0),           // linear: a weight vector
      x * x * slope - last / Expr(4.0) + x, // affine
      u(0) * u(0) + slope * slope,          // quadratic: the tape
      t * u(0) * x + t,                     // linear with time: the tape
      u(0) * n + x * n,                     // with a normal
  };
  for (const Region& region : {all_cells(mesh), skin(mesh)}) {
    const bool cells = region.kind == Group::Kind::cells;
    Integrator integrator(space, region, Rule::exact, integrands);
    std::vector<double> out(integrands.size());
    for (int repeat = 0; repeat < 2; ++repeat) integrator.integrate(values, out);
    for (std::size_t k = 0; k + (cells ? 1 : 0) < integrands.size(); ++k) {
      const double expected = slow_integral(region, integrands[k]);
      EXPECT_NEAR(out[k], expected, 1e-12 * (1 + std::abs(expected))) << k;
    }
  }
}

TEST_P(FieldCase, KinksAreNotTakenForLinear) {
  const std::vector<Expr> kinks{abs(u(0) - Expr(1.2)), max(u(0), Expr(1.3)),
                                select(less(u(0), Expr(1.3)), Expr(0.0), Expr(1.0))};
  Integrator integrator(space, all_cells(mesh), Rule::midpoint, kinks);
  std::vector<double> out(kinks.size());
  integrator.integrate(values, out);
  for (std::size_t k = 0; k < kinks.size(); ++k) {
    double sum = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      Point middle{};
      for (int v = 0; v <= dim; ++v) {
        for (int j = 0; j < 3; ++j) middle[j] += mesh.nodes[mesh.cells[c][v]][j] / (dim + 1);
      }
      sum += cell_measure(mesh, static_cast<int>(c)) *
             slow_value(in_position(kinks[k]), middle, {}, values.t);
    }
    EXPECT_NEAR(out[k], sum, 1e-13) << k;
  }
}

TEST_P(FieldCase, PointValues) {
  const CellLocator locator(mesh);
  std::array<double, 4> barycentric{};
  const Expr e = u(0) * x + du(dim - 1, 0) * t + rate(dim - 1);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    Point p{};
    for (int k = 0; k <= dim; ++k) {
      const double weight = (k + 1) * 2.0 / ((dim + 1) * (dim + 2));
      for (int j = 0; j < 3; ++j) p[j] += weight * mesh.nodes[mesh.cells[c][k]][j];
    }
    const int cell = locator.find(p, barycentric);
    ASSERT_EQ(cell, static_cast<int>(c));
    EXPECT_NEAR(PointValue(space, e, cell, barycentric)(values),
                slow_value(in_position(e), p, {}, values.t), 1e-13);
  }
}

TEST_P(FieldCase, CellAveragesTimesMeasureAreIntegrals) {
  const std::vector<Expr> components{du(0, 0), u(0) * u(dim - 1)};
  const auto average = cell_values(space, components, values);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const Region one{Group::Kind::cells, {static_cast<std::int32_t>(c)}, 0};
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(average[2 * c + k] * cell_measure(mesh, static_cast<int>(c)),
                  slow_integral(one, components[k]), 1e-13);
    }
  }
}

TEST_P(FieldCase, NodalValues) {
  const std::vector<Expr> values_only{u(0) * x, rate(dim - 1) - t};
  const auto plain = nodal_values(space, values_only, values);
  for (std::size_t i = 0; i < space.nodes.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(plain[2 * i + k],
                  slow_value(in_position(values_only[k]), space.nodes[i], {}, values.t), 1e-13);
    }
  }
  // Every cell has the same gradient of a polynomial of the space, so the mean is that gradient.
  const std::vector<Expr> gradient{du(dim - 1, 0)};
  const auto mean = nodal_values(space, gradient, values);
  for (std::size_t i = 0; i < space.nodes.size(); ++i) {
    EXPECT_NEAR(mean[i], slow_value(in_position(gradient[0]), space.nodes[i], {}, values.t), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(DimAndOrder, FieldCase,
                         ::testing::Combine(::testing::Values(1, 2, 3), ::testing::Values(1, 2)));

TEST(Fields, NodalMeanWeighsByMeasure) {
  // u = |x| on cells of length 1 and 3: slopes -1 and 1, the mean at 0 is (-1 + 3) / 4.
  Mesh mesh = structured_mesh(1, {std::vector<double>{-1, 0, 3}, {}, {}});
  const Space space = make_space(mesh, 1, 1);
  const Vector w = interpolate(space, std::vector<Expr>{abs(x)}, 0, Origin{});
  const std::vector<const Vector*> vectors{&w};
  const auto mean = nodal_values(space, std::vector<Expr>{du(0, 0)}, {vectors, 0});
  EXPECT_NEAR(mean[1], 0.5, 1e-15);
}

TEST(Fields, AbsentFieldsAndSlotsAreErrors) {
  const Mesh mesh = box_mesh(2, {1, 1, 0});
  const Space space = make_space(mesh, 1, 2);
  const Vector w = Vector::Zero(space.n_dofs()), empty;
  const std::vector<const Vector*> vectors{&w, &empty};
  const FieldValues values{vectors, 0};
  std::vector<double> out(1);
  EXPECT_THROW(cell_values(space, std::vector<Expr>{rate(0)}, values), Failure);
  EXPECT_THROW(Integrator(space, skin(mesh), Rule::exact, {rate(0)}).integrate(values, out),
               Failure);
  EXPECT_THROW(
      cell_values(space, std::vector<Expr>{Expr::variable(slot::multiplier(0, 0))}, values),
      Failure);
  EXPECT_THROW(cell_values(space, std::vector<Expr>{du(0, 2)}, values), Failure);
}

} // namespace
} // namespace hvi::solver
