// A run that is stopped after any step and goes on from its checkpoint is the run that was never
// stopped: the same numbers, notes and counters, and in the end the same checkpoint, bit for bit.
#include "solver/results/shown.hpp"
#include "solver/time/checkpoint.hpp"
#include "tests/solver/time/plans.hpp"

#include <atomic>
#include <filesystem>
#include <functional>

namespace hvi::solver {
namespace {

using namespace testing_plans;

struct Scene {
  std::string name;
  Plan plan;
  bool monitors = false;
};

Scene with_route(HistoryRoute route, std::string name, int steps) {
  Scene scene{std::move(name), slab(2, steps)};
  scene.plan.problem.histories[0].route = route;
  return scene;
}

/// Everything a report can hold: rows every few steps, events of softening layers, fields.
Scene rich() {
  Scene out{"graded, bdf2, fields", slab(3, 12, 2, true), true};
  Plan& plan = out.plan;
  for (double& t : plan.problem.time.grid) t *= t;
  plan.problem.time.scheme = Scheme::bdf2;
  plan.problem.time.sampling = LoadSampling::average;
  const Expr t = var(slot::t);
  plan.problem.loads = {force(body, {0.0, -60.0 * t}), force(flank, {3.0 * t})};
  // What breaks off is told at the beginning and where it happens.
  const Expr r = var(slot::argument(0));
  plan.problem.laws[0].expression =
      select(less(r, 0.0), 0.0, select(less(r, 0.02), 100.0 * r, select(less(r, 0.08), 2.0, 0.5)));
  plan.report.tables[0].every = 5;
  plan.report.probes.push_back(at_point("inside", u_value(1), {1, 1.0 / 3, 0}));
  plan.report.probes.push_back(at_point("earlier", u_value(1), {1, 0, 0}));
  plan.report.probes.back().time = 0.3;
  FieldsSpec fields;
  fields.fields = {{"u", {}, {u_value(0), u_value(1)}}};
  fields.every = 4;
  plan.report.fields = {fields};
  plan.report.pictures = {{{}, fields.fields[0], 0.3, "early.png"}, {{}, fields.fields[0], {}, ""}};
  return out;
}

/// Friction on the rate beside a layer on u.
Scene on_rates(std::string name, bool graded) {
  Scene out{std::move(name), slab(3, 9, 2, true), true};
  out.plan.problem.law_terms.back().field = field_of_u(1);
  if (!graded) return out;
  for (double& t : out.plan.problem.time.grid) t *= t;
  out.plan.problem.time.scheme = Scheme::bdf2;
  return out;
}

/// A layer that softens in what the ground remembers; branches are followed.
Scene on_memory() {
  Scene out{"law on a memory", slab(3, 9), true};
  auto kernel = exponential_kernel(0.1);
  kernel.expression =
      1000.0 * kernel.expression; // so stiff that the layer's descent outweighs the body
  out.plan.problem.histories.push_back({{}, kernel});
  out.plan.problem.law_terms[0].field = field_of_memory(1);
  out.plan.problem.loads[0] = force(body, {0.0, -8.0 * var(slot::t)});
  return out;
}

/// A block with memory that is thrown on a ground which is stiff, rubs and gives way.
Scene in_motion(Scheme scheme) {
  Scene out{std::string("in motion, ") + name_of(scheme), slab(2, 9, 2, true), true};
  auto& problem = out.plan.problem;
  FormTerm inertia;
  inertia.field = field_of_u(2);
  inertia.entries = {{slot::value(0), slot::value(0), 3.0}, {slot::value(1), slot::value(1), 3.0}};
  problem.forms.push_back(inertia);
  problem.law_terms.back().field = field_of_u(1);
  const Expr r = var(slot::argument(0));
  problem.laws.push_back({"stop", {}, false, true, select(less(r, 0.03), 0.0, 1e300)});
  problem.law_terms.push_back(normal_term(2, ground));
  problem.time.scheme = scheme;
  for (double& t : problem.time.grid) t *= t;
  return out;
}

/// A block that loses stiffness inside, on glue that gives way.
Scene with_states(Scheme scheme, int dim) {
  Scene out{std::string("states, ") + name_of(scheme), slab(dim == 2 ? 3 : 2, 9, dim, true), true};
  Problem& problem = out.plan.problem;
  problem.time.scheme = scheme;
  const Expr strain = var(slot::field(field_of_u(0), slot::gradient(1, 1))),
             opening = var(slot::field(field_of_u(0), slot::value(1)));
  const Expr lost = var(slot::state(0)), bond = var(slot::state(1));
  problem.states = {{{}, "lost", body, 2e3 * strain * strain * (1.5 - lost), 0.0, 0.0, 0.9},
                    {{}, "bond", ground, Expr(-30.0) * bond * abs(opening), 1.0, 0.0, 1.0}};
  for (auto& form : problem.forms)
    if (form.field == field_of_u(0))
      for (auto& entry : form.entries) entry.coefficient = (1.0 - lost) * entry.coefficient;
  LawSpec& law = problem.laws.front();
  law.states = {1};
  law.expression = var(slot::law_state(0)) * law.expression;
  return out;
}

/// The same thrown, with mass.
Scene with_states_in_motion(Scheme scheme) {
  Scene out = with_states(scheme, 2);
  out.name += ", in motion";
  FormTerm inertia;
  inertia.field = field_of_u(2);
  inertia.entries = {{slot::value(0), slot::value(0), 3.0}, {slot::value(1), slot::value(1), 3.0}};
  out.plan.problem.forms.push_back(inertia);
  out.plan.problem.law_terms.back().field = field_of_u(1);
  return out;
}

/// Two blocks, or rings, with a layer and friction on the rate between them.
Scene on_a_pair(std::string name, int dim, bool rings) {
  Scene out{std::move(name), two_blocks(2, 9, dim, rings), true};
  out.plan.problem.law_terms.back().field = field_of_u(1);
  return out;
}

/// Friction on the rate with a bound that reads the memory of both parts of u.
Scene reading(std::string name, int dim, bool proportional) {
  Scene out{std::move(name), slab(dim == 2 ? 3 : 2, 9, dim, true), true};
  Problem& problem = out.plan.problem;
  problem.law_terms.back().field = field_of_u(1);
  const auto past = [](int i) { return var(slot::field(field_of_memory(0), slot::value(i))); };
  Expr along = 0.0;
  for (int i = 0; i < dim; ++i) along = along + past(i) * var(slot::normal(i));
  LawSpec& slip = problem.laws.back();
  slip.readings = {abs(along), abs(past(0))};
  slip.expression = (1.0 + 200.0 * var(slot::reading(0)) + 50.0 * var(slot::reading(1))) *
                    Expr(0.4) * var(slot::argument(0));
  out.plan.options.proportional_path = proportional;
  const auto b = from_young(70, 0.3);
  problem.forms[0] = elastic(dim, body, field_of_u(1), b, 0.2); // multiples of one tensor
  return out;
}

/// A block on springs whose roof moves as it is told: its velocities follow step by step.
Scene driven(Scheme scheme) {
  Scene out{std::string("driven, ") + name_of(scheme), slab(2, 9), true};
  auto& problem = out.plan.problem;
  FormTerm inertia;
  inertia.field = field_of_u(2);
  inertia.entries = {{slot::value(0), slot::value(0), 3.0}, {slot::value(1), slot::value(1), 3.0}};
  problem.forms.push_back(inertia);
  problem.space.dirichlet = {
      clamp(roof, -1, {0.02 * sin(5.0 * var(slot::t)), -0.01 * var(slot::t) * var(slot::t)})};
  problem.time.scheme = scheme;
  return out;
}

/// So nearly incompressible that steps are refined, under a load that comes and goes.
Scene refined() {
  Scene out{"refined, unloaded", slab(3, 9), true};
  Problem& problem = out.plan.problem;
  out.plan.options.proportional_path = false;
  problem.forms[1] = elastic(2, body, field_of_u(0), {1e11, 10.0});
  const Expr pulse = sin(6.0 * var(slot::t));
  problem.loads = {force(body, {0.0, -10.0 * pulse}), force(flank, {3.0 * pulse})};
  return out;
}

std::vector<Scene> scenes() {
  std::vector<Scene> out{{"contact unknowns", slab(3, 9, 2, true), true},
                         {"all unknowns", slab(3, 9, 2, true), true},
                         {"in space", slab(2, 5, 3, true)},
                         with_route(HistoryRoute::fit, "fit", 7),
                         with_route(HistoryRoute::tree, "tree", 22),
                         with_route(HistoryRoute::direct, "direct", 7),
                         with_route(HistoryRoute::fit, "from -2 on", 7),
                         on_rates("laws on rates", false),
                         on_rates("laws on rates, graded, bdf2", true),
                         on_memory(),
                         in_motion(Scheme::backward_euler),
                         in_motion(Scheme::bdf2),
                         in_motion(Scheme::newmark),
                         in_motion(Scheme::hht),
                         in_motion(Scheme::midpoint),
                         with_states(Scheme::backward_euler, 2),
                         with_states(Scheme::bdf2, 2),
                         with_states(Scheme::bdf2, 3),
                         with_states_in_motion(Scheme::newmark),
                         with_states_in_motion(Scheme::hht),
                         with_states_in_motion(Scheme::midpoint),
                         on_a_pair("pair", 2, false),
                         on_a_pair("pair of rings", 2, true),
                         on_a_pair("pair in space", 3, false),
                         reading("reads memories", 2, true),
                         reading("reads memories, all unknowns", 2, false),
                         reading("reads memories, in space", 3, true),
                         driven(Scheme::bdf2),
                         driven(Scheme::newmark),
                         driven(Scheme::hht),
                         driven(Scheme::midpoint),
                         refined(),
                         rich()};
  for (double& t : out[6].plan.problem.time.grid) t -= 2.0;
  out[1].plan.options.proportional_path = false;
  return out;
}

std::filesystem::path folder_of(const std::string& name) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("hvi_resume_" + name);
  std::filesystem::remove_all(folder);
  return folder;
}

/// The run of a scene in a folder; it stops before the step after `last`, if that is not 0.
struct Outcome {
  RunResult result;
  std::string state; ///< of its last checkpoint
};
Outcome run_in(const std::filesystem::path& folder, const Scene& scene, const Discretisation& d,
               bool resume, int last = 0) {
  std::atomic<bool> stop = false;
  RunSettings settings;
  settings.output_folder = folder.string();
  settings.checkpoint_every = 1000; // at the end and where it is stopped
  settings.monitors = scene.monitors;
  settings.resume = resume;
  settings.stop = &stop;
  settings.on_step = [&](int n, double, const Vector&, const Vector&) { stop = n == last; };
  Outcome out;
  try {
    out.result = run(scene.plan, d, settings);
    EXPECT_EQ(last, 0);
  } catch (const Failure& failure) {
    if (failure.kind != FailureKind::suspended) throw;
  }
  out.state = read_checkpoint(checkpoint_path(settings.output_folder, settings.name),
                              fingerprint(scene.plan, d.mesh));
  return out;
}

void expect_same(const RunResult& a, const RunResult& b) {
  EXPECT_EQ(a.times, b.times);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.final, b.final);
  EXPECT_EQ(a.events, b.events);
  EXPECT_EQ(a.files, b.files);
  EXPECT_EQ(a.u, b.u);
  EXPECT_EQ(a.unique, b.unique);
  EXPECT_EQ(a.energy, b.energy);
  EXPECT_EQ(a.certificate.inclusion, b.certificate.inclusion);
  EXPECT_EQ(a.certificate.equilibrium, b.certificate.equilibrium);
  EXPECT_EQ(a.certificate.worst_step, b.certificate.worst_step);
  EXPECT_EQ(a.certificate.inclusion_step, b.certificate.inclusion_step);
  EXPECT_EQ(a.certificate.equilibrium_step, b.certificate.equilibrium_step);
  EXPECT_EQ(a.forward_error.solution, b.forward_error.solution);
  EXPECT_EQ(a.forward_error.amplification, b.forward_error.amplification);
  EXPECT_EQ(a.forward_error.refined, b.forward_error.refined);
  ASSERT_EQ(a.forward_error.columns.size(), b.forward_error.columns.size());
  for (std::size_t i = 0; i < a.forward_error.columns.size(); ++i)
    EXPECT_EQ(a.forward_error.columns[i].absolute, b.forward_error.columns[i].absolute);
  EXPECT_EQ(a.work.newton, b.work.newton);
  EXPECT_EQ(a.work.products, b.work.products);
  ASSERT_EQ(a.notes.size(), b.notes.size());
  for (std::size_t i = 0; i < a.notes.size(); ++i) {
    EXPECT_EQ(a.notes[i].step, b.notes[i].step);
    EXPECT_EQ(a.notes[i].t, b.notes[i].t);
    EXPECT_EQ(a.notes[i].what, b.notes[i].what);
    EXPECT_EQ(a.notes[i].origin.id, b.notes[i].origin.id);
  }
  ASSERT_EQ(a.monitors.has_value(), b.monitors.has_value());
  if (!a.monitors) return;
  EXPECT_EQ(a.monitors->times, b.monitors->times);
  EXPECT_EQ(a.monitors->columns, b.monitors->columns);
  EXPECT_EQ(a.monitors->balance_error, b.monitors->balance_error);
}

