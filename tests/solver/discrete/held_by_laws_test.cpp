// Bodies that laws alone hold: their motions, what laws can balance, and what is refused.
#include "solver/common/numbers.hpp"
#include "solver/discrete/held_by_laws.hpp"
#include "solver/discrete/nearest_point.hpp"
#include "solver/law/slope_bounds.hpp"
#include "tests/solver/time/plans.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;
using testing::HasSubstr;

Vector vector(std::initializer_list<double> values) {
  Vector out(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), out.begin());
  return out;
}

/// The slab on its ground with these values only.
RigidMotions motions_of(Plan plan, std::vector<DirichletSpec> values, Discretisation& d) {
  plan.problem.space.dirichlet = std::move(values);
  plan.problem.law_terms.clear();
  plan.problem.loads.clear();
  plan.report = {};
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  return RigidMotions(d, 0);
}

TEST(RigidMotions, AreThoseThatImposedValuesAllow) {
  Discretisation clamped, sliding, turning, loose;
  EXPECT_EQ(motions_of(slab(4, 4), {clamp(roof)}, clamped).count(), 0);
  const auto along = motions_of(slab(4, 4), {clamp(roof, 1)}, sliding);
  ASSERT_EQ(along.count(), 1);
  EXPECT_EQ(along.describe(vector({1.0})), "the body moves along x");
  EXPECT_EQ(motions_of(slab(4, 4), {}, loose).count(), 3);
  auto plan = slab(4, 4);
  PartSpec corner{"corner", {}, {}};
  corner.region.kind = RegionSpec::Kind::point;
  corner.region.point = {0, 1, 0};
  plan.problem.parts.push_back(corner);
  const auto about = motions_of(plan, {clamp(4)}, turning);
  ASSERT_EQ(about.count(), 1);
  EXPECT_THAT(about.describe(vector({1.0})), HasSubstr("the body turns about (0, 1)"));
  // Which way round: by what the motion does to the node below the corner.
  std::vector<std::int32_t> below;
  for (std::size_t node = 0; node < turning.space.nodes.size(); ++node)
    if (turning.space.nodes[node] == Point{0, 0, 0})
      below = {turning.space.dof(static_cast<int>(node), 0)};
  const double along_x = about.on(below)(0, 0);
  ASSERT_GT(std::abs(along_x), 0.1);
  const double clockwise = along_x < 0.0 ? 1.0 : -1.0;
  EXPECT_THAT(about.describe(vector({clockwise})), testing::EndsWith("clockwise"));
  EXPECT_THAT(about.describe(vector({-clockwise})), Not(HasSubstr("clockwise")));
}

/// A box held at two corners turns about the line through them, which does not meet its centre.
TEST(RigidMotions, OfABoxHeldAtTwoCornersTurnAboutTheirLine) {
  auto plan = slab(2, 1, 3);
  PartSpec corner{"corner", {}, {}};
  corner.region.kind = RegionSpec::Kind::point;
  const auto about = [&](const Point& a, const Point& b) {
    auto held = plan;
    for (const Point& x : {a, b}) {
      corner.region.point = x;
      held.problem.parts.push_back(corner);
    }
    Discretisation d;
    const auto motions = motions_of(held, {clamp(4), clamp(5)}, d);
    return motions.count() == 1 ? motions.describe(vector({1.0})) : "not one motion";
  };
  EXPECT_THAT(about({0, 0, 0}, {0, 1, 0}), HasSubstr("turns about the line through (0, 0.5, 0)"));
  EXPECT_THAT(about({0, 1, 1}, {2, 1, 1}), HasSubstr("turns about the line through (1, 1, 1)"));
  EXPECT_THAT(about({2, 1, 0}, {2, 1, 1}), HasSubstr("turns about the line through (2, 1, 0.5)"));
}

/// Of two pieces the lower one is free: it is told by its name, or by where its middle is.
TEST(RigidMotions, OfPiecesAreToldByNameOrPlace) {
  Discretisation d;
  const auto named = motions_of(two_blocks(2, 1, 2), {clamp(roof)}, d);
  ASSERT_EQ(named.count(), 3);
  d.mesh.groups.erase("lower");
  const RigidMotions placed(d, 0);
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(named.describe(Vector::Unit(3, i)), HasSubstr("the piece `lower`"));
    EXPECT_THAT(placed.describe(Vector::Unit(3, i)), HasSubstr("the piece around (1, -0.5)"));
  }
}

