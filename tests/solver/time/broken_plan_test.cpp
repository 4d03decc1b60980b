// Plans that are wrong: each is refused with a Failure, whatever is wrong with it, or it runs.
// HVI_PLANS=100000 draws more of them, HVI_FIRST_PLAN=17 begins with that one.
#include "solver/plan/tensor_form.hpp"
#include "solver/plan/validate.hpp"
#include "tests/solver/time/plans.hpp"

#include <cstdlib>
#include <limits>
#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// Its forms as those of two tensors, the memory's a multiple of that of u.
void write_with_tensors(Plan& plan, int dim) {
  const auto of_young = [](double young, double poisson) {
    const Lame lame = from_young(young, poisson);
    return TensorSpec{{}, {}, TensorSpec::Kind::isotropic, {lame.lambda, lame.mu}};
  };
  plan.problem.tensors = {{{}, {}, TensorSpec::Kind::isotropic, {5.0, 10.0}}, of_young(70, 0.3)};
  for (FormTerm& form : plan.problem.forms) {
    const bool rate = form.field == field_of_u(1);
    const FormTerm::Tensor tensor{rate ? 0 : 1, form.field == field_of_memory(0) ? -1.0 : 1.0};
    const FormTerm written = tensor_form(plan.problem, dim, form.field, tensor);
    form.entries = written.entries, form.tensor = written.tensor;
  }
}

/// A plan with everything in it: friction, memory, every kind of probe, fields.
Plan everything(int dim, int order) {
  auto plan = slab(2, 2, dim, true);
  plan.problem.mesh.cells = {2, 1, 1};
  plan.problem.space.order = order;
  plan.report.probes.push_back(integral("mass", u_value(0) * var(slot::x(0)), body));
  Probe sum;
  sum.name = "sum";
  sum.kind = Probe::Kind::combination;
  sum.expression = var(slot::probe(0)) + var(slot::probe(1)) * var(slot::t);
  plan.report.probes.push_back(sum);
  FieldsSpec fields;
  fields.fields = {{"u", {}, {}}, {"xi", {}, {var(slot::multiplier(0, 0))}}};
  for (int i = 0; i < dim; ++i) fields.fields[0].components.push_back(u_value(i));
  plan.report.fields = {fields};
  write_with_tensors(plan, dim);
  return plan;
}

template <class F>
void each_index(Plan& plan, F&& f) {
  for (auto& d : plan.problem.space.dirichlet) f(d.part), f(d.component);
  f(plan.problem.space.order);
  for (auto& form : plan.problem.forms) {
    f(form.part), f(form.field);
    for (auto& entry : form.entries) f(entry.test), f(entry.trial);
    if (form.tensor) f(form.tensor->index), f(form.tensor->unknown);
  }
  for (auto& load : plan.problem.loads) {
    f(load.part);
    for (auto& entry : load.entries) f(entry.test);
  }
  for (auto& term : plan.problem.law_terms) f(term.law), f(term.part);
  for (auto& probe : plan.report.probes) f(probe.part);
  for (auto& table : plan.report.tables) {
    f(table.every);
    for (int& probe : table.probes) f(probe);
  }
  for (auto& fields : plan.report.fields) f(fields.every);
  for (int& cells : plan.problem.mesh.cells) f(cells);
}

template <class F>
void each_expression(Plan& plan, F&& f) {
  for (auto& d : plan.problem.space.dirichlet)
    for (auto& value : d.value) f(value);
  for (auto& tensor : plan.problem.tensors)
    for (auto& constant : tensor.constants) f(constant);
  for (auto& form : plan.problem.forms) {
    for (auto& entry : form.entries) f(entry.coefficient);
    if (form.tensor) f(form.tensor->factor);
  }
  for (auto& load : plan.problem.loads)
    for (auto& entry : load.entries) f(entry.value);
  for (auto& history : plan.problem.histories) f(history.kernel.expression);
  for (auto& law : plan.problem.laws) f(law.expression);
  for (auto& term : plan.problem.law_terms) {
    f(term.factor);
    for (auto& row : term.rows) {
      f(row.offset);
      for (auto& u : row.u) f(u);
    }
  }
  for (auto& value : plan.problem.time.initial) f(value);
  for (auto& probe : plan.report.probes) f(probe.expression);
  for (auto& fields : plan.report.fields)
    for (auto& field : fields.fields)
      for (auto& component : field.components) f(component);
}

