// Laws: breaks, Clarke intervals, potentials, constants; a conformance suite over every kind.
#include "laws.hpp"
#include "solver/kernel/table.hpp"
#include "solver/law/known_constants.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace hvi::solver::test {
namespace {

const Point here{0.5, 0.0, 0.0};
constexpr double now = 0.25;

class EveryLaw : public testing::TestWithParam<KnownLaw> {
protected:
  Law law{GetParam().spec};
  LawGraph graph = law.graph(here, now);
  std::vector<double> arguments() const {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> exponent(-6, 3);
    std::vector<double> out;
    for (int k = 0; k < 400; ++k) {
      const double r = std::pow(10.0, exponent(random));
      out.push_back(law.spec().radial || k % 2 ? r : -r);
    }
    return out;
  }
};

TEST_P(EveryLaw, FindsTheBreaksExactly) { EXPECT_EQ(graph.breaks, GetParam().breaks); }

TEST_P(EveryLaw, SlopeAgreesWithThePlainFunction) {
  for (const double r : arguments()) {
    const double expected = GetParam().slope(r);
    EXPECT_NEAR(law.slope(graph, piece_of(graph, r), r), expected,
                1e-13 * (1 + std::abs(expected)));
    const Interval i = clarke(law, graph, r);
    EXPECT_EQ(i.low, i.high);
  }
}

TEST_P(EveryLaw, CurvatureIsTheDifferenceQuotientOfTheSlope) {
  for (const double r : arguments()) {
    const int piece = piece_of(graph, r);
    const double h = 1e-5 * std::abs(r);
    if (piece_of(graph, r - h) != piece || piece_of(graph, r + h) != piece) continue;
    const double quotient =
        (law.slope(graph, piece, r + h) - law.slope(graph, piece, r - h)) / (2 * h);
    const double scale = std::abs(law.slope(graph, piece, r)) / std::abs(r) + std::abs(quotient);
    EXPECT_NEAR(law.curvature(graph, piece, r), quotient, 1e-7 * scale + 1e-9) << r;
  }
}

TEST_P(EveryLaw, PotentialAgreesUpToAConstantAndIsContinuous) {
  const auto j = [&](double r) { return law.potential(graph, piece_of(graph, r), r); };
  const double constant = j(0.0) - GetParam().potential(0.0);
  for (const double r : arguments()) {
    const double expected = GetParam().potential(r);
    EXPECT_NEAR(j(r) - constant, expected, 1e-11 * (1 + std::abs(expected))) << r;
  }
  for (int i = 0; i < static_cast<int>(graph.breaks.size()); ++i) {
    const double b = graph.breaks[i], v = law.potential(graph, i, b);
    EXPECT_NEAR(v, law.potential(graph, i + 1, b), 1e-12 * (1 + std::abs(v)));
  }
  if (law.spec().by_slope) {
    EXPECT_EQ(j(0.0), 0.0);
  }
}

/// j(a) - j(b) lies between the Clarke derivatives on the way (Lebourg), here by dense sampling.
TEST_P(EveryLaw, ClarkeIntervalIsTheHullOfNearbySlopes) {
  for (std::size_t i = 0; i < graph.breaks.size(); ++i) {
    const double b = graph.breaks[i], h = 1e-9 * (std::abs(b) + 1e-3);
    const double below = GetParam().slope(b - h), above = GetParam().slope(b + h);
    const Interval hull = clarke(law, graph, b);
    EXPECT_NEAR(hull.low, std::min(below, above), 1e-6 * (1 + std::abs(below)));
    EXPECT_NEAR(hull.high, std::max(below, above), 1e-6 * (1 + std::abs(above)));
  }
}

TEST_P(EveryLaw, ConstantsBoundTheLawAndAreAttained) {
  const KnownConstants k = known_constants(law, here, now);
  const KnownLaw& known = GetParam();
  const auto check = [](double value, double expected, const char* what) {
    if (std::isnan(expected)) return;
    if (std::isinf(expected))
      EXPECT_EQ(value, expected) << what;
    else
      EXPECT_NEAR(value, expected, 1e-9 * (1 + std::abs(expected))) << what;
  };
  if (k.m.how() == Provenance::proved) check(k.m.value(), known.m, "m");
  check(k.c.value(), known.c, "c");
  check(k.steepest_ascent.value(), known.ascent, "ascent");
  EXPECT_EQ(k.clarke_regular, known.regular);
  EXPECT_LE(k.m.low, known.m * (1 + 1e-15));
  EXPECT_GE(k.m.high, known.m * (1 - 1e-15));
  const auto rs = arguments();
  for (const double a : rs) {
    EXPECT_LE(std::abs(known.slope(a)), k.c.value() * (1 + std::abs(a)) * (1 + 1e-12));
    for (const double b : {rs[0], rs[1], a * 1.01}) {
      if (a == b) continue;
      const double product = (known.slope(a) - known.slope(b)) * (a - b);
      EXPECT_GE(product, -k.m.value() * (1 + 1e-9) * (a - b) * (a - b) - 1e-18);
    }
  }
}

TEST_P(EveryLaw, DistanceIsZeroOnTheGraphAndTheErrorOffIt) {
  const bool radial = law.spec().radial;
  for (const double r : arguments()) {
    const double s = GetParam().slope(r), slack = 1e-13 * (1 + std::abs(s));
    if (!radial) {
      const double off = s + 0.5;
      EXPECT_LE(inclusion_distance(law, graph, &r, &s, 1, 0.0), slack);
      EXPECT_NEAR(inclusion_distance(law, graph, &r, &off, 1, 0.0), 0.5, slack);
      continue;
    }
    const double z[3] = {0.6 * r, 0.0, -0.8 * r}, xi[3] = {0.6 * s, 0.0, -0.8 * s};
    const double turned[3] = {0.6 * s, 0.25, -0.8 * s};
    EXPECT_LE(inclusion_distance(law, graph, z, xi, 3, 0.0), slack);
    EXPECT_NEAR(inclusion_distance(law, graph, z, turned, 3, 0.0), 0.25, slack);
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw, testing::ValuesIn(known_laws()), [](const auto& named) {
  std::string name = named.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
  return name;
});

// A certificate must not take what is no number for a multiplier of the law.
TEST(Law, WhatIsNoNumberIsFarFromEveryGraph) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  LawSpec friction, spring;
  friction.radial = true, friction.expression = 0.3 * Expr::variable(slot::r);
  spring.expression = 2.0 * Expr::variable(slot::r) * Expr::variable(slot::r);
  const double still[] = {0.0, 0.0}, moved[] = {0.1, 0.0}, one[] = {none, 0.0},
               both[] = {none, none};
  for (const LawSpec& spec : {friction, spring}) {
    const Law law(spec);
    const LawGraph g = law.graph({}, 0.0);
    for (const double* z : {still, moved})
      for (const double* xi : {one, both})
        EXPECT_GT(inclusion_distance(law, g, z, xi, spec.radial ? 2 : 1, 0.1), 1e300);
  }
}

TEST(Law, BallAtTheOriginOfARadialLaw) {
  const Law law = slope_law("weakening", Expr(0.5) + Expr(0.2) * exp(Expr(-20.0) * arg()), true);
  const LawGraph g = law.graph({}, 0.0);
  const double z[2] = {0.0, 0.0}, inside[2] = {0.5, -0.4}, outside[2] = {0.0, 0.9};
  EXPECT_EQ(inclusion_distance(law, g, z, inside, 2, 0.0), 0.0);
  EXPECT_NEAR(inclusion_distance(law, g, z, outside, 2, 0.0), 0.2, 1e-15);
}

/// Friction that begins as a root: a slip below the rounding of z moves it visibly, and z = 0 is as
/// near to it as a law of a number that rises in the same way finds.
TEST(Law, AsMuchIsKnownOfARestingVectorAsOfANumber) {
  const Expr bound = Expr(1.0) + sqrt(arg());
  const Law radial = slope_law("radial", bound, true);
  const Law scalar = slope_law("scalar", select(less(arg(), Expr(0.0)), Expr(-1.0), bound));
  const double near = 1e-12, still[2] = {0.0, 0.0};
  for (const double part : {0.0, 0.3, 0.9, 1.1, 4.0}) {
    const double size = 1.0 + std::sqrt(part * near), xi[2] = {0.6 * size, -0.8 * size};
    const double of_number =
        inclusion_distance(scalar, scalar.graph({}, 0.0), still, &size, 1, near);
    EXPECT_NEAR(inclusion_distance(radial, radial.graph({}, 0.0), still, xi, 2, near), of_number,
                1e-15);
    EXPECT_EQ(of_number > 1e-15, part > 1.0);
  }
  const Law rises =
      slope_law("rises", select(less(arg(), Expr(near / 2)), Expr(1.0), Expr(2.0)), true);
  const double between[2] = {1.5, 0.0}, most[2] = {2.5, 0.0};
  EXPECT_EQ(inclusion_distance(rises, rises.graph({}, 0.0), still, between, 2, near), 0.0);
  EXPECT_EQ(inclusion_distance(rises, rises.graph({}, 0.0), still, most, 2, near), 0.5);
}

/// A slow slip, whose direction is known up to a turn that moves it by `snap`: a slope that has
/// turned so is on the graph, one that has turned more is as far from it as from the last of these.
TEST(Law, ASlowSlipMayTurnAsFarAsItIsKnown) {
  const Law pulls = slope_law("pulls", Expr(-3.0), true), rubs = slope_law("rubs", Expr(3.0), true);
  const double snap = 1e-12, r = 4e-12, most = 2.0 * std::asin(0.5 * snap / r);
  const double z[3] = {0.6 * r, 0.0, -0.8 * r}, aside[3] = {0.8, 0.0, 0.6};
  for (const Law* law : {&rubs, &pulls})
    for (const double turn : {0.0, 1e-9, 0.1, 0.999 * most, 1.5 * most, 1.0}) {
      const double slope = law == &rubs ? 3.0 : -3.0;
      double xi[3];
      for (int k = 0; k < 3; ++k)
        xi[k] = slope * (std::cos(turn) * z[k] / r + std::sin(turn) * aside[k]);
      const double further = std::max(0.0, turn - most);
      EXPECT_NEAR(inclusion_distance(*law, law->graph({}, 0.0), z, xi, 3, snap),
                  6.0 * std::sin(0.5 * further), 1e-14);
    }
}

TEST(Law, DropsFalseBreaks) {
  const Expr r = arg();
  const Law law = slope_law("seam", select(less(r, Expr(1.0)), r * Expr(2.0), r * Expr(2.0)) +
                                        max(r, Expr(-3.0)) - max(r, Expr(-3.0)));
  EXPECT_TRUE(law.graph({}, 0.0).breaks.empty());
}

TEST(Law, FindsRootsOfNonlinearSwitches) {
  const Expr r = arg();
  // exp(r) < 3 at log 3, r^2 < 4 at -2 and 2, both to the last bits.
  const Law law =
      slope_law("curved", select(less(exp(r), Expr(3.0)), Expr(0.0), r) + max(r * r, Expr(4.0)));
  const auto breaks = law.graph({}, 0.0).breaks;
  ASSERT_EQ(breaks.size(), 3u);
  EXPECT_DOUBLE_EQ(breaks[0], -2.0);
  EXPECT_DOUBLE_EQ(breaks[1], std::log(3.0));
  EXPECT_DOUBLE_EQ(breaks[2], 2.0);
}

TEST(Law, FindsTheKinkOfARootOfASquare) {
  const Law law = potential_law("distance", sqrt((arg() - Expr(1.0)) * (arg() - Expr(1.0))));
  EXPECT_THAT(law.graph({}, 0.0).breaks, testing::ElementsAre(1.0));
  const auto of_power = [](double even, double exponent) {
    const Law powers = potential_law("distance", pow(pow(arg(), Expr(even)), Expr(exponent)));
    const LawGraph g = powers.graph({}, 0.0);
    const Interval all = clarke(powers, g, 0.0);
    return std::pair(all.low, all.high);
  };
  EXPECT_EQ(of_power(2.0, 0.5), std::pair(-1.0, 1.0)); // |r|
  EXPECT_EQ(of_power(4.0, 0.25), std::pair(-1.0, 1.0));
  EXPECT_EQ(of_power(2.0, 0.75), std::pair(0.0, 0.0)); // |r|^1.5
}

/// Far out a slope of polynomials rises or falls by the sign and the degree of its first term.
TEST(Law, PolynomialsThatRiseOnOneSideDoNotDescendThere) {
  const Expr r = arg();
  const auto descent = [&](const Expr& below, const Expr& above) {
    const Law law = slope_law("curved", select(less(r, Expr(0.0)), below, above));
    return known_constants(law, {}, 0.0).m.value();
  };
  const Expr square = r * r, cube = r * r * r;
  EXPECT_EQ(descent(-square, square), 0.0);
  EXPECT_EQ(descent(cube, cube), 0.0);
  EXPECT_EQ(descent(-square - 3.0 * r, r), 3.0);
  EXPECT_EQ(descent(cube + 2.0 * square, r), 4.0 / 3.0); // at -2/3
  for (const auto& [below, above] :
       {std::pair(square, square), {-square, -square}, {-cube, cube}, {cube, -cube}})
    EXPECT_TRUE(std::isinf(descent(below, above)));
}

TEST(Law, TablesArePiecewisePolynomials) {
  using Kind = Table::Interpolation;
  const auto table = std::make_shared<const Table>("p", std::vector<double>{0, 1, 3},
                                                   std::vector<double>{0, 2, 1}, Kind::linear);
  const Expr inside = max(min(arg(), Expr(3.0)), Expr(0.0));
  const Law law = slope_law("measured", Expr::tabulated(table, inside));
  const LawGraph g = law.graph({}, 0.0);
  EXPECT_THAT(g.breaks, testing::ElementsAre(0.0, 1.0, 3.0));
  EXPECT_DOUBLE_EQ(law.slope(g, piece_of(g, 2.0), 2.0), 1.5);
  EXPECT_DOUBLE_EQ(known_constants(law, {}, 0.0).m.value(), 0.5);
  EXPECT_EQ(known_constants(law, {}, 0.0).m.how(), Provenance::proved);
}

void expect_bad(const Expr& e, bool by_slope, const std::string& words, bool radial = false) {
  try {
    const Law law(LawSpec{"odd", Origin{42}, radial, by_slope, e});
    FAIL() << "accepted";
  } catch (const Failure& f) {
    EXPECT_EQ(f.kind, FailureKind::bad_law);
    EXPECT_EQ(f.origin.id, 42);
    EXPECT_THAT(f.what(), testing::HasSubstr(words));
    EXPECT_FALSE(f.help.empty());
  }
}

TEST(Law, RefusesWhatIsNotLocallyLipschitz) {
  const Expr r = arg();
  expect_bad(select(less(r, Expr(2.0)), r, r + Expr(0.5)), false, "jumps by 0.5 at r = 2");
  expect_bad(sqrt(abs(r)), false, "infinite or undefined at r = 0");
  expect_bad(Expr(1.0) / r, true, "infinite or undefined at r = 0");
  expect_bad(Expr::make(Op::log, {abs(r)}), true, "infinite or undefined at r = 0");
  expect_bad(sqrt(r), true, "not a finite number");
  expect_bad(Expr(1.0) / (r - Expr(3.0)), true, "at |xi| = 3", true);
}

TEST(Law, RefusesWhatIsNoNumberWhereItIsAsked) {
  const Expr r = arg();
  expect_bad(r * r / r, false, "its potential is no number at r = 0");
  expect_bad(r * r / r, false, "its potential is no number at |xi| = 0", true);
  expect_bad(Expr::make(Op::sin, {r}) / r, true, "its slope is no number at |xi| = 0", true);
}

/// What a wall or a stiff ground far away does is no size for the rounding of a jump beside it.
TEST(Law, KeepsJumpsBesideAWall) {
  const Expr r = arg();
  for (const double wall : {1e300, 1e20})
    for (const double jump : {2.0, -2.0}) {
      const Expr curved = -sqrt(Expr(1.0) - r);
      const Law law =
          slope_law("walled", select(less(r, Expr(1.0)), curved,
                                     select(less(r, Expr(2.0)), Expr(jump), Expr(wall))));
      const LawGraph g = law.graph(here, now);
      EXPECT_EQ(g.breaks, (std::vector<double>{1.0, 2.0}));
      EXPECT_EQ(g.left, (std::vector<double>{0.0, jump}));
      EXPECT_EQ(g.right, (std::vector<double>{jump, wall}));
    }
}

/// The root of 5.99 r - 5.99 a is the number before a, where the square root is none.
TEST(Law, RootsThatRoundingMissesHaveTheirLimit) {
  const double a = 0.023150638877541447, k = 5.997951875695963;
  const Expr r = arg(), root = sqrt((r - Expr(a)) * Expr(k));
  const Law cases = slope_law("cases", select(less(r, Expr(a)), Expr(0.0), root + Expr(1.0)));
  EXPECT_EQ(cases.graph(here, now).breaks, (std::vector<double>{a}));
  EXPECT_NEAR(cases.graph(here, now).right[0], 1.0, 1e-9);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0.1, 10.0);
  for (int k2 = 0; k2 < 200; ++k2) {
    const double b = any(random), c = any(random), power = any(random) / 10.1;
    const Expr inner = Expr(c) * r - Expr(b);
    const Law law = slope_law(
        "power", select(less(inner, Expr(0.0)), Expr(0.0), Expr(2.0) + pow(inner, Expr(power))));
    const LawGraph g = law.graph(here, now);
    ASSERT_EQ(g.breaks.size(), 1u);
    EXPECT_NEAR(g.right[0], 2.0, std::pow(1e-15, power) + 1e-7) << b << ' ' << c << ' ' << power;
  }
}

