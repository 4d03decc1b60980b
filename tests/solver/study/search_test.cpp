// The search for an accuracy on rods, where a run takes milliseconds: every distance against the
// two runs it is of, ladders against the rungs that were to be climbed, results against finer runs.
#include "solver/kernel/table.hpp"
#include "solver/study/accuracy.hpp"
#include "tests/solver/time/plans.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// c u' + u'' = load on [0, 1], u = 0 at the left end: viscosity `c` and a tip to look at.
Plan rod(Expr load, int steps, Expr viscosity = 0.2, Expr stiffness = 1.0, int cells = 5) {
  Plan plan;
  plan.problem.mesh.kind = MeshSpec::Kind::interval;
  plan.problem.mesh.cells = {cells, 1, 1};
  plan.problem.parts = {all_cells("rod"), group("held", "left"), group("tip", "right")};
  plan.problem.space.vector = false;
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {diffusion(1, 0, field_of_u(0), stiffness)};
  if (steps > 0) plan.problem.forms.push_back(diffusion(1, 0, field_of_u(1), viscosity));
  plan.problem.loads = {force(0, {load})};
  plan.problem.time.is_static = steps == 0;
  if (steps > 0) plan.problem.time.grid = uniform_grid(1.0, steps);
  plan.report.probes = {at_point("tip", u_value(0), {1, 0, 0})};
  plan.report.tables = {{{}, {0}, 1, false, ""}};
  return plan;
}
Expr x() { return var(slot::x(0)); }
Expr t() { return var(slot::t); }
/// Smooth in x and t, and of no space and no grid.
Expr smooth() { return exp(2.0 * x()) * sin(3.0 * t() + x()); }

AccuracyRequest asking(double wanted, const std::string& probe = {}) {
  AccuracyRequest out;
  out.wanted = wanted, out.probe = probe;
  return out;
}

/// A run at a setting, made here.
struct Made {
  Plan plan;
  Discretisation d;
  RunResult result;
  std::vector<Vector> states; ///< from the first step on
};
std::unique_ptr<Made> make(const SettingFamily& family, const Setting& setting) {
  auto out = std::make_unique<Made>();
  out->plan = family.at(setting);
  for (auto& table : out->plan.report.tables) table.every = 1;
  for (const auto& mistake : discretise(out->plan, out->d)) throw mistake;
  RunSettings settings;
  settings.on_step = [&](int, double, const Vector& u, const Vector&) { out->states.push_back(u); };
  out->result = run(out->plan, out->d, settings);
  return out;
}
/// The family that the search makes its runs of, but for bases that it adds.
SettingFamily family_of(Plan plan, const AccuracyRequest& request) {
  plan.options.memory_tolerance = std::clamp(1e-3 * request.wanted, 1e-10, 1e-5);
  SettingFamily out(plan);
  out.follow_data(0.01 * request.wanted);
  return out;
}

/// du/dx at a point of a uniform rod.
double slope(const Made& run, const Vector& u, double at) {
  const int cells = static_cast<int>(run.d.mesh.cells.size());
  const int cell = std::min(static_cast<int>(at * cells), cells - 1);
  const auto nodes = run.d.space.nodes_of_cell(cell);
  const auto place = [&](int i) {
    return run.d.space.nodes[static_cast<std::size_t>(nodes[i])][0];
  };
  const double h = place(1) - place(0), s = (at - place(0)) / h;
  if (nodes.size() == 2) return (u[nodes[1]] - u[nodes[0]]) / h;
  return ((4 * s - 3) * u[nodes[0]] + (4 * s - 1) * u[nodes[1]] + (4 - 8 * s) * u[nodes[2]]) / h;
}
/// Of || u_x - v_x || squared, by three Gauss points in each cell of the finer rod; v may be null.
double square(const Made& fine, const Vector& u, const Made& coarse, const Vector* v) {
  const int cells = static_cast<int>(fine.d.mesh.cells.size());
  double sum = 0;
  for (int c = 0; c < cells; ++c)
    for (const auto& [off, weight] :
         {std::pair{-std::sqrt(0.6), 5.0 / 18}, std::pair{0.0, 8.0 / 18},
          std::pair{std::sqrt(0.6), 5.0 / 18}}) {
      const double at = (c + 0.5 + 0.5 * off) / cells;
      sum += weight / cells *
             std::pow(slope(fine, u, at) - (v != nullptr ? slope(coarse, *v, at) : 0.0), 2);
    }
  return sum;
}