template <class F>
void each_list(Plan& plan, F&& f) {
  f(plan.problem.parts), f(plan.problem.space.dirichlet), f(plan.problem.forms),
      f(plan.problem.histories), f(plan.problem.laws);
  f(plan.problem.law_terms), f(plan.problem.loads), f(plan.problem.time.grid),
      f(plan.problem.time.initial);
  f(plan.report.probes), f(plan.report.tables), f(plan.report.fields), f(plan.problem.tensors);
  for (auto& tensor : plan.problem.tensors) f(tensor.constants);
  for (auto& d : plan.problem.space.dirichlet) f(d.value);
  for (auto& form : plan.problem.forms) f(form.entries);
  for (auto& load : plan.problem.loads) f(load.entries);
  for (auto& term : plan.problem.law_terms) f(term.rows);
  for (auto& table : plan.report.tables) f(table.probes);
  for (auto& fields : plan.report.fields) {
    f(fields.fields);
    for (auto& field : fields.fields) f(field.components);
  }
}

class Breaker {
public:
  explicit Breaker(unsigned seed) : random_(seed) {}

  void break_one(Plan& plan) {
    switch (random_() % 4) {
    case 0:
      return chosen([&](auto&& f) { each_index(plan, f); }, [&](int& i) { i = an_index(); });
    case 1:
      return chosen([&](auto&& f) { each_expression(plan, f); },
                    [&](Expr& e) { e = an_expression(e); });
    case 2:
      return chosen([&](auto&& f) { each_list(plan, f); }, [&](auto& list) { resize(list); });
    default:
      return flip(plan);
    }
  }

private:
  /// `act` on one of what `visit` shows, drawn evenly.
  template <class Visit, class Act>
  void chosen(Visit&& visit, Act&& act) {
    std::size_t n = 0;
    visit([&](auto&) { ++n; });
    if (n == 0) return;
    std::size_t left = random_() % n + 1;
    visit([&](auto& item) {
      if (--left == 0) act(item);
    });
  }

  int an_index() {
    constexpr int limits[] = {std::numeric_limits<int>::min(), std::numeric_limits<int>::max()};
    const auto draw = random_() % 8;
    return draw < 2 ? limits[draw] : static_cast<int>(random_() % 40) - 8;
  }
  double a_number() {
    constexpr double all[] = {0.0,
                              -1.0,
                              1e300,
                              1e-300,
                              std::numeric_limits<double>::infinity(),
                              std::numeric_limits<double>::quiet_NaN()};
    return all[random_() % std::size(all)];
  }
  Expr an_expression(const Expr& old) {
    constexpr Slot starts[] = {0, slot::first_field, slot::first_multiplier, slot::first_inside,
                               slot::first_probe};
    const auto draw = random_() % 3;
    if (draw == 0) return Expr(a_number());
    const Expr one = var(starts[random_() % std::size(starts)] + static_cast<int>(random_() % 60));
    return draw == 1 ? one : old + one * 1e-3;
  }
  template <class T>
  void resize(std::vector<T>& list) {
    const auto draw = random_() % 3;
    if (draw == 0) list.clear();
    if (draw == 1 && !list.empty()) list.pop_back();
    if (draw == 2) list.push_back(list.empty() ? T() : T(list[random_() % list.size()]));
  }
  void flip(Plan& plan) {
    switch (random_() % 11) {
    case 0:
      plan.problem.time.is_static = !plan.problem.time.is_static;
      break;
    case 1:
      plan.problem.space.vector = !plan.problem.space.vector;
      break;
    case 2:
      plan.problem.mesh.kind = static_cast<MeshSpec::Kind>(random_() % 3);
      break;
    case 3:
      plan.options.tolerance = a_number();
      break;
    case 4:
      plan.options.memory_tolerance = a_number();
      break;
    case 8:
      plan.problem.mesh.adapted = static_cast<int>(random_() % 40);
      break;
    case 9:
      plan.problem.mesh.refinements = static_cast<int>(random_() % 4) - 1;
      break;
    case 10:
      for (TensorSpec& tensor : plan.problem.tensors)
        tensor.kind = static_cast<TensorSpec::Kind>(random_() % 4),
        tensor.axes[random_() % 3][random_() % 3] = a_number();
      break;
    case 5:
      plan.problem.mesh.high[random_() % 3] = a_number();
      break;
    case 6:
      if (!plan.problem.laws.empty())
        plan.problem.laws.back().radial = !plan.problem.laws.back().radial;
      break;
    default:
      if (!plan.problem.laws.empty())
        plan.problem.laws.back().coupled = random_() % 2 ? "layer" : "nothing";
    }
  }

