// Loads: totals, separation in time, means, failures.
#include "solver/kernel/table.hpp"
#include "tests/solver/assembly/reference.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

using namespace test;

Expr apply(Op op, const Expr& e) { return Expr::make(op, {e}); }

struct LoadCase : ::testing::Test {
  Mesh mesh = skew_mesh(2, 3);
  Space space = make_space(mesh, 2, 2);
  std::vector<Region> parts{all_cells(mesh), skin(mesh)};

  LoadTerm load(int part, std::vector<LoadTerm::Entry> entries) {
    LoadTerm term;
    term.origin = Origin{5};
    term.part = part;
    term.entries = std::move(entries);
    return term;
  }
  LoadAssembler assembler(const std::vector<LoadTerm>& terms) { return {space, parts, terms}; }
  /// How many vectors F_m are stored.
  static int count_vectors(LoadAssembler& a) {
    int count = 0;
    a.map([&](const Vector& f) {
      ++count;
      return f;
    });
    return count;
  }
  Vector at(const LoadAssembler& a, double time) {
    Vector f = Vector::Zero(space.n_dofs());
    a.add(time, f);
    return f;
  }
};

TEST_F(LoadCase, MatchesTheSlowAssembler) {
  const Expr n0 = Expr::variable(slot::normal(0));
  const auto volume = load(0, {{slot::value(0), x * x * t}, {slot::gradient(1, 0), y + t * t}});
  const auto traction = load(1, {{slot::value(1), t * x * n0}, {slot::gradient(0, 1), y}});
  const Vector expected =
      slow_load(space, parts[0], volume, 0.7) + slow_load(space, parts[1], traction, 0.7);
  const auto a = assembler({volume, traction});
  EXPECT_TRUE(a.separable());
  EXPECT_EQ(a.cost(volume.origin), LoadAssembler::Cost::once_per_factor);
  EXPECT_LT((at(a, 0.7) - expected).norm(), 1e-13 * expected.norm());
}

TEST_F(LoadCase, TotalIsMeasureTimesDensity) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Mesh m = skew_mesh(dim, 2);
    for (int order = 1; order <= 2; ++order) {
      for (const Rule rule : {Rule::exact, Rule::nodal, Rule::midpoint, Rule::gauss}) {
        const Space s = make_space(m, order, 1);
        const std::vector<Region> where{all_cells(m), skin(m)};
        for (int part = 0; part < 2; ++part) {
          auto term = load(part, {{slot::value(0), Expr(3.0)}});
          term.rule = rule;
          Vector f = Vector::Zero(s.n_dofs());
          LoadAssembler(s, where, std::vector{term}).add(0, f);
          EXPECT_NEAR(f.sum(), 3 * measure_of(m, where[part]), 1e-13);
        }
      }
    }
  }
}

TEST_F(LoadCase, DivergenceTheorem) {
  // int_boundary v . nu = int div v for all v of the space: two different code paths.
  LoadTerm flux = load(1, {}), divergence = load(0, {});
  for (int i = 0; i < 2; ++i) {
    flux.entries.push_back({slot::value(i), Expr::variable(slot::normal(i))});
    divergence.entries.push_back({slot::gradient(i, i), Expr(1.0)});
  }
  EXPECT_LT((at(assembler({flux}), 0) - at(assembler({divergence}), 0)).norm(), 1e-14);
}

TEST_F(LoadCase, EqualTimeFactorsAreOneVector) {
  const Expr pulse = apply(Op::sin, Expr(3.0) * t);
  auto a = assembler({load(0, {{slot::value(0), Expr(-10.0) * t * y}, {slot::value(1), t}}),
                      load(1, {{slot::value(0), Expr(3.0) * t + pulse * x}}),
                      load(1, {{slot::value(1), pulse * Expr(2.0) + Expr(4.0)}})});
  EXPECT_TRUE(a.separable());
  EXPECT_EQ(count_vectors(a), 3); // t, sin 3t, 1
}

