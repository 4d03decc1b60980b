// From the model to the plan: entries test x trial that add up to the integrands, signs, effects,
// arguments of laws, memories that nothing uses.
#include "lang/lower/lower.hpp"
#include "solver/plan/validate.hpp"
#include "tests/lang/scripts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace hvi::lang {
namespace {

using namespace testing_scripts;
namespace slot = solver::slot;
using solver::Effect;
using solver::Plan;

const std::string tensor = "tensor B = isotropic(lambda = 3, mu = 2)\n";
const std::string form = "integral(body, B : eps(u) : eps(v))";

Plan plan_of(const std::string& text) {
  auto script = checked(text);
  EXPECT_TRUE(script.model) << text;
  return script.model ? lower(*script.model) : Plan{};
}

/// What the plan's forms and loads on part p come to at the values: left side minus right side.
double balance(const Plan& plan, const std::string& part, Values& at) {
  double sum = 0.0;
  const auto is_there = [&](int p) {
    return plan.problem.parts[static_cast<std::size_t>(p)].name == part;
  };
  for (const auto& term : plan.problem.forms)
    for (const auto& entry : term.entries)
      if (is_there(term.part))
        sum += at.of(entry.coefficient) * at(slot::field(term.field, entry.trial)) *
               at(slot::test(entry.test));
  for (const auto& load : plan.problem.loads)
    for (const auto& entry : load.entries)
      if (is_there(load.part)) sum -= at.of(entry.value) * at(slot::test(entry.test));
  return sum;
}

// Random terms with signs and factors, in any order, those without u on both sides: the entries of
// the plan add up to the left side minus the right side.
TEST(Lower, EntriesAddUpToTheIntegrands) {
  std::mt19937 random(4);
  for (int k = 0; k < 300; ++k) {
    const int dim = 2 + k % 2;
    const auto number = [&] { return drawn(random, 0.1, 3); };
    const auto component = [&] { return static_cast<int>(random() % static_cast<unsigned>(dim)); };
    std::string text[2];
    struct Piece {
      double factor;
      int i, j;
      bool load;
    };
    std::vector<Piece> pieces;
    for (int n = 0; n < 6; ++n) {
      Piece piece{number(), component(), component(), random() % 2 == 0};
      const bool right = piece.load && random() % 2 == 0, minus = random() % 2 == 0;
      const char* names = "xyz";
      text[right] +=
          fmt::format(" {} integral(body, {}*{}v.{})", minus ? "-" : "+", piece.factor,
                      piece.load ? "" : fmt::format("u.{}*", names[piece.j]), names[piece.i]);
      if (right != minus) piece.factor = -piece.factor;
      pieces.push_back(piece);
    }
    const auto plan =
        plan_of(problem(dim, tensor, form + text[0], "integral(body, v.x)" + text[1]));
    Values at(random);
    double wanted = -at(slot::test(0)), size = 1.0, traces[2] = {};
    for (int i = 0; i < dim; ++i) {
      traces[0] += at.strain_of_u(i, i);
      traces[1] += at.strain_of_v(i, i);
      for (int j = 0; j < dim; ++j) wanted += 4 * at.strain_of_u(i, j) * at.strain_of_v(i, j);
    }
    wanted += 3 * traces[0] * traces[1];
    for (const auto& piece : pieces) {
      const double u = piece.load ? 1.0 : at(slot::field(solver::field_of_u(0), piece.j));
      wanted += piece.factor * u * at(slot::test(piece.i));
      size += std::abs(piece.factor);
    }
    EXPECT_NEAR(balance(plan, "body", at), wanted, 1e-12 * (size + 40))
        << text[0] << " = " << text[1];
  }
}

// What a load reads of the solution is an algebraic state, the same one where it is the same; what
// is linear in the solution is none.
TEST(Lower, LoadsReadTheSolutionAsAlgebraicStates) {
  struct Case {
    const char* load;
    std::function<double(Values&)> value; ///< of the whole integrand
    std::size_t states;
  };
  const auto u = [](Values& at, int i) { return at(slot::field(solver::field_of_u(0), i)); };
  const auto v = [](Values& at, int i) { return at(slot::test(i)); };
  const std::vector<Case> cases{
      {"u.x*u.y*v.x", [&](Values& at) { return u(at, 0) * u(at, 1) * v(at, 0); }, 1},
      {"sin(eps(u).xx)*v.x + v.y",
       [&](Values& at) { return std::sin(at.strain_of_u(0, 0)) * v(at, 0) + v(at, 1); }, 1},
      {"sign(u.x)*(v.x + v.y)",
       [&](Values& at) { return std::copysign(1.0, u(at, 0)) * (v(at, 0) + v(at, 1)); }, 1},
      {"(u.x + u.x^2)*(v.x - v.y)",
       [&](Values& at) { return (u(at, 0) + u(at, 0) * u(at, 0)) * (v(at, 0) - v(at, 1)); }, 2},
      {"tr(eps(u))^2*div(v)",
       [&](Values& at) {
         const double trace = at.strain_of_u(0, 0) + at.strain_of_u(1, 1);
         return trace * trace * (at.strain_of_v(0, 0) + at.strain_of_v(1, 1));
       },
       1},
      {"sigma.xx*v.y",
       [&](Values& at) { return (7 * at.strain_of_u(0, 0) + 3 * at.strain_of_u(1, 1)) * v(at, 1); },
       0},
  };
  std::mt19937 random(9);
  for (const Case& one : cases) {
    const auto plan =
        plan_of(problem(2, tensor, form, fmt::format("integral(body, {})", one.load)));
    EXPECT_EQ(solver::validate(plan, 2).size(), 0u) << one.load;
    EXPECT_EQ(plan.problem.states.size(), one.states) << one.load;
    Values at(random);
    double sum = -balance(plan, "body", at);
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) sum += 4 * at.strain_of_u(i, j) * at.strain_of_v(i, j);
    sum += 3 * (at.strain_of_u(0, 0) + at.strain_of_u(1, 1)) *
           (at.strain_of_v(0, 0) + at.strain_of_v(1, 1));
    for (const auto& load : plan.problem.state_loads)
      for (const auto& entry : load.entries) {
        std::vector<std::pair<solver::Slot, Symbol>> values;
        for (std::size_t i = 0; i < plan.problem.states.size(); ++i) {
          EXPECT_TRUE(plan.problem.states[i].algebraic);
          values.emplace_back(slot::state(static_cast<int>(i)), plan.problem.states[i].rate);
        }
        sum += at.of(substitute(entry.value, values)) * at(slot::test(entry.test));
      }
    EXPECT_NEAR(sum, one.value(at), 1e-12 * 40) << one.load;
  }
}