/// The distance by its definition: largest difference over the times that both have, relative.
double distance_of(const Made& coarse, const Made& fine, const std::string& probe) {
  double largest = 0, size = 0;
  const std::size_t n = coarse.states.size(), m = fine.states.size();
  for (std::size_t i = 1; i <= n; ++i) {
    if (i * m % n != 0) continue;
    const std::size_t j = i * m / n;
    if (probe.empty()) {
      largest = std::max(largest, square(fine, fine.states[j - 1], coarse, &coarse.states[i - 1]));
      size = std::max(size, square(fine, fine.states[j - 1], coarse, nullptr));
    } else {
      const double a = coarse.result.columns.at(probe)[i - 1],
                   b = fine.result.columns.at(probe)[j - 1];
      largest = std::max(largest, std::abs(a - b)), size = std::max(size, std::abs(b));
    }
  }
  return probe.empty() ? std::sqrt(largest / size) : largest / size;
}

/// The settings of the runs made for a purpose, in the order they were made.
std::vector<Setting> made_for(const AccuracyResult& result, const std::string& purpose) {
  std::vector<Setting> out;
  for (const auto& r : result.runs)
    if (r.purpose == purpose) out.push_back(r.setting);
  return out;
}

AccuracyResult reached(const Plan& plan, const AccuracyRequest& request) {
  return reach_accuracy(plan, request, {}, [](const std::string&) {});
}
AccuracyResult given_up(const Plan& plan, const AccuracyRequest& request,
                        std::string* why = nullptr) {
  try {
    (void)reached(plan, request);
  } catch (AccuracyFailure& failure) {
    if (why != nullptr) *why = failure.what();
    return std::move(failure.so_far);
  }
  ADD_FAILURE() << "the accuracy was reached";
  return {};
}

/// Against a run of four times the level and sixteen times the steps.
double true_error(const Plan& plan, const AccuracyResult& result) {
  const auto family = family_of(plan, result.request);
  Setting s = result.tries.back().setting;
  EXPECT_EQ(s.base, 0);
  const auto found = make(family, s);
  s.level *= 4, s.steps *= family.is_static() ? 1 : 16;
  return distance_of(*found, *make(family, s), result.request.probe);
}

TEST(Search, EveryDistanceIsThatOfTheTwoRuns) {
  for (const std::string& probe : {std::string(), std::string("tip")}) {
    SCOPED_TRACE(probe);
    const Plan plan = rod(smooth(), 8);
    const AccuracyRequest request = asking(2e-2, probe);
    const auto result = reached(plan, request);
    const auto family = family_of(plan, request);
    int seen = 0;
    for (const auto& r : result.runs) {
      EXPECT_EQ(r.failure, "");
      EXPECT_EQ(r.setting.grade, 1.0);
      if (!r.distance || r.setting.base != 0) continue;
      const auto finer = std::find_if(result.runs.begin(), result.runs.end(),
                                      [&](const auto& other) { return other.text == r.against; });
      const Setting other =
          finer != result.runs.end() ? finer->setting : result.tries.back().setting;
      EXPECT_EQ(to_string(other, family.at(other).problem), r.against);
      const double d = distance_of(*make(family, r.setting), *make(family, other), probe);
      EXPECT_NEAR(*r.distance, d, 1e-7 * d + 1e-9) << r.text << " against " << r.against;
      ++seen;
    }
    EXPECT_GE(seen, 8);
    EXPECT_LE(true_error(plan, result), request.wanted);
    EXPECT_LE(accuracy_safety * result.tries.back().estimate, request.wanted);
  }
}

/// Three rungs of each ladder, each twice as fine as the one before. (Further ones depend on what
/// runs cost.)
TEST(Search, LaddersDouble) {
  const Plan plan = rod(smooth(), 8);
  const AccuracyRequest request = asking(2e-2);
  const auto result = reached(plan, request);
  const int first = family_of(plan, request).coarsest_steps();
  std::vector<Setting> expected, climbed;
  for (const Scheme scheme : {Scheme::backward_euler, Scheme::bdf2})
    for (const int steps : {first, 2 * first, 4 * first})
      expected.push_back({1, scheme, 2, steps, 1.0, 0});
  for (const int order : {1, 2})
    for (const int level : {1, 2, 4}) // P1 on level 2 is one of those above
      if (order == 2 || level != 2)
        expected.push_back({order, Scheme::backward_euler, level, 2 * first, 1.0, 0});
  for (const auto& r : result.runs)
    if (r.purpose.find("ladder,") != std::string::npos) climbed.push_back(r.setting);
  ASSERT_GE(climbed.size(), expected.size());
  climbed.resize(expected.size());
  EXPECT_EQ(climbed, expected);
}