TEST_F(LoadCase, WhatDoesNotSeparateIsAssembledAtEachStep) {
  const Expr moving = exp(-(x - t) * (x - t)) / (Expr(1.0) + x * t);
  const auto term = load(0, {{slot::value(0), moving}, {slot::value(1), t * y}});
  const auto a = assembler({term});
  EXPECT_FALSE(a.separable());
  EXPECT_EQ(a.cost(term.origin), LoadAssembler::Cost::every_step);
  for (const double time : {0.0, 0.4, 1.9}) {
    const Vector slow = slow_load(space, parts[0], term, time);
    // Not polynomial: the two rules differ by their own error, far below the size of the load.
    EXPECT_LT((at(a, time) - slow).norm(), 2e-6 * slow.norm());
  }
}

/// Rows that are one with others are added to theirs, whether a load separates or not.
TEST_F(LoadCase, RowsOfLinksAreAddedUp) {
  const Expr moving = exp(-(x - t) * (x - t));
  const std::vector<LoadTerm> both{load(0, {{slot::value(0), t * y}}),
                                   load(1, {{slot::value(1), moving}, {slot::value(0), moving}})};
  const Vector whole = at(assembler(both), 0.7);
  const std::vector<DofLink> links{{3, 0}, {8, 5}, {9, 0}};
  std::vector<std::int32_t> kept;
  for (std::int32_t i = 0; i < space.n_dofs(); i += 2) kept.push_back(i == 6 ? 5 : i);
  auto a = assembler(both);
  a.restrict_to(kept, links);
  Vector expected(static_cast<Eigen::Index>(kept.size())), found = expected;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    double sum = whole[kept[k]];
    for (const DofLink& link : links)
      if (link.to == kept[k]) sum += whole[link.dof];
    expected[static_cast<Eigen::Index>(k)] = sum;
  }
  found.setZero();
  a.add(0.7, found);
  EXPECT_LT((found - expected).norm(), 1e-14 * expected.norm());
  EXPECT_GT(std::abs(whole[3]) + std::abs(whole[8]), 1e-3 * whole.norm());
}

TEST_F(LoadCase, BothPathsAgree) {
  // cos(x + t) in two forms: separated by hand, and as it is, which no product rule takes apart.
  const auto cosine = [](const Expr& e) { return apply(Op::cos, e); };
  const auto sine = [](const Expr& e) { return apply(Op::sin, e); };
  const auto whole = load(1, {{slot::value(0), Expr::make(Op::atan2, {x + t, Expr(1.0) + y * y})}});
  const auto a = assembler({whole});
  EXPECT_FALSE(a.separable());
  const auto joint = load(0, {{slot::value(0), cosine(x + t)}});
  const auto apart = load(0, {{slot::value(0), cosine(x) * cosine(t) - sine(x) * sine(t)}});
  EXPECT_LT((at(assembler({joint}), 0.8) - at(assembler({apart}), 0.8)).norm(), 1e-13);
}

TEST_F(LoadCase, PointLoads) {
  parts.push_back(node_region(mesh, mesh.nodes[4]));
  const auto a = assembler({load(2, {{slot::value(1), Expr(-2.0) * t}})});
  const Vector f = at(a, 1.5);
  EXPECT_EQ(f[space.dof(4, 1)], -3.0);
  EXPECT_EQ(f.cwiseAbs().sum(), 3.0);
  EXPECT_THROW(assembler({load(2, {{slot::gradient(1, 0), t}})}), Failure);
}

TEST_F(LoadCase, MeansAreExactToDegreeSeven) {
  const Expr seventh = pow(t, Expr(7.0)) - Expr(3.0) * t * t;
  const auto a = assembler({load(0, {{slot::value(0), seventh}})});
  const Vector unit = at(assembler({load(0, {{slot::value(0), Expr(1.0)}})}), 0);
  Vector mean = Vector::Zero(space.n_dofs());
  const double t0 = 0.3, t1 = 1.1;
  a.add_mean(t0, t1, mean);
  const auto primitive = [](double s) { return std::pow(s, 8) / 8 - s * s * s; };
  EXPECT_LT((mean - unit * (primitive(t1) - primitive(t0)) / (t1 - t0)).norm(), 1e-14);
}