/// An unknown that lives on the upper of two pieces has no motions of the lower one.
TEST(RigidMotions, OfAnUnknownAreThoseOfItsPieces) {
  auto plan = two_blocks(2, 1, 2);
  plan.problem.parts.push_back(group("above", "upper"));
  plan.problem.space.more = {{"theta", "W", {}, false, 1, 5}};
  Discretisation d;
  ASSERT_EQ(motions_of(plan, {}, d).count(), 6);
  const RigidMotions of_theta(d, 1);
  ASSERT_EQ(of_theta.count(), 1);
  EXPECT_THAT(of_theta.describe(vector({1.0})),
              HasSubstr("a constant is added to the piece `upper`"));
}

/// Two squares that meet at a corner: a node of both is one of the square where the unknown lives,
/// whichever comes first.
TEST(RigidMotions, OfAnUnknownBesideAPieceThatItDoesNotHave) {
  const auto path = std::filesystem::path(testing::TempDir()) / "hvi_corner.msh";
  std::ofstream(path) << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n"
                         "2 1 \"first\"\n2 2 \"second\"\n$EndPhysicalNames\n$Nodes\n7\n"
                         "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 2 1 0\n6 1 2 0\n7 2 2 0\n"
                         "$EndNodes\n$Elements\n4\n1 2 2 1 1 1 2 4\n2 2 2 1 1 1 4 3\n"
                         "3 2 2 2 2 4 5 7\n4 2 2 2 2 4 7 6\n$EndElements\n";
  for (const int order : {1, 2})
    for (const char* const piece : {"first", "second"}) {
      auto plan = slab(1, 1);
      plan.problem.mesh = {};
      plan.problem.mesh.kind = MeshSpec::Kind::file;
      plan.problem.mesh.path = path.string();
      plan.problem.parts = {all_cells("all"), group("warm", piece)};
      plan.problem.space.order = order;
      plan.problem.space.more = {{"theta", "W", {}, false, 1, 1}};
      Discretisation d;
      ASSERT_EQ(motions_of(plan, {}, d).count(), 4); // a hinge at the corner
      const RigidMotions of_theta(d, 1);
      ASSERT_EQ(of_theta.count(), 1) << piece;
      EXPECT_EQ(of_theta.describe(vector({1.0})),
                fmt::format("`theta`: a constant is added to the piece `{}`", piece));
    }
}

/// Rigid: no strain in any cell, whatever the amplitudes.
TEST(RigidMotions, StrainNothing) {
  Discretisation d;
  const auto motions = motions_of(slab(4, 4), {}, d);
  const SparseMatrix strain = gram_of_unknown(d.space, 0, false);
  std::vector<std::int32_t> dofs(static_cast<std::size_t>(d.space.n_dofs()));
  for (std::size_t i = 0; i < dofs.size(); ++i) dofs[i] = static_cast<std::int32_t>(i);
  const DenseMatrix all = motions.on(dofs);
  EXPECT_LT((strain * all).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_GT(all.colwise().norm().minCoeff(), 0.5);
}

/// Against a set whose nearest point is known: the box [-1, 1]^2 with a ray along y from it.
TEST(NearestPoint, OfABoxWithARay) {
  const auto support = [](const Vector& y) -> Support {
    if (y[1] > 1e-12 * y.norm()) return {vector({0.0, 1.0}), true};
    return {vector({y[0] > 0.0 ? 1.0 : -1.0, -1.0}), false};
  };
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-3.0, 3.0);
  for (int i = 0; i < 200; ++i) {
    const Vector b = vector({draw(random), draw(random)});
    const Vector nearest = vector({std::clamp(b[0], -1.0, 1.0), std::max(b[1], -1.0)});
    const auto found = nearest_point(b, Vector::Zero(2), support);
    EXPECT_EQ(found.outside, (b - nearest).norm() > 0.0);
    if (found.outside) {
      EXPECT_LT((found.apart - (b - nearest)).norm(), 1e-9);
    }
  }
}