TEST(Lower, TermsThatFoldToZeroAreLeftOut) {
  const auto with =
      plan_of(problem(2, "param k = 0\n" + tensor, form + " + integral(body, k*u.x*v.x)",
                      "integral(body, v.y) + integral(ground, k*v.y)"));
  const auto without = plan_of(problem(2, "param k = 0\n" + tensor, form, "integral(body, v.y)"));
  EXPECT_EQ(with.problem.forms.size(), without.problem.forms.size());
  EXPECT_EQ(with.problem.loads.size(), without.problem.loads.size());
}

const std::string evolution =
    "mesh body = rectangle(2, 1, cells = [2, 1])\npart ground = body.bottom\npart roof = body.top\n"
    "tensor A = isotropic(lambda = 1, mu = 1)\ntensor B = isotropic(lambda = 2, mu = 1)\n"
    "kernel C(lag) = -exp(-lag) * A\nkernel q(lag) = -exp(-3*lag)\n"
    "superpotential layer(r) with slope\n  | r < 0 -> 0\n  | otherwise -> 5*r\n"
    "superpotential slip(xi) = 0.1*norm(xi)\n"
    "space V = vector P1 on body, zero on roof\n"
    "find u in V for t in [0, 1] by 4 steps from u = 0\nsuch that for all v in V\n";

/// The tensors that a script's forms were written with: kind, name, factor; "-" for none.
std::vector<std::string> tensors_of(const Plan& plan, int dim) {
  std::vector<std::string> out;
  for (const auto& failure : solver::validate(plan.problem, dim)) ADD_FAILURE() << failure.what();
  for (const auto& term : plan.problem.forms) {
    if (!term.tensor) {
      out.push_back("-");
      continue;
    }
    const auto& spec = plan.problem.tensors[static_cast<std::size_t>(term.tensor->index)];
    constexpr const char* kinds[] = {"isotropic", "orthotropic", "transverse", "general"};
    out.push_back(fmt::format("{} {} {}", kinds[static_cast<int>(spec.kind)], spec.name,
                              to_string(term.tensor->factor)));
  }
  return out;
}