TEST(Resume, AfterAnyStepGoesOnWithTheSameBits) {
  for (const auto& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    Discretisation d;
    for (const auto& mistake : discretise(scene.plan, d)) throw mistake;
    const auto whole = run_in(folder_of("whole"), scene, d, false);
    const int steps = static_cast<int>(scene.plan.problem.time.grid.size()) - 1;
    if (scene.name.starts_with("graded")) {
      EXPECT_GE(whole.result.notes.size(), 2U);
    }
    if (scene.name.starts_with("refined")) {
      EXPECT_TRUE(whole.result.forward_error.refined);
    }
    std::vector<int> stops{1, 2, steps / 2, steps - 1};
    if (scene.name.starts_with("graded")) // what happens between the rows of tables is kept
      for (stops.clear(); std::ssize(stops) < steps - 1;)
        stops.push_back(static_cast<int>(stops.size()) + 1);
    for (const int last : stops) {
      SCOPED_TRACE(last);
      const auto folder = folder_of("parts");
      (void)run_in(folder, scene, d, false, last);
      const auto parts = run_in(folder, scene, d, true);
      EXPECT_EQ(parts.result.resumed_from, last);
      expect_same(whole.result, parts.result);
      EXPECT_TRUE(whole.state == parts.state) << "the last checkpoints differ";
    }
  }
}