/// Where no setting is in sight each ladder is climbed six rungs further, but for those whose next
/// run would be too large.
TEST(Search, LaddersThatPromiseNothingAreClimbedToTheirLimits) {
  AccuracyRequest request = asking(1e-9);
  request.as_written = true;
  request.most_unknowns = 10;        // no choice is possible
  std::vector<double> times, values; // a load with so many kinks that short grids are no use
  for (int i = 0; i <= 130; ++i) times.push_back(i / 130.0), values.push_back(i % 2 == 0 ? 1 : 2);
  const auto zigzag =
      std::make_shared<const Table>("zigzag", times, values, Table::Interpolation::linear);
  const Plan plan = rod(Expr::tabulated(zigzag, t()) * exp(2.0 * x()), 4, 0.2, 1.0, 101);
  std::string why;
  const auto result = given_up(plan, request, &why);
  EXPECT_NE(why.find("no setting within"), std::string::npos) << why;
  int most_steps = 0, most_cells = 0, first = family_of(plan, request).coarsest_steps();
  for (const auto& s : made_for(result, "time ladder, backward Euler"))
    if (s.base == 0) most_steps = std::max(most_steps, s.steps);
  for (const auto& r : result.runs)
    if (r.purpose == "space ladder, P1") most_cells = std::max(most_cells, r.unknowns);
  int expected = 4 * first;
  for (int k = 0; k < 6 && 2 * expected <= 8192; ++k) expected *= 2;
  EXPECT_EQ(most_steps, expected);
  EXPECT_GT(2 * most_steps, 8192); // it was the size of the runs that ended it
  // 101 cells have 101 unknowns: of 256 times as many the limit of 20000 leaves half.
  EXPECT_EQ(most_cells, 101 * 128);
}

TEST(Search, StaticProblemsHaveNoTime) {
  const Plan plan = rod(exp(2.0 * x()), 0);
  const AccuracyRequest request = asking(1e-2);
  const auto result = reached(plan, request);
  for (const auto& r : result.runs) {
    EXPECT_EQ(r.setting.base, 0);
    EXPECT_EQ(r.setting.steps, 1);
  }
  EXPECT_EQ(result.tries.back().time_error, 0.0);
  EXPECT_LE(true_error(plan, result), request.wanted);
}

/// Backward Euler is exact for what is linear in time: no error there is no reason to give up.
TEST(Search, ASolutionWithoutErrorInTimeIsReached) {
  const Plan plan = rod((0.2 + t()) * exp(2.0 * x()), 4); // u = t g(x)
  AccuracyRequest request = asking(1e-2);
  request.as_written = true;
  const auto result = reached(plan, request);
  EXPECT_LT(result.tries.back().time_error, 1e-8);
  EXPECT_GE(result.tries.back().time_error, 0.0);
  EXPECT_LE(true_error(plan, result), request.wanted);
}

/// With a probe, P2 shows orders of twice its degree.
TEST(Search, ValuesOfProbesFallFasterThanNorms) {
  AccuracyRequest request = asking(1e-4, "tip");
  request.as_written = true;
  Plan plan = rod(exp(5.0 * sin(7.0 * x())), 0);
  plan.problem.space.order = 2;
  plan.problem.forms = {diffusion(1, 0, field_of_u(0), 1.0 + x())};
  const auto result = reached(plan, request);
  EXPECT_GT(result.tries.back().space_order, 2.5);
  EXPECT_LE(true_error(plan, result), request.wanted);
}

/// A body that grows by itself: long steps have no solution. Ladders begin where runs succeed.
TEST(Search, ColumnsWithoutValuesHaveNoAccuracy) {
  Plan plan = rod(smooth(), 8);
  const Expr none = sqrt(-1.0 - u_value(0) * u_value(0)); // in no row
  plan.report.probes.push_back(at_point("none", none, {1, 0, 0}));
  plan.report.tables[0].probes.push_back(1);
  std::string why;
  (void)given_up(plan, asking(2e-2, "none"), &why);
  EXPECT_NE(why.find("no value in any row"), std::string::npos) << why;
  EXPECT_NO_THROW((void)reached(plan, asking(2e-2, "tip"))); // it is no matter of other columns
}