/// The cone |y| <= x / 2 in space, whose rays are no polytope's.
TEST(NearestPoint, OfARoundCone) {
  const auto support = [](const Vector& y) -> Support {
    const double across = std::hypot(y[1], y[2]);
    Vector ray =
        vector({1.0, 0.5 * y[1] / std::max(across, 1e-300), 0.5 * y[2] / std::max(across, 1e-300)});
    ray.normalize();
    if (ray.dot(y) > 1e-12 * y.norm()) return {ray, true};
    return {Vector::Zero(3), false};
  };
  std::mt19937 random(11);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const Vector b = vector({draw(random), draw(random), draw(random)});
    const double excess = std::hypot(b[1], b[2]) - 0.5 * b[0];
    if (std::abs(excess) < 1e-3) continue;
    const auto found = nearest_point(b, Vector::Zero(3), support);
    EXPECT_EQ(found.outside, excess > 0.0) << b.transpose();
  }
}

/// A block under glue that hangs on it, with friction whose bound is the multiplier of the glue by
/// a factor, where it presses (`pressing`) or wherever it acts.
Plan hanging(bool pressing, double sign) {
  const Expr r = var(slot::argument(0)), bound = sign * var(slot::coupled);
  Plan plan = slab(2, 1);
  plan.problem.time = {};
  plan.problem.histories.clear();
  plan.problem.forms = {elastic(2, body, field_of_u(0), from_young(70, 0.3))};
  plan.problem.space.dirichlet.clear();
  LawSpec glue, slip;
  glue.name = "layer", glue.by_slope = true;
  glue.expression = sign > 0.0 ? select(less(r, 0.0), max(100.0 * r, -50.0), 0.0)
                               : select(less(r, 0.0), 0.0, min(100.0 * r, 50.0));
  slip.name = "slip", slip.radial = slip.by_slope = true, slip.coupled = "layer";
  slip.expression = 0.5 * (pressing ? max(bound, 0.0) : abs(bound));
  plan.problem.laws = {glue, slip};
  plan.problem.law_terms = {normal_term(0, ground, 2, sign), tangential_term(1, ground, 2)};
  plan.problem.loads = {force(body, {0.2, 1.0})};
  plan.report.probes = {integral("up", var(slot::multiplier(0, 0)), ground),
                        integral("along", var(slot::multiplier(1, 0)), ground)};
  plan.report.tables = {{{}, {0, 1}, 1, false, ""}};
  return plan;
}

/// Friction under pull has the bound that its law has there, whichever sign of the multiplier
/// pulls: none where the law asks for pressure.
TEST(HeldByLaws, FrictionUnderPullHasItsOwnBound) {
  for (const double sign : {1.0, -1.0}) {
    const RunResult held = solve(hanging(false, sign));
    EXPECT_NEAR(held.final.at("up"), -sign * 2.0, 1e-9);
    EXPECT_NEAR(held.final.at("along"), 0.4, 1e-9);
    try {
      solve(hanging(true, sign));
      FAIL() << "nothing holds it";
    } catch (const Failure& failure) {
      EXPECT_THAT(failure.what(), HasSubstr("cannot balance its load: the body moves along"));
    }
  }
}

LawGraph graph_of(const Law& law) { return law.graph({}, 0.0); }

TEST(SlopeBounds, OfLawsThatGrowFallAndStop) {
  const Expr r = var(slot::argument(0));
  const Law spring({"spring", {}, false, false, 0.5 * r * r});
  auto bounds = slope_bounds(spring, graph_of(spring));
  EXPECT_EQ(bounds.low, -infinity);
  EXPECT_EQ(bounds.high, infinity);
  const Law bounded({"bounded", {}, false, true, r / sqrt(1.0 + r * r)});
  bounds = slope_bounds(bounded, graph_of(bounded));
  EXPECT_LE(bounds.low, -1.0 + 1e-12); // within the tenth of what is sampled
  EXPECT_GE(bounds.low, -1.1);
  EXPECT_GE(bounds.high, 1.0 - 1e-12);
  EXPECT_LE(bounds.high, 1.1);
  EXPECT_NEAR(bounds.at_plus, 1.0, 1e-12);
  // r exp(-r^2): up to 1/sqrt(2 e) = 0.4289, back to 0.
  const Law falls({"falls", {}, false, true, r * exp(-r * r)});
  bounds = slope_bounds(falls, graph_of(falls));
  EXPECT_GE(bounds.high, 0.42888);
  EXPECT_LE(bounds.high, 0.48);
  EXPECT_NEAR(bounds.at_plus, 0.0, 1e-12);
}

} // namespace
} // namespace hvi::solver