const std::string materials =
    "fn stiff() = 1 + x\n"
    "tensor A = isotropic(young = 70, poisson = 0.3)\ntensor B = 0.3*A\n"
    "tensor O = orthotropic(young = [30, 7, 5], poisson = [0.2, 0.1, 0.15], shear = [3, 2, 4], "
    "axes = [[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]])\n"
    "tensor T = transverse(young = 7, poisson = 0.2, young_axis = 30, poisson_axis = 0.25, "
    "shear_axis = 3, axis = [1, 2, 0])\n"
    "tensor S = A + O\ntensor G = stiff()*isotropic(lambda = 1, mu = 2)\n"
    "fn stress(w) = O : eps(w)\n";

// Whatever way a material is written, multiplied and used, it arrives as such; a sum of two in one
// integral does not.
TEST(Lower, MaterialsArriveAsTheyWereWritten) {
  const auto of = [](const std::string& left) {
    return tensors_of(plan_of(problem(3, materials, left, "integral(body, v.x)")), 3);
  };
  using Texts = std::vector<std::string>;
  const auto of_one = [&](const std::string& integrand) {
    return of("integral(body, " + integrand + ")");
  };
  EXPECT_EQ(of_one("A : eps(u) : eps(v)"), Texts{"isotropic A 1"});
  EXPECT_EQ(of_one("B : eps(u) : eps(v)"), Texts{"isotropic A 0.3"});
  EXPECT_EQ(of_one("eps(u) : O : eps(v)"), Texts{"orthotropic O 1"});
  EXPECT_EQ(of_one("eps(v) : (T : eps(u))"), Texts{"transverse T 1"});
  EXPECT_EQ(of_one("stress(2*u) : eps(v)"), Texts{"orthotropic O 2"});
  EXPECT_EQ(of_one("-(stress(u) : eps(v))/4"), Texts{"orthotropic O -0.25"});
  EXPECT_EQ(of_one("S : eps(u) : eps(v)"), Texts{"general S 1"});
  EXPECT_EQ(of_one("S : eps(v) : eps(u)"), Texts{"-"}); // S need not be symmetric
  EXPECT_EQ(of_one("G : eps(u) : eps(v)"), Texts{"isotropic  x + 1"});
  EXPECT_EQ(of_one("exp(x)*(2*A : eps(u) : eps(v))"), Texts{"isotropic A 2 * exp(x)"});
  EXPECT_EQ(of_one("A : eps(u) : eps(v) + 2*A : eps(u) : eps(v)"), Texts{"isotropic A 3"});
  EXPECT_EQ(of_one("A : eps(u) : eps(v) + O : eps(u) : eps(v)"), Texts{"-"});
  EXPECT_EQ(of_one("A : eps(u) : eps(v) + dot(u, v)"), Texts{"-"});
  EXPECT_EQ(of_one("A : eps(x*u) : eps(v)"), Texts{"-"});
  EXPECT_EQ(of_one("A : transpose(grad(u)) : eps(v)"), Texts{"-"});
  EXPECT_EQ(of_one("eps(u) : eps(v)"), Texts{"-"});
  EXPECT_EQ(of_one("isotropic(lambda = 1, mu = x) : eps(u) : eps(v)"), Texts{"isotropic  1"});
  EXPECT_EQ(of("integral(body, A : eps(u) : eps(v)) + 2*integral(body, B : eps(u) : eps(v))"),
            (Texts{"isotropic A 1", "isotropic A 0.6"}));
}