TEST(Search, RungsThatFailAreLeftOut) {
  const Plan plan = rod(smooth(), 4, 0.2, -1.0);
  const AccuracyRequest request = asking(5e-2);
  const auto result = reached(plan, request);
  const auto failed = std::count_if(result.runs.begin(), result.runs.end(),
                                    [](const auto& r) { return !r.failure.empty(); });
  EXPECT_GT(failed, 0);
  for (const auto& r : result.runs) {
    if (r.purpose.starts_with("time ladder")) {
      EXPECT_EQ(r.failure.empty(), r.setting.steps > 5) << r.text;
    }
    if (!r.failure.empty()) {
      EXPECT_FALSE(r.distance) << r.text;
    } else if (r.distance) {
      EXPECT_GT(*r.distance, 0.0) << r.text;
    }
  }
  EXPECT_LE(true_error(plan, result), request.wanted);
}

/// What relaxes within `relaxation` after its load jumps on: u = g(x) (1 - exp(-(t - begin)/c)).
struct Layer {
  double begin = 0.37, relaxation = 1e-3;
  Plan plan() const {
    return rod(select(less(t(), begin), 0.0, 1.0) * exp(2.0 * x()), 8, relaxation);
  }
  double at(double time) const {
    return time < begin ? 0.0 : 1.0 - std::exp(-(time - begin) / relaxation);
  }
};

/// No uniform grid of few steps sees it: steps are put where the error arises.
TEST(Search, StepsFollowALayer) {
  const Layer layer;
  const AccuracyRequest request = asking(2e-2);
  const auto result = reached(layer.plan(), request);
  std::vector<double> times{0.0}, tip{0.0};
  RunSettings settings;
  settings.on_step = [&](int, double time, const Vector& u, const Vector&) {
    times.push_back(time), tip.push_back(u.lpNorm<Eigen::Infinity>());
  };
  (void)run(result.plan, *result.discretisation, settings);
  const auto& last = result.tries.back();
  EXPECT_GT(last.setting.base, 0);
  EXPECT_LE(last.steps, 200); // uniform steps would have to be shorter than the layer
  ASSERT_EQ(static_cast<int>(times.size()), last.steps + 1);
  double worst = 0, worst_between = 0; // by the largest value
  for (std::size_t i = 1; i < times.size(); ++i) {
    worst = std::max(worst, std::abs(tip[i] / tip.back() - layer.at(times[i])));
    if (times[i - 1] < layer.begin) continue;
    const double between = 0.5 * (tip[i - 1] + tip[i]) / tip.back();
    const double middle = 0.5 * (times[i - 1] + times[i]);
    worst_between = std::max(worst_between, std::abs(between - layer.at(middle)));
  }
  EXPECT_LE(worst, request.wanted);
  EXPECT_LE(worst_between, 2 * request.wanted);
  // Each round compares a run with one of twice the steps, until half of what is aimed at is left.
  std::vector<const AccuracyRun*> rounds;
  for (const auto& r : result.runs)
    if (r.purpose.starts_with("steps where errors in time arise")) rounds.push_back(&r);
  ASSERT_GE(rounds.size(), 6U);
  ASSERT_EQ(rounds.size() % 2, 0U);
  for (std::size_t k = 0; k < rounds.size(); k += 2) {
    EXPECT_EQ(rounds[k + 1]->setting.steps, 2 * rounds[k]->setting.steps);
    EXPECT_EQ(rounds[k + 1]->setting.base, rounds[k]->setting.base);
    ASSERT_TRUE(rounds[k]->distance);
    EXPECT_EQ(rounds[k]->against, rounds[k + 1]->text);
    if (k + 2 < rounds.size()) {
      EXPECT_FALSE(rounds[k + 1]->distance);
    } else {
      EXPECT_LE(*rounds[k]->distance, 0.5 * request.wanted / (1.2 * accuracy_safety));
    }
  }
}

/// The first base of all has the data's intervals where there are enough, and twice as many where
/// there are few.
TEST(Search, StepsAreFollowedFromTheDatasIntervals) {
  for (const int kinks : {0, 20}) {
    std::vector<double> times{0.0}, values{1.0};
    for (int i = 1; i <= kinks + 1; ++i)
      times.push_back(static_cast<double>(i) / (kinks + 1)), values.push_back(1.0 + 0.1 * (i % 2));
    const auto table =
        std::make_shared<const Table>("zigzag", times, values, Table::Interpolation::linear);
    const Plan plan = rod(Expr::tabulated(table, t()) * exp(2.0 * x()), 4, 1e-3);
    const AccuracyRequest request = asking(2e-2);
    const auto result = reached(plan, request);
    const auto intervals = static_cast<int>(family_of(plan, request).intervals(0).size()) - 1;
    const auto first = std::find_if(result.runs.begin(), result.runs.end(), [](const auto& r) {
      return r.purpose.starts_with("steps where errors in time arise, round 1");
    });
    ASSERT_NE(first, result.runs.end());
    EXPECT_EQ(intervals >= 15, kinks > 0);
    EXPECT_EQ(first->setting.steps, 2 * (kinks > 0 ? intervals : 2 * intervals));
  }
}