TEST_F(LoadCase, MeansOfTablesSplitAtTheirKnots) {
  const auto table =
      std::make_shared<const Table>("ramp", std::vector<double>{0, 1, 1.5, 3},
                                    std::vector<double>{0, 2, -1, 4}, Table::Interpolation::linear);
  const auto term =
      load(0, {{slot::value(0), Expr::tabulated(table, t * Expr(2.0) + Expr(0.5)) * x}});
  const auto a = assembler({term});
  EXPECT_TRUE(a.separable());
  const Vector f1 = at(a, 0.25) / 2; // table(1) = 2
  Vector mean = Vector::Zero(space.n_dofs());
  a.add_mean(0.0, 1.25, mean); // argument from 0.5 to 3
  // Trapezoids: [.5, 1]: 1.5 * .5; [1, 1.5]: .5 * .5; [1.5, 3]: 1.5 * 1.5; over 2.5.
  EXPECT_LT((mean - f1 * (0.75 + 0.25 + 2.25) / 2.5).norm(), 1e-15);
  EXPECT_THROW(at(a, 2.0), Failure); // outside the table
}

// Means of piecewise functions of t against their integrals in closed form.
TEST_F(LoadCase, MeansSplitWhereTheLoadJumpsOrBends) {
  const Vector unit = at(assembler({load(0, {{slot::value(0), Expr(1.0)}})}), 0);
  const auto mean = [&](const Expr& g) {
    Vector out = Vector::Zero(space.n_dofs());
    assembler({load(0, {{slot::value(0), g}})}).add_mean(0.2, 1.2, out);
    return out.dot(unit) / unit.squaredNorm();
  };
  const Expr jump = select(less(t, Expr(0.7123)), Expr(1.0), Expr(-3.0));
  EXPECT_NEAR(mean(jump), 0.5123 - 3 * 0.4877, 1e-14);
  EXPECT_NEAR(mean(max(t - Expr(0.9), Expr(0.0))), 0.045, 1e-14);
  EXPECT_NEAR(mean(abs(Expr(1.0) - Expr(2.0) * t)), 0.09 + 0.49, 1e-14);
  // Jumps before the step are none of its, however many there were.
  const Expr earlier =
      select(less(t, Expr(-5.0)), Expr(7.0), select(less(t, Expr(0.0)), Expr(3.0), t));
  EXPECT_NEAR(mean(earlier), 0.7, 1e-14);
  const Expr wave = Expr(2 * M_PI) * t; // sin changes sign at 1/2 and 1: no a t + b
  EXPECT_NEAR(mean(select(less(sin(wave), Expr(0.0)), Expr(2.0), t)), 1.0 + 0.105 + 0.22, 1e-12);
}