// Random ways of writing: what arrives is never wrong (`tensors_of` asks validate).
TEST(Lower, RandomMaterialsAreThoseOfTheirEntries) {
  std::mt19937 random(11);
  const auto pick = [&](std::initializer_list<const char*> words) {
    return std::string(words.begin()[random() % words.size()]);
  };
  int arrived = 0;
  for (int k = 0; k < 300; ++k) {
    std::string left;
    for (unsigned n = 0; n <= random() % 3; ++n) {
      const std::string material =
          pick({"A", "B", "O", "T", "S", "G", "0.7*A", "(A + B)", "(O - 2*T)", "A/3", "-O",
                "isotropic(lambda = 2 + x, mu = 3)", "stiff()*T"});
      const std::string by = pick({"", "0.3*", "2*0.1*", "stiff()*", "exp(-x)*0.2*"});
      const std::string strain = pick({"eps(u)", "eps(0.3*u)", "eps(u + 2*u)", "-eps(u)"});
      const std::string test = pick({"eps(v)", "eps(v)/3", "eps(2*v)"});
      const std::string one = random() % 2 == 0
                                  ? fmt::format("{}{} : {} : {}", by, material, strain, test)
                                  : fmt::format("{}{} : ({} : {})", by, test, material, strain);
      left += (left.empty() ? "" : pick({" + ", " - "})) + one;
    }
    const std::string text = problem(3, materials,
                                     "integral(body, A : eps(u) : eps(v)) + "
                                     "integral(body, " +
                                         left + ")",
                                     "integral(body, v.x)");
    SCOPED_TRACE(left);
    for (const auto& found : tensors_of(plan_of(text), 3)) arrived += found != "-";
  }
  EXPECT_GT(arrived, 400); // the first of each, and those of one term
}

// Of memories: with a series, a kernel of place, and one of t and s. Tensors that relax each by its
// own time are split by their entries.
TEST(Lower, MaterialsOfMemoriesArrive) {
  const auto of = [](const std::string& kernel) {
    return tensors_of(
        plan_of("mesh body = rectangle(2, 1, cells = [2, 1])\npart roof = body.top\n"
                "tensor A = isotropic(lambda = 1, mu = 1)\n"
                "tensor S = A + isotropic(lambda = 0, mu = x)\n" +
                kernel +
                "\nspace V = vector P1 on body, zero on roof\n"
                "find u in V for t in [0, 1] by 4 steps from u = 0\nsuch that for all v in V\n"
                "    integral(body, A : eps(u) : eps(v)) + integral(body, history(C, eps(u)) : "
                "eps(v))\n = integral(body, v.y)\n"),
        2);
  };
  using Texts = std::vector<std::string>;
  const std::string a = "isotropic A 1";
  EXPECT_EQ(of("kernel C(lag) = -exp(-3*lag) * A"), (Texts{a, "isotropic A -1"}));
  EXPECT_EQ(of("kernel C(lag) = (0.2*exp(-lag) + x*exp(-3*lag)) * S"),
            (Texts{a, "general S 0.2", "general S x"}));
  EXPECT_EQ(of("kernel C(lag) = 0.5*(-prony([1, 2], [3, 4])*0.2)*A").size(), 2u);
  EXPECT_EQ(of("kernel C(lag) = -prony([1, 2], [3, 4])*A*0.5")[1].substr(0, 11), "isotropic A");
  EXPECT_EQ(of("kernel C(lag) = exp(-lag)*A + exp(-3*lag)*S"), (Texts{a, "-", "-", "-"}));
  EXPECT_EQ(of("kernel C(lag) = isotropic(lambda = exp(-lag) + exp(-2*lag), mu = 2*exp(-lag))"),
            (Texts{a, "-", "-", "-"}));
  EXPECT_EQ(of("kernel C(t, s) = cos(t - s)*A")[1].substr(0, 11), "isotropic A");
  EXPECT_EQ(of("kernel C(lag) = transverse(young = exp(-lag), poisson = 0.2, young_axis = "
               "2*exp(-lag), poisson_axis = 0.2, shear_axis = exp(-lag))")[1],
            "-");
}

// Several unknowns: each form says of which it is.
TEST(Lower, MaterialsOfSeveralUnknowns) {
  const auto plan = plan_of(
      "mesh body = rectangle(2, 1, cells = [2, 1])\npart roof = body.top\n"
      "tensor A = isotropic(lambda = 1, mu = 1)\nspace V = vector P1 on body, zero on roof\n"
      "space W = vector P1 on body, zero on roof\nfind u in V, w in W\n"
      "such that for all v in V, q in W\n    integral(body, A : eps(u) : eps(v)) + integral(body, "
      "2*A : eps(w) : eps(q))\n + integral(body, A : eps(u) : eps(q)) = integral(body, v.y)\n");
  ASSERT_EQ(tensors_of(plan, 2), (std::vector<std::string>{"isotropic A 1", "isotropic A 2", "-"}));
  EXPECT_EQ(plan.problem.forms[0].tensor->unknown, 0);
  EXPECT_EQ(plan.problem.forms[1].tensor->unknown, 1);
}