std::vector<double> numbers_of(const FieldFrame& frame) {
  std::vector<double> out{frame.t, static_cast<double>(frame.step)};
  for (const auto& one : frame.grids) {
    for (const auto& array : one.grid.point_data)
      out.insert(out.end(), array.values.begin(), array.values.end());
    for (const auto& array : one.grid.cell_data)
      out.insert(out.end(), array.values.begin(), array.values.end());
  }
  return out;
}

/// No step is left that would be shown.
TEST(Resume, AfterTheEndShowsTheSame) {
  for (const bool proportional : {true, false}) {
    Scene scene = rich();
    scene.plan.options.proportional_path = proportional;
    const FieldSpec u = scene.plan.report.pictures[0].field;
    scene.plan.report.pictures.push_back({{}, u, {}, "moves.apng"});
    Discretisation d;
    for (const auto& mistake : discretise(scene.plan, d)) throw mistake;
    RunSettings settings;
    settings.output_folder = folder_of("shown").string();
    settings.checkpoint_every = 1000;
    settings.monitors = scene.monitors;
    Shown whole, again;
    whole.fields = again.fields = {u};
    const RunResult first = run_shown(scene.plan, d, settings, whole);
    settings.resume = true;
    expect_same(first, run_shown(scene.plan, d, settings, again));
    ASSERT_EQ(again.pictures.size(), 3U);
    ASSERT_EQ(whole.pictures.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_EQ(again.pictures[i].size(), whole.pictures[i].size());
      for (std::size_t k = 0; k < whole.pictures[i].size(); ++k)
        EXPECT_EQ(numbers_of(again.pictures[i][k]), numbers_of(whole.pictures[i][k]));
    }
    ASSERT_EQ(again.frames.size(), 1U); // the one from there on
    EXPECT_EQ(numbers_of(again.frames.back()), numbers_of(whole.frames.back()));
  }
}