  std::mt19937 random_;
};

TEST(BrokenPlans, RunBeforeTheyAreBroken) {
  for (const int dim : {2, 3})
    for (const int order : {1, 2})
      EXPECT_TRUE(solve(everything(dim, order)).certificate.certified) << dim << ' ' << order;
}

TEST(BrokenPlans, AreRefusedOrRun) {
  const auto number = [](const char* name, int otherwise) {
    const char* asked = std::getenv(name);
    return asked ? std::atoi(asked) : otherwise;
  };
  const int scenes = number("HVI_PLANS", 1500), first = number("HVI_FIRST_PLAN", 0);
  int invalid = 0, refused = 0, ran = 0;
  for (int scene = first; scene < first + scenes; ++scene) {
    Breaker breaker(static_cast<unsigned>(scene));
    auto plan = everything(2 + scene % 2, 1 + scene / 2 % 2);
    for (int i = 0; i <= scene % 3; ++i) breaker.break_one(plan);
    SCOPED_TRACE(scene);
    try {
      Discretisation d;
      const bool valid =
          validate(plan, plan.problem.mesh.kind == MeshSpec::Kind::box ? 3 : 2).empty();
      if (!valid) ++invalid;
      if (!discretise(plan, d).empty()) {
        ++refused;
        continue;
      }
      run(plan, d, {});
      ++ran;
    } catch (const Failure&) {
      ++refused;
    } catch (const std::exception& e) {
      ADD_FAILURE() << e.what();
    }
  }
  EXPECT_GT(invalid, scenes / 5);
  EXPECT_GT(refused, scenes / 3);
  EXPECT_GT(ran, scenes / 12); // of 100,000 plans 9,968 still run
}

/// What is said of a plan after one change.
template <class Change>
std::string said(Change&& change) {
  auto plan = everything(2, 1);
  change(plan);
  const auto failures = validate(plan, 2);
  return failures.empty() ? "" : failures.front().what();
}

TEST(Validate, NamesWhatIsWrong) {
  EXPECT_EQ(said([](Plan&) {}), "");
  EXPECT_EQ(said([](Plan& p) { p.problem.forms[1].part = 9; }), "a form names part 9, of 4");
  EXPECT_EQ(said([](Plan& p) { p.problem.forms[1].field = 4; }), "a form names field 4, of 4");
  EXPECT_EQ(said([](Plan& p) { p.problem.law_terms[0].law = -1; }),
            "a law term names law -1, of 2");
  EXPECT_EQ(said([](Plan& p) { p.report.tables[0].probes[1] = 6; }), "a table names probe 6, of 6");
  EXPECT_EQ(said([](Plan& p) { p.problem.loads[0].entries[0].test = slot::value(2); }),
            "a load has the derivative 2 of a function with 2 components in 2 dimensions");
  EXPECT_EQ(said([](Plan& p) { p.problem.loads[0].entries[0].value = u_value(0); }),
            "a load has the variable 96, which it cannot have");
  EXPECT_EQ(said([](Plan& p) { p.problem.law_terms[0].rows.clear(); }),
            "the argument of a law has 0 rows; a scalar law has 1");
  EXPECT_EQ(said([](Plan& p) { p.problem.laws[1].coupled = "gone"; }),
            "the bound of a law is the multiplier of `gone`, which is not among the terms");
  EXPECT_EQ(said([](Plan& p) { p.problem.time.initial = {0.0}; }),
            "the initial state has 1 components instead of 2");
  EXPECT_EQ(said([](Plan& p) { p.options.tolerance = 0.0; }),
            "the tolerance of the certificate is 0, not positive");
  EXPECT_EQ(said([](Plan& p) { p.report.fields[0].every = 0; }), "output every 0 steps");
}