// What four points of a rule do not see, alone and together with x.
TEST_F(LoadCase, MeansOfWhatIsFasterThanTheStep) {
  const Vector unit = at(assembler({load(0, {{slot::value(0), Expr(1.0)}})}), 0);
  const auto mean = [&](const Expr& g) {
    Vector out = Vector::Zero(space.n_dofs());
    assembler({load(0, {{slot::value(0), g}})}).add_mean(0.2, 1.2, out);
    return Vector(out);
  };
  const auto number = [&](const Expr& g) { return mean(g).dot(unit) / unit.squaredNorm(); };
  EXPECT_NEAR(number(sin(200.0 * t)), (std::cos(40.0) - std::cos(240.0)) / 200, 1e-13);
  EXPECT_NEAR(number(exp(-200.0 * (t - 0.2))), (1 - std::exp(-200.0)) / 200, 1e-14);
  EXPECT_NEAR(number(sqrt(t - 0.2)), 2.0 / 3, 1e-12);
  EXPECT_NEAR(number(pow(t - 0.2, Expr(-0.5))), 2.0, 1e-5) << "infinite at the beginning";
  EXPECT_NEAR(number(1.0 / (1.0 + exp((0.37 - t) * 1000.0))), 0.83, 1e-6);
  const Expr square = select(less(sin(20.0 * t), Expr(0.0)), Expr(-1.0), Expr(1.0));
  double sum = 0.0;
  for (int i = 0; i < 1000000; ++i) sum += std::sin(20 * (0.2 + (i + 0.5) * 1e-6)) < 0 ? -1 : 1;
  EXPECT_NEAR(number(square), sum / 1e6, 2e-6);
  // cos(40 (x + t)), whose mean is another function of x.
  const auto moving = [&](double s) { return sin(40.0 * (x + s)); };
  const Vector expected =
      at(assembler({load(0, {{slot::value(0), (moving(1.2) - moving(0.2)) / 40.0}})}), 0);
  EXPECT_LT((mean(apply(Op::cos, 40.0 * (x + t))) - expected).norm(), 1e-12);
}

// |t - c|^-a has the mean (c^(1-a) + (1-c)^(1-a)) / (1-a) over [0, 1] for a < 1, and none beyond.
TEST_F(LoadCase, MeansThatDoNotExistAreRefused) {
  const auto mean = [&](const Expr& g) {
    Vector out = Vector::Zero(space.n_dofs());
    assembler({load(0, {{slot::value(0), g}})}).add_mean(0.0, 1.0, out);
    return out.sum();
  };
  const double area = mean(Expr(1.0));
  for (const double c : {0.0, 0.31, 0.5, 1.0}) {
    const Expr distance = abs(t - c);
    for (const double a : {0.3, 0.5, 0.6}) {
      const double exact = (std::pow(c, 1 - a) + std::pow(1 - c, 1 - a)) / (1 - a);
      EXPECT_NEAR(mean(pow(distance, Expr(-a))) / area, exact, 1e-4 * exact) << c << " " << a;
    }
    EXPECT_NEAR(mean(log(distance)) / area,
                (c > 0 ? c * std::log(c) : 0.0) + (c < 1 ? (1 - c) * std::log(1 - c) : 0.0) - 1,
                1e-9)
        << c;
    for (const Expr& none : {Expr(1.0) / (t - c), 1.0 / distance, pow(distance, Expr(-1.5)),
                             Expr(1.0) / (distance * distance), 3.0 + t / (t - c) / distance}) {
      SCOPED_TRACE(c);
      EXPECT_THROW(mean(none), Failure);
    }
  }
}

TEST_F(LoadCase, TimeIndependent) {
  const auto weight = load(0, {{slot::value(1), Expr(-9.81) * x}});
  auto a = assembler({weight});
  EXPECT_EQ(a.cost(weight.origin), LoadAssembler::Cost::once);
  EXPECT_EQ(count_vectors(a), 1);
  EXPECT_EQ(at(assembler({}), 1).norm(), 0);
}

TEST_F(LoadCase, BadValuesNamePointAndTime) {
  const auto expect = [&](const Expr& e, double time, const std::string& text) {
    try {
      at(assembler({load(0, {{slot::value(0), e}})}), time);
      FAIL() << text;
    } catch (const Failure& f) {
      EXPECT_EQ(f.kind, FailureKind::bad_value);
      EXPECT_EQ(f.origin.id, 5);
      EXPECT_NE(std::string(f.what()).find(text), std::string::npos) << f.what();
    }
  };
  expect(sqrt(x - Expr(40.0)), 0, "nan at (");
  expect(sqrt(Expr(1.0) - t), 2, "at t = 2");
  expect(sqrt(x - Expr(40.0) * t), 0.25, "t = 0.25");
}

} // namespace
} // namespace hvi::solver
