// What laws read of the solution.
#include "solver/formulation/formulation.hpp"
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The slope 3 u_y - 2 u_x where u = (0.2, -0.7), and by what forces could add to u.
TEST(LawReadings, SourcesHaveTheSizeOfTheirTerms) {
  auto plan = slab(2, 1);
  LawSpec source;
  source.name = "source";
  source.readings = {u_value(0), u_value(1)};
  source.expression =
      (3.0 * var(slot::reading(1)) - 2.0 * var(slot::reading(0))) * var(slot::argument(0));
  plan.problem.laws = {source};
  plan.options.proportional_path = false;
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  const auto formulation = formulate(plan, d);
  Contact& contact = formulation->contact();
  ASSERT_EQ(contact.readings.size(), 1U);
  LawReadings& readings = contact.readings.front();
  const SparseMatrix& trace = readings.trace();
  Vector u = Vector::Constant(trace.cols(), 0.2);
  for (int row = 1; row < trace.rows(); row += 2) // those of u_y
    for (SparseMatrix::InnerIterator it(trace, row); it; ++it) u[it.col()] = -0.7;
  const LawFields fields(u);
  const auto none = [](int) { return 0.0; };
  readings.read(0.0, fields, [](int, int, int) { return 0.0; });
  EXPECT_NEAR(readings.at(0)[0], 0.2, 1e-15);
  EXPECT_NEAR(readings.at(0)[1], -0.7, 1e-15);
  EXPECT_NEAR(readings.slope_scale(fields, {}, none), 3.0 * 0.7 + 2.0 * 0.2, 1e-14);
  const Vector reach = Vector::Constant(u.size(), 0.1);
  EXPECT_NEAR(readings.slope_scale(fields, reach, none),
              3.0 * (0.7 + fields.factor(field_of_u(0)) * 0.1) +
                  2.0 * (0.2 + fields.factor(field_of_u(0)) * 0.1),
              1e-14);
}

} // namespace
} // namespace hvi::solver