/// Analytic: x^a log(x)^n -> 0 for a > 0, whatever stands beside it, from either side of any break.
TEST(Law, LogarithmsThatVanishHaveTheirLimit) {
  const auto log_of = [](const Expr& e) { return Expr::make(Op::log, {e}); };
  const Expr r = arg();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(0.1, 3.0);
  for (int scene = 0; scene < 200; ++scene) {
    const double at = scene % 3 == 0 ? 0.0 : any(random) - 1.5, side = scene % 2 == 0 ? 1.0 : -1.0,
                 c = any(random), a = scene % 5 == 0 ? 0.01 : any(random), n = 1.0 + scene % 2;
    const Expr x = Expr(side) * (r - Expr(at));
    const Expr inside = Expr(c) + Expr(7.0) * pow(x, Expr(a)) * pow(log_of(Expr(c) * x), Expr(n));
    const Law law =
        slope_law("vanishing", select(less(x, Expr(0.0)), Expr(1.0), inside / (Expr(1.0) + x * x)));
    const LawGraph g = law.graph(here, now);
    ASSERT_EQ(g.breaks.size(), 1u);
    EXPECT_NEAR(side > 0.0 ? g.right[0] : g.left[0], c, 1e-14) << at << ' ' << a << ' ' << n;
    EXPECT_EQ(side > 0.0 ? g.left[0] : g.right[0], 1.0);
  }
  // by potential, whose slope is 2 r log|r| + r
  const Law square = potential_law("square", r * r * log_of(abs(r)));
  const LawGraph g = square.graph(here, now);
  EXPECT_EQ(clarke(square, g, 0.0).low, 0.0);
  EXPECT_EQ(clarke(square, g, 0.0).high, 0.0);
  for (const int piece : {0, 1}) {
    EXPECT_NEAR(square.potential(g, piece, 0.0), 0.0, 1e-300);
    EXPECT_EQ(square.slope(g, piece, 0.0), 0.0);
  }
  EXPECT_NEAR(square.potential(g, 1, 2.0), 4.0 * std::log(2.0), 1e-14);
  // of a vector, which is asked at 0 itself
  const Law radial = slope_law("radial", Expr(0.3) + r * log_of(r), true);
  const LawGraph of_vector = radial.graph(here, now);
  EXPECT_EQ(radial.slope(of_vector, 0, 0.0), 0.3);
  const double z[2] = {0.0, 0.0}, xi[2] = {0.1, 0.2};
  EXPECT_EQ(inclusion_distance(radial, of_vector, z, xi, 2, 0.0), 0.0);
  // the slope of r log(r) is log(r) + 1
  expect_bad(r * log_of(abs(r)), false, "infinite or undefined at r = 0");
  expect_bad(r * log_of(r), false, "infinite or undefined at |xi| = 0", true);
  expect_bad(pow(abs(r), Expr(1e-3)) + log_of(abs(r)), true, "infinite or undefined at r = 0");
}

TEST(Law, AcceptsRemovableSingularities) {
  const Expr r = arg();
  const Law law = slope_law("sinc", Expr::make(Op::sin, {r}) / r);
  const LawGraph g = law.graph({}, 0.0);
  EXPECT_NEAR(clarke(law, g, 0.0).high, 1.0, 1e-8);
}

TEST(Law, BreaksThatDependOnPlaceAndTimeMove) {
  const Expr bound = Expr(0.1) * x0() + time_();
  const Law law = slope_law("moving", select(less(arg(), bound), Expr(0.0), arg() - bound));
  EXPECT_TRUE(law.depends_on_x() && law.depends_on_t());
  for (const double t : {0.0, 0.5, 2.0})
    EXPECT_EQ(law.graph({3.0, 0, 0}, t).breaks.at(0), 0.1 * 3.0 + t);
}

} // namespace
} // namespace hvi::solver::test