TEST(Validate, OnlyLoadsReadAlgebraicStates) {
  const auto with = [](Plan& p) {
    StateTerm state;
    state.name = "load of u", state.part = p.problem.forms[0].part;
    state.rate = u_value(0) * u_value(0), state.initial = 0.0, state.algebraic = true;
    p.problem.states.push_back(state);
    LoadTerm load;
    load.part = state.part;
    load.entries = {{slot::value(0), Expr::variable(slot::state(0))}};
    p.problem.state_loads.push_back(load);
  };
  EXPECT_EQ(said(with), "");
  EXPECT_EQ(said([&](Plan& p) {
              with(p);
              p.problem.forms[0].tensor.reset();
              p.problem.forms[0].entries[0].coefficient = Expr::variable(slot::state(0));
            }),
            "a form reads `load of u`, which loads alone read");
  EXPECT_EQ(said([&](Plan& p) {
              with(p);
              StateTerm late;
              late.name = "late", late.rate = 1.0, late.initial = 0.0;
              p.problem.states.push_back(late);
            }),
            "the state `late` stands behind an algebraic one");
  EXPECT_EQ(said([&](Plan& p) {
              with(p);
              p.problem.states[0].rate = Expr::variable(slot::multiplier(0, 0));
            }),
            "a load reads unknowns, their rates, memories and gradients, only");
}

TEST(Validate, ASeriesIsThatOfItsKernel) {
  const PronySeries series{0.5, {1.0, 2.0}, {3.0, 0.25}};
  const auto with = [](const PronySeries& changed) {
    return [&changed](Plan& p) {
      KernelSpec& kernel = p.problem.histories[0].kernel;
      kernel.name = "C", kernel.series = changed;
      kernel.expression = expression({0.5, {1.0, 2.0}, {3.0, 0.25}}, Expr::variable(slot::lag));
    };
  };
  EXPECT_EQ(said(with(series)), "");
  auto other = std::vector(5, series);
  other[0].constant = 0.5 + 1e-9, other[1].weights[1] = 2.1, other[2].times[0] = -3.0;
  other[3].times.pop_back(), other[4].weights[0] = std::nan("");
  for (const auto& wrong : other)
    EXPECT_EQ(said(with(wrong)), "the kernel `C` is not the Prony series that comes with it");
}

TEST(Validate, ATensorIsThatOfItsForm) {
  const std::string not_its = "the form is not that of the tensor 1 that comes with it";
  const auto with = [](auto change) {
    return [change](Plan& p) { change(p.problem.tensors[1], *p.problem.forms[1].tensor); };
  };
  EXPECT_EQ(said(with([](auto& tensor, auto&) { tensor.constants[1] = 27.0; })), not_its);
  EXPECT_EQ(said(with([](auto&, auto& use) { use.factor = 1 + 1e-9; })), not_its);
  EXPECT_EQ(said(with([](auto&, auto& use) { use.factor = std::nan(""); })), not_its);
  EXPECT_EQ(said([](Plan& p) { p.problem.forms[1].entries.pop_back(); }), not_its);
  EXPECT_EQ(said([](Plan& p) { p.problem.forms[1].entries[0].coefficient = 1.0; }), not_its);
  EXPECT_EQ(said(with([](auto&, auto& use) { use.index = 2; })), "a form names tensor 2, of 2");
  EXPECT_EQ(said(with([](auto&, auto& use) { use.unknown = 1; })),
            "a tensor names unknown 1, of 1");
  EXPECT_EQ(said(with([](auto& tensor, auto&) { tensor.constants.pop_back(); })),
            "a tensor has 1 constants instead of 2");
  EXPECT_EQ(said(with([](auto& tensor, auto&) { tensor.constants[0] = u_value(0); })),
            "a tensor has the variable 96, which it cannot have");
  EXPECT_EQ(said(with([](auto& tensor, auto&) { tensor.kind = TensorSpec::Kind::orthotropic; })),
            "a tensor has 2 constants instead of 9");
}

// What the forms were written with does not change what is computed.
TEST(Plans, WithAndWithoutTheirTensorsHaveTheSameResult) {
  auto plan = everything(2, 1);
  const auto with = solve(plan);
  for (FormTerm& form : plan.problem.forms) form.tensor.reset();
  const auto without = solve(plan);
  EXPECT_EQ(with.columns, without.columns);
}

TEST(Validate, JudgesEachPieceByItself) {
  auto plan = everything(2, 1);
  plan.problem.forms[1].part = 9;
  plan.options.threads = 0;
  plan.report.tables[0].probes[1] = 6;
  EXPECT_EQ(validate(plan.problem, 2).size(), 1u);
  EXPECT_EQ(validate(plan.options).size(), 1u);
  EXPECT_EQ(validate(plan.report, plan.problem, 2).size(), 1u);
  EXPECT_EQ(validate(plan, 2).size(), 3u);
}

} // namespace
} // namespace hvi::solver