TEST(Lower, EffectsAndArgumentsOfLaws) {
  const auto plan = plan_of(
      evolution + "    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v))\n"
                  "  + integral(body, history(C, eps(u)) : eps(v))\n"
                  "  + integral(ground, layer^0(u.nu - 0.25*t; v.nu)) + integral(ground, "
                  "slip^0(u.tau; v.tau))\n"
                  " >= integral(body, v.y) + integral(ground, v.x)\n");
  ASSERT_EQ(plan.problem.forms.size(), 3u);
  EXPECT_EQ(plan.problem.forms[0].field, solver::field_of_u(1));
  EXPECT_EQ(plan.problem.forms[0].effect, Effect::viscosity);
  EXPECT_EQ(plan.problem.forms[1].field, solver::field_of_u(0));
  EXPECT_EQ(plan.problem.forms[1].effect, Effect::elasticity);
  EXPECT_EQ(plan.problem.forms[2].field, solver::field_of_memory(0));
  EXPECT_EQ(plan.problem.forms[2].effect, Effect::memory);
  ASSERT_EQ(plan.problem.histories.size(), 1u);
  ASSERT_EQ(plan.problem.law_terms.size(), 2u);
  EXPECT_EQ(plan.problem.law_terms[0].effect, Effect::normal_law);
  EXPECT_EQ(plan.problem.law_terms[1].effect, Effect::friction);
  // u.nu - t/4, and u - (u.nu) nu, at a random normal.
  std::mt19937 random(5);
  Values at(random);
  const auto& normal = plan.problem.law_terms[0].rows;
  ASSERT_EQ(normal.size(), 1u);
  for (int i = 0; i < 2; ++i) EXPECT_DOUBLE_EQ(at.of(normal[0].u[i]), at(slot::normal(i)));
  EXPECT_DOUBLE_EQ(at.of(normal[0].offset), -0.25 * at(slot::t));
  const auto& tangential = plan.problem.law_terms[1].rows;
  ASSERT_EQ(tangential.size(), 2u);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      EXPECT_NEAR(at.of(tangential[i].u[j]), (i == j) - at(slot::normal(i)) * at(slot::normal(j)),
                  1e-15);
  ASSERT_EQ(plan.problem.loads.size(), 2u);
  EXPECT_EQ(plan.problem.loads[0].effect, Effect::body_force);
  EXPECT_EQ(plan.problem.loads[1].effect, Effect::traction);
}

// A law sees u or its rate, through the same rows.
TEST(Lower, LawsOnTheRateKnowTheirField) {
  const auto with = [](const std::string& laws) {
    return plan_of(evolution + "    integral(body, B : eps(u) : eps(v)) + integral(ground, " +
                   laws + ")\n >= integral(body, v.y)\n");
  };
  const auto plan = with("layer^0(0.5 - 2*u'.nu; -2*v.nu) + slip^0(u'.tau; v.tau)"),
             on_u = with("layer^0(0.5 - 2*u.nu; -2*v.nu) + slip^0(u.tau; v.tau)");
  ASSERT_EQ(plan.problem.law_terms.size(), 2u);
  std::mt19937 random(6);
  Values at(random);
  for (std::size_t l = 0; l < 2; ++l) {
    const auto &term = plan.problem.law_terms[l], &same = on_u.problem.law_terms[l];
    EXPECT_EQ(term.field, solver::field_of_u(1));
    EXPECT_EQ(same.field, solver::field_of_u(0));
    ASSERT_EQ(term.rows.size(), same.rows.size());
    for (std::size_t r = 0; r < term.rows.size(); ++r) {
      for (int i = 0; i < 2; ++i) EXPECT_EQ(at.of(term.rows[r].u[i]), at.of(same.rows[r].u[i]));
      EXPECT_EQ(at.of(term.rows[r].offset), at.of(same.rows[r].offset));
    }
  }
  EXPECT_EQ(at.of(plan.problem.law_terms[0].rows[0].offset), 0.5);
  EXPECT_TRUE(validate(plan, 2).empty());
  const auto& effects = plan.problem.effects;
  for (const char* name :
       {"law on the rate `layer` on `ground`", "friction on the rate `slip` on `ground`"})
    EXPECT_TRUE(std::ranges::any_of(effects, [&](const auto& e) { return e.name == name; }))
        << name;
}