/// The error in time is what four runs on the ladders' mesh show, each of twice the steps of the
/// one before: the distance of the second to the last, and what is left by the order seen.
TEST(Search, TheErrorInTimeIsThatOfFourRuns) {
  AccuracyRequest request = asking(8e-2);
  request.as_written = true;
  const auto result = reached(rod(smooth(), 8), request);
  const auto& last = result.tries.back();
  ASSERT_EQ(last.setting.base, 0);
  const auto family = family_of(rod(smooth(), 8), request);
  std::vector<std::unique_ptr<Made>> runs;
  for (int k = 0; k < 4; ++k)
    runs.push_back(make(family, {1, Scheme::backward_euler, 2, last.steps / 2 << k, 1.0, 0}));
  const auto d = [&](int i, int j) { return distance_of(*runs[i], *runs[j], ""); };
  const double left = d(2, 3) / (std::pow(2.0, last.time_order) - 1.0);
  const double more = std::max(last.time_distance / d(0, 1), 0.25);
  EXPECT_NEAR(last.time_error, std::max((d(1, 3) + left) * more, last.time_distance),
              1e-6 * last.time_error);
  EXPECT_GT((d(1, 3) + left) * more, last.time_distance);
}

/// A load on cells that the coarsest mesh has none of: finer ones do.
TEST(Search, PartsThatACoarseMeshDoesNotHave) {
  Plan plan = rod(exp(2.0 * x()), 0);
  plan.problem.parts.push_back(all_cells("tail"));
  plan.problem.parts[3].region.kind = RegionSpec::Kind::where;
  plan.problem.parts[3].region.children.resize(1);
  plan.problem.parts[3].region.predicate = less(0.85, x());
  plan.problem.loads.push_back(force(3, {2.0}));
  const AccuracyRequest request = asking(1e-1);
  const auto result = reached(plan, request);
  for (const auto& r : result.runs) EXPECT_EQ(r.failure.empty(), r.setting.level > 1) << r.text;
  EXPECT_FALSE(result.runs.front().failure.empty() && result.runs.back().failure.empty() &&
               result.runs.size() < 3);
}

/// More cells than the longest ladder has: the choice stands, or is refused; it does not go on.
TEST(Search, ChoicesFarBeyondTheLaddersComeToAnEnd) {
  AccuracyRequest request = asking(1e-5);
  request.as_written = true;
  const auto result = reached(rod(exp(2.0 * x()), 0), request);
  EXPECT_GT(result.tries.back().setting.level, 2048);
}

/// A setting is taken where its estimate times the safety is within what is wanted, and another one
/// is chosen where it is not, though the estimate alone would do: both happen on rods with bumps,
/// kinks and waves, drawn at random.
TEST(Search, ASettingIsTakenWithItsMargin) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> draw(0.0, 1.0);
  int by_the_estimate_alone = 0;
  for (int k = 0; k < 40; ++k) {
    const double at = draw(random), width = 0.02 + 0.3 * draw(random), high = 10.0 * draw(random);
    const double waves = 1.0 + 20.0 * draw(random),
                 wanted = std::pow(10.0, -1.0 - 2.0 * draw(random));
    const bool is_static = k % 2 == 0, of_tip = k % 4 < 2;
    const Expr bump = (x() - at) / width, wave = sin(waves * (is_static ? x() : t()));
    const Expr kink = k % 3 == 0   ? abs(x() - at)
                      : k % 3 == 1 ? select(less(x(), at), 1.0, -1.0)
                                   : Expr(0.0);
    const Expr load = exp(-bump * bump) * (1.0 + high * wave) + kink;
    const auto result = reached(rod(load, is_static ? 0 : 4), asking(wanted, of_tip ? "tip" : ""));
    for (const AccuracyTry& one : result.tries) {
      const bool taken = &one == &result.tries.back();
      EXPECT_EQ(accuracy_safety * one.estimate <= wanted, taken) << one.text;
      by_the_estimate_alone += !taken && one.estimate <= wanted ? 1 : 0;
    }
  }
  EXPECT_GT(by_the_estimate_alone, 0);
}

} // namespace
} // namespace hvi::solver