/// A state is one of other times where a step of those taken has another length.
TEST(Resume, IsRefusedWhereTheTimesWereOthers) {
  const Scene scene{"times", slab(2, 6)};
  Discretisation d;
  for (const auto& mistake : discretise(scene.plan, d)) throw mistake;
  const auto refused = [&](const std::function<void(std::vector<double>&)>& change) {
    const auto folder = folder_of("times");
    (void)run_in(folder, scene, d, false, 4);
    Scene other = scene;
    change(other.plan.problem.time.grid);
    try {
      return run_in(folder, other, d, true).result.resumed_from != 4;
    } catch (const Failure& failure) {
      return failure.kind == FailureKind::bad_checkpoint;
    }
  };
  using Times = std::vector<double>;
  EXPECT_FALSE(refused([](Times&) {}));
  EXPECT_FALSE(refused([](Times& t) { t.push_back(1.5); }));
  EXPECT_FALSE(refused([](Times& t) { t[6] = 1.1; })); // a step that was not taken yet
  EXPECT_TRUE(refused([](Times& t) { t[2] += 1e-6; }));
  EXPECT_TRUE(refused([](Times& t) { t[1] += 0.05; }));
  EXPECT_TRUE(refused([](Times& t) { t[4] += 1e-6; }));
  EXPECT_TRUE(refused([](Times& t) { t.erase(t.begin() + 2); }));
  EXPECT_TRUE(refused([](Times& t) { t.resize(4); }));
  EXPECT_TRUE(refused([](Times& t) {
    for (double& x : t) x += 0.25;
  }));
}

} // namespace
} // namespace hvi::solver