// A kernel's factor stays with the memory that a law sees; one that no form uses is kept for it.
TEST(Lower, LawsOnMemoriesSeeTheWholeKernel) {
  const auto with = [](const std::string& kernel) {
    return plan_of("kernel own(lag) = " + kernel + "\n" + evolution +
                   "    integral(body, B : eps(u) : eps(v)) + integral(ground, "
                   "layer^0(history(own, u).nu - 0.5; v.nu))\n >= integral(body, v.y)\n");
  };
  for (const double factor : {1.0, 0.25, -2.0}) {
    const auto plan = with(fmt::format("{}*exp(-lag/2)", factor));
    ASSERT_EQ(plan.problem.histories.size(), 1u);
    const auto& term = plan.problem.law_terms.at(0);
    EXPECT_EQ(term.field, solver::field_of_memory(0));
    std::mt19937 random(7);
    Values at(random);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(at.of(term.rows[0].u[i]), at(slot::normal(i)));
    EXPECT_EQ(at.of(term.rows[0].offset), -0.5);
    EXPECT_NEAR(at.of(plan.problem.histories[0].kernel.expression),
                factor * std::exp(-at(slot::lag) / 2), 1e-14);
    EXPECT_TRUE(validate(plan, 2).empty());
  }
}

TEST(Lower, MemoriesThatNothingUsesAreLeftOutAndTheOthersRenumbered) {
  const auto plan = plan_of(
      evolution +
      "    integral(body, A : eps(u') : eps(v)) + 0*integral(body, history(C, eps(u)) : eps(v))\n"
      "  + integral(ground, layer^0(u.nu; v.nu)) + integral(body, B : eps(u) : eps(v))\n"
      "  + integral(body, B : history(q, eps(u)) : eps(v))\n"
      " >= integral(body, v.y)\n");
  ASSERT_EQ(plan.problem.histories.size(), 1u);
  int of_memory = 0;
  for (const auto& term : plan.problem.forms)
    if (solver::is_memory(term.field)) {
      ++of_memory;
      EXPECT_EQ(term.field, solver::field_of_memory(0));
    }
  EXPECT_EQ(of_memory, 1);
}

/// The plan of a body with this kernel and the memory integral(body, `memory`).
Plan with_memory(const std::string& kernel, const std::string& memory) {
  return plan_of("mesh body = rectangle(2, 1, cells = [2, 1])\npart roof = body.top\n"
                 "param w = 0.25\ntensor B = isotropic(lambda = 2, mu = 1)\n" +
                 kernel +
                 "\nspace V = vector P1 on body, zero on roof\n"
                 "find u in V for t in [0, 1] by 4 steps from u = 0\nsuch that for all v in V\n"
                 "    integral(body, B : eps(u') : eps(v)) + integral(body, " +
                 memory + ")\n >= integral(body, v.y)\n");
}

/// A Prony series reaches the plan as such, whatever stands before or behind it; the plan is else
/// the one of the same sum of exponentials written out, which carries no series.
TEST(Lower, AKernelWrittenAsAPronySeriesArrivesAsOne) {
  const std::string list = "prony(weights = [0.5, w], times = [0.5, 2])",
                    sum = "(0.5*exp(-lag/0.5) + w*exp(-lag/2))",
                    by_tensor = "history(C, eps(u)) : eps(v)",
                    by_scalar = "B : history(C, eps(u)) : eps(v)";
  for (const auto& [before, behind, memory] : {std::array<std::string, 3>{"-", " * B", by_tensor},
                                               {"", " * (B + B)", by_tensor},
                                               {"2 * B * ", "", by_tensor},
                                               {"-", "", by_scalar},
                                               {"", " * 3", by_scalar}}) {
    const auto kernel = [&, before = before, behind = behind](const std::string& series) {
      return "kernel C(lag) = " + before + series + behind;
    };
    auto plan = with_memory(kernel(list), memory);
    ASSERT_EQ(plan.problem.histories.size(), 1u);
    auto& series = plan.problem.histories[0].kernel.series;
    ASSERT_TRUE(series) << before << behind;
    EXPECT_EQ(series->constant, 0.0);
    EXPECT_EQ(series->weights, (std::vector<double>{0.5, 0.25}));
    EXPECT_EQ(series->times, (std::vector<double>{0.5, 2.0}));
    EXPECT_TRUE(validate(plan, 2).empty());
    series.reset();
    EXPECT_EQ(to_string(plan), to_string(with_memory(kernel(sum), memory)));
  }
}

