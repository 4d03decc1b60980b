// Mistakes are said once each, all of them, in the order of the script; what depends on a wrong
// thing is silent.
#include "tests/lang/scripts.hpp"

#include <gtest/gtest.h>

namespace hvi::lang {
namespace {

using namespace testing_scripts;
using Codes = std::vector<std::string>;

const std::string tensor = "tensor B = isotropic(lambda = 1, mu = 1)\n";
const std::string left = "integral(body, B : eps(u) : eps(v))", right = "integral(body, v.y)";

TEST(Mistakes, ARightScriptHasNone) {
  const auto script = checked(problem(2, tensor, left, right));
  EXPECT_TRUE(script.model);
  EXPECT_EQ(script.errors, Codes{});
}

TEST(Mistakes, EachIsSaidOnce) {
  const auto script = checked(
      problem(2, tensor, left,
              "integral(body, wind*v.y) + integral(bodi, v.y) + 2*wind*integral(body, v.x)"));
  EXPECT_FALSE(script.model);
  EXPECT_EQ(script.errors,
            (Codes{"E0301", "E0301"})); // wind and bodi; wind again is the same mistake
}

TEST(Mistakes, WhatDependsOnAWrongThingIsSilent) {
  const auto script = checked(problem(2, "tensor B = isotropic(young = 1)\ntensor C = 2*B\n",
                                      "integral(body, C : eps(u) : eps(v)) + " + left, right));
  EXPECT_EQ(script.errors, Codes{"E0305"});
}

TEST(Mistakes, AStrainOfAScalarIsToldToBeAGradient) {
  const auto script = checked(problem(2, tensor, left,
                                      "integral(body, eps(x) : eps(v)) + integral(body, B : "
                                      "eps([x, y, x]) : eps(v))"));
  EXPECT_EQ(script.errors, (Codes{"E0308", "E0308"}));
  EXPECT_EQ(script.helps, (Codes{"use `grad` of a scalar; a displacement is of a space of vectors, "
                                 "`space V = vector P1 on ...`",
                                 ""}));
}

TEST(Mistakes, StrainsAndNormalPartsOfScalarsAreToldOnce) {
  const auto script =
      checked(problem(2, tensor + "part side = body.left\n", left,
                      "integral(body, eps(x) : eps(v)) + integral(body, B : eps(y) : eps(v)) + "
                      "integral(side, x.nu*v.nu) + integral(side, y.nu*v.nu)"));
  EXPECT_EQ(script.errors, (Codes{"E0308", "E0303"}));
}

TEST(Mistakes, WhatTheUnknownAndTheTestFunctionAreAtInALaw) {
  const auto helps = [](const std::string& space, const std::string& form, const std::string& law) {
    return checked(
               "mesh body = interval(1, cells = 2)\npart end = body.right\npart start = body.left\n"
               "superpotential j(r) = r^2\nspace V = " +
               space + " P1 on body, zero on start\nfind u in V\nsuch that for all v in V\n    " +
               "integral(body, " + form + ") + integral(end, " + law + ")\n >= 0\n")
        .helps;
  };
  const std::string scalar = "dot(grad(u), grad(v))", vector = "eps(u) : eps(v)";
  EXPECT_EQ(helps("scalar", scalar, "j^0(v; u)"),
            Codes{"the unknown stands first, the test function behind it"});
  EXPECT_EQ(helps("scalar", scalar, "j^0(1; v)"), Codes{"write `j^0(u; v)`"});
  EXPECT_EQ(helps("vector", vector, "j^0(1; v.nu)"), Codes{"write `j^0(u.nu; v.nu)`"});
}

TEST(Mistakes, ALawOfTheGradientAloneIsToldHowToLendAForm) {
  const auto helps = [](const std::string& space, const std::string& law) {
    return checked("mesh body = rectangle(1, 1, cells = [1, 1])\npart end = body.right\n"
                   "superpotential j(xi) = norm(xi)\nspace V = " +
                   space + " P1 on body, zero on end\nfind u in V\nsuch that for all v in V\n    " +
                   "integral(body, " + law + ")\n >= integral(body, 2*v" +
                   (space == "vector" ? ".x" : "") + ")\n")
        .helps;
  };
  const auto lent = [](const std::string& form) {
    return Codes{"add a form; where `j` alone is meant, `m*" + form +
                 "` in a form and `- m/2*norm(xi)^2` in the law leave it as it is, for any m > 0"};
  };
  EXPECT_EQ(helps("scalar", "j^0(grad(u); grad(v))"), lent("dot(grad(u), grad(v))"));
  EXPECT_EQ(helps("vector", "j^0(eps(u); eps(v))"), lent("eps(u) : eps(v)"));
  EXPECT_EQ(helps("scalar", "j^0(u; v)"),
            Codes{"add a form: `integral(body, dot(grad(u), grad(v)))`"});
}

TEST(Mistakes, WhatGoesWrongInAFunctionIsToldWithTheCallsThatLeadThere) {
  const auto script = checked(problem(
      2, tensor + "fn pull(s) = [0, s.x]\nfn twice(s) = 2*pull(s)\nfn once(n) = n*twice(3)\n", left,
      "integral(body, dot(once(1), v)) + integral(body, dot(grad(x), eps(y)))"));
  EXPECT_EQ(script.errors, (Codes{"E0303", "E0308"}));
  EXPECT_EQ(script.beside,
            (std::vector<std::string>{"called here: pull(s)", "called here: twice(3)",
                                      "called here: once(1)"}));
}

TEST(Mistakes, ADeclarationThatAFunctionReadsIsNotItsBody) {
  const auto script = checked(
      problem(2, tensor + "tensor C = 2 : 3\nfn f(s) = s*C\n", left, "integral(body, v.y*f(2))"));
  EXPECT_EQ(script.errors, Codes{"E0308"});
  EXPECT_EQ(script.beside, std::vector<std::string>{});
}

TEST(Mistakes, AWordThatIsADeclaredNumberIsToldWithIt) {
  const auto with_order = [](const std::string& order) {
    return checked(
        "param order = P1\nmesh body = rectangle(2, 1, cells = [2, 1])\npart roof = body.top\n" +
            tensor +
            "space V = vector order on body, zero.z on roof\nfind u in V\nsuch that for all v in "
            "V\n    " +
            left + "\n  = " + right + "\n",
        {{"order", order}});
  };
  EXPECT_EQ(with_order("3").messages.at(0), "unknown element `order`, which is the number 3");
  EXPECT_EQ(with_order("P2").helps, std::vector<std::string>{"components are x, y"});
}

/// Any number of cells asks for it, also less than the piece has.
TEST(Mistakes, PiecesAreAdaptedAllTogetherOrNoneIs) {
  const auto errors = [](const std::string& upper, const std::string& lower) {
    return checked(
               "mesh upper = rectangle(2, 1, cells = [2, 1]" + upper +
               ")\nmesh lower = rectangle(2, 1, cells = [3, 1], origin = [0, -1]" + lower +
               ")\nmesh both = upper + lower\npart roof = upper.top\npart base = "
               "lower.bottom\n" +
               tensor +
               "space V = vector P1 on both, zero on roof, zero on base\nfind u in V\nsuch that "
               "for all v in V\n    integral(both, B : eps(u) : eps(v))\n  = integral(both, "
               "v.y)\n")
        .errors;
  };
  const std::string one = ", adapted = 1", many = ", adapted = 100";
  EXPECT_EQ(errors("", ""), Codes{});
  EXPECT_EQ(errors(one, one), Codes{});
  EXPECT_EQ(errors(one, many), Codes{});
  EXPECT_EQ(errors("", one), Codes{"E0440"});
  EXPECT_EQ(errors(many, ""), Codes{"E0440"});
}

TEST(Mistakes, ParametersStandInTheOrderOfTheScript) {
  const auto script = checked(problem(2, "param a = 2*c\nparam b = 1\nparam c = b\n" + tensor, left,
                                      "integral(body, a*v.y)"));
  ASSERT_TRUE(script.model);
  std::string names;
  for (const auto& p : script.model->params) names += p.name;
  EXPECT_EQ(names, "abc");
}

TEST(Mistakes, ParametersAreOverriddenWithinTheirRange) {
  const std::string text =
      problem(2, "param k = 2 in [1, 3]\n" + tensor, left, "integral(body, k*v.y)");
  const auto script = checked(text, {{"k", "3"}});
  ASSERT_TRUE(script.model);
  const auto& k = script.model->params.front();
  EXPECT_TRUE(k.overridden);
  EXPECT_EQ(std::get<double>(k.value), 3.0);
  std::mt19937 random(1);
  Values at(random);
  const auto& load = script.model->terms.back();
  EXPECT_DOUBLE_EQ(at.of(load.factor * load.integrand.scalar()), 3 * at(solver::slot::test(1)));
  EXPECT_FALSE(checked(text, {{"k", "4"}}).model);
  EXPECT_FALSE(checked(text, {{"j", "1"}}).model);
}

TEST(Mistakes, FormsThatAreNotLinearAreRefused) {
  for (const char* form : {"integral(body, u.x*u.y*v.x)", "integral(body, v.x*v.y)",
                           "integral(body, u.x + v.x)", "integral(body, sin(v.x))"})
    EXPECT_FALSE(checked(problem(2, tensor, left + " + " + form, right)).model) << form;
  EXPECT_TRUE(checked(problem(2, tensor, left + " + integral(body, 3*u.x*v.x)", right)).model);
}

} // namespace
} // namespace hvi::lang
