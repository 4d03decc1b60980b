// Did a step cross unstable states? One point whose energy along the step is known by hand.
#include "solver/step/snap.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

/// Slope 50 r up to .01, falling by 2 per unit up to .2, then constant; on one unknown, weight 1.
Contact softening() {
  const Expr r = Expr::variable(slot::argument(0));
  LawSpec spec;
  spec.name = "soft";
  spec.by_slope = true;
  spec.expression =
      select(less(r, Expr(0.01)), Expr(50.0) * r,
             select(less(r, Expr(0.2)), Expr(0.5) - Expr(2.0) * (r - Expr(0.01)), Expr(0.12)));
  Contact out;
  out.laws.push_back(std::make_unique<Law>(spec));
  out.problem.laws = {out.laws[0].get()};
  out.problem.graphs = {out.laws[0]->graph({}, 0.0)};
  ContactPoint point;
  point.rows = 1;
  point.weight = 1.0;
  out.problem.points = {point};
  out.problem.g.resize(1, 1);
  out.problem.g.insert(0, 0) = 1.0;
  out.softening = {2.0};
  return out;
}

/// Of a step from z0 by d on a body of this stiffness.
bool snaps(double z0, double d, double stiffness) {
  Contact contact = softening();
  contact.problem.offset = Vector::Constant(1, z0);
  Vector dz;
  const bool out = is_snap(contact, Vector::Constant(1, d), stiffness * d * d, dz);
  EXPECT_EQ(dz[0], d);
  return out;
}

TEST(IsSnap, WhereTheBodyIsSofterThanTheLawFalls) {
  EXPECT_TRUE(snaps(0.05, 0.1, 1.9));
  EXPECT_FALSE(snaps(0.05, 0.1, 2.1));
  EXPECT_TRUE(snaps(0.15, -0.1, 1.9)); // back along the same states
  EXPECT_FALSE(snaps(0.15, -0.1, 2.1));
}

TEST(IsSnap, LooksAtTheStatesOfTheStepOnly) {
  EXPECT_FALSE(snaps(0.0, 0.009, 0.1)); // before the law falls
  EXPECT_TRUE(snaps(0.0, 0.03, 0.1));   // beyond its top
  EXPECT_FALSE(snaps(0.3, 0.05, 0.1));  // after it
  EXPECT_TRUE(snaps(0.3, -0.15, 0.1));  // back into it
  EXPECT_FALSE(snaps(0.008, -0.006, 0.1));
}

TEST(IsSnap, NothingMoves) { EXPECT_FALSE(snaps(0.05, 0.0, 1.0)); }

} // namespace
} // namespace hvi::solver