// Random lists, weights of either sign, times over ten decades, repeats, factors before and behind:
// what the memory's form does to a strain is the tensor's times the series, at any lag.
TEST(Lower, RandomPronySeriesAreWhatTheScriptSays) {
  std::mt19937 random(19);
  const auto text_of = [](const std::vector<double>& list) {
    return fmt::format("[{}]", fmt::join(list, ", "));
  };
  for (int k = 0; k < 300; ++k) {
    const auto n = 1 + random() % 6;
    std::vector<double> weights, times;
    for (unsigned i = 0; i < n; ++i) {
      weights.push_back(drawn(random, 0.1, 2.0) * (random() % 2 == 0 ? 1.0 : -1.0));
      const bool again = !times.empty() && random() % 5 == 0;
      times.push_back(again ? times.back() : std::pow(10.0, drawn(random, -5.0, 5.0)));
    }
    const double before = drawn(random, -3.0, 3.0), behind = drawn(random, 0.1, 3.0);
    const auto plan =
        with_memory(fmt::format("kernel C(lag) = {} * prony(weights = {}, times = {}) * {} * B",
                                before, text_of(weights), text_of(times), behind),
                    "history(C, eps(u)) : eps(v)");
    EXPECT_TRUE(validate(plan, 2).empty());
    ASSERT_EQ(plan.problem.histories.size(), 1u);
    const auto& kernel = plan.problem.histories[0].kernel.expression;
    Values at(random);
    const auto entry_of = [&](int field) {
      for (const auto& term : plan.problem.forms)
        if (term.field == field) return at.of(term.entries.front().coefficient);
      return std::nan("");
    };
    for (const double lag : {0.0, 1e-3, 0.7, 400.0}) {
      double series = 0.0, size = 0.0;
      for (std::size_t i = 0; i < weights.size(); ++i) {
        series += weights[i] * std::exp(-lag / times[i]);
        size += std::abs(weights[i]) * std::exp(-lag / times[i]);
      }
      const double value =
          solver::evaluate(kernel, [&](solver::Slot) { return lag; }); // of the lag alone
      const double factor = before * behind * entry_of(solver::field_of_u(1));
      EXPECT_NEAR(entry_of(solver::field_of_memory(0)) * value, factor * series,
                  1e-12 * std::abs(factor) * size)
          << k << " at lag " << lag;
    }
  }
}

/// One exponential's weight goes to the tensor, as that of a written exponential does; what is no
/// product of a series and a quantity of place is recognised by the engine.
TEST(Lower, WhatIsNoSeriesTimesAQuantityOfPlaceCarriesNone) {
  const std::string memory = "history(C, eps(u)) : eps(v)";
  const auto one = with_memory("kernel C(lag) = prony(weights = [3], times = [2]) * B", memory);
  ASSERT_TRUE(one.problem.histories[0].kernel.series);
  EXPECT_EQ(one.problem.histories[0].kernel.series->weights, std::vector<double>{1.0});
  for (const char* kernel :
       {"kernel C(lag) = 3*exp(-lag/2) * B",
        "kernel C(lag) = (1 + prony(weights = [1, 2], times = [1, 2])) * B",
        "kernel C(lag) = exp(-lag) * prony(weights = [1, 2], times = [1, 2]) * B",
        "kernel C(lag) = prony(weights = [1, 2], times = [1, 2], at = 2*lag) * B"}) {
    const auto plan = with_memory(kernel, memory);
    ASSERT_EQ(plan.problem.histories.size(), 1u) << kernel;
    EXPECT_FALSE(plan.problem.histories[0].kernel.series) << kernel;
  }
}

} // namespace
} // namespace hvi::lang
