// The formatter: goldens, and for many scripts the same tree, the same comments, and rest.
#include "lang/diag/catalogue.hpp"
#include "syntax_helpers.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hvi::lang {
namespace {

TEST(Format, CanonicalLayout) {
  EXPECT_EQ(formatted(R"(import   friction # library
param n=32 in [1,64] "cells"   # how fine
param steps_per_second=4


mesh slab=rectangle( 2,1,cells=[2*n , n])
part roof=slab . top
superpotential layer( r ,mu=0.3) with slope | r<0->0 | r < 0.02 -> 100 * r # soft
  # the tail
| otherwise -> (| r<1 -> 2 | otherwise -> x^0)
find u in V for t in [0,1] by N steps from u=0 such that for all v in V
integral(slab,A:eps(u'):eps(v)) + 2 * integral(ground,layer^0 (-u.nu;v.nu))>=-integral(slab,dot([0,-10*t],v)) + 0
report table u_y=u.y at [1,0],
 strain = norm( u ) fields u,sigma every 8 steps
picture u
expect u_y=-0.5 within 1e-9 relative when not(n==16)and N==64 "regression")"),
            R"(import friction                                  # library
param n                = 32 in [1, 64]  "cells"  # how fine
param steps_per_second = 4

mesh slab = rectangle(2, 1, cells = [2*n, n])
part roof = slab.top
superpotential layer(r, mu = 0.3) with slope
  | r < 0     -> 0
  | r < 0.02  -> 100 * r  # soft
  # the tail
  | otherwise -> (| r < 1 -> 2 | otherwise -> x^0)
find u in V for t in [0, 1] by N steps from u = 0
such that for all v in V
    integral(slab, A : eps(u') : eps(v))
  + 2 * integral(ground, layer^0(-u.nu; v.nu))
 >= -integral(slab, dot([0, -10*t], v))
  + 0
report
  table   u_y = u.y at [1, 0], strain = norm(u)
  fields  u, sigma every 8 steps
  picture u
expect u_y = -0.5 within 1e-9 relative when not (n == 16) and N == 64 "regression"
)");
}

TEST(Format, AnEquationHasItsSignInTheColumnOfTheOthers) {
  EXPECT_EQ(formatted("find u in V such that for all v in V -integral(s,u)-integral(s,v)=0"),
            "find u in V\n"
            "such that for all v in V\n"
            "  - integral(s, u)\n"
            "  - integral(s, v)\n"
            "  = 0\n");
}

TEST(Format, CommentsKeepTheirPlaces) {
  EXPECT_EQ(formatted("\n\n# head  \r\n\n\n\n# second\nparam n = 1 # tail\n  # own line\n"
                      "param m = f(1, # one\n  # before two\n 2) # end\n\n# last\n\n"),
            "# head\n\n# second\nparam n = 1  # tail\n# own line\nparam m = f(1,  # one\n"
            "    # before two\n    2)  # end\n\n# last\n");
}

TEST(Format, LongLinesBreakBehindCommasAndBeforeClauses) {
  const std::string text = formatted("param n = 1 fn f(x) = function(first_argument = 1000000, "
                                     "second_argument = [2000000, 3000000], "
                                     "third_argument = 4000000, fourth_argument_with_a_name = 5)\n"
                                     "find displacement in displacements with displacement.y = "
                                     "-0.1*t on roof for t in [0, 1] by 10 "
                                     "steps from displacement = 0 using scheme = euler such that "
                                     "for all v in V integral(s, u) = 0");
  EXPECT_EQ(text, "param n = 1\n"
                  "fn f(x) =\n"
                  "  function(first_argument = 1000000, second_argument = [2000000, 3000000], "
                  "third_argument = 4000000,\n"
                  "      fourth_argument_with_a_name = 5)\n"
                  "find displacement in displacements with displacement.y = -0.1*t on roof\n"
                  "  for t in [0, 1] by 10 steps from displacement = 0\n"
                  "  using scheme = euler\n"
                  "such that for all v in V\n"
                  "    integral(s, u)\n"
                  "  = 0\n");
}

TEST(Format, DefinitionsTooLongForALineBeginOnTheNext) {
  const std::string sum = "a_rather_long_name + " + std::string(80, 'b');
  EXPECT_EQ(formatted("fn f(x) = 1 fn long_name(x, y) = " + sum + " fn g(x) = 2"),
            "fn f(x) = 1\nfn long_name(x, y) =\n  " + sum + "\nfn g(x) = 2\n");
}

TEST(Format, DocumentsOfParametersStandInAColumn) {
  EXPECT_EQ(formatted("param n = 1 in [1, 10] \"cells\" param long = 2 \"steps\"\n\n"
                      "param m = 3 \"other\" param k = 4"),
            "param n    = 1 in [1, 10]  \"cells\"\nparam long = 2             \"steps\"\n\n"
            "param m = 3  \"other\"\nparam k = 4\n");
}

TEST(Format, SaysNothingAboutWrongScripts) { EXPECT_EQ(formatted("param n 4"), "E0201 1:9-10"); }

TEST(Format, TokensThatWouldMergeStayApart) {
  EXPECT_EQ(formatted("fn f(x) = 2 . x + x^0 . y"), "fn f(x) = 2 .x + x^0 .y\n");
}

std::vector<std::string> comments_of(const std::string& script) {
  Diagnostics diagnostics;
  const SourceFile source(0, "a.hvi", script);
  std::vector<std::string> result;
  for (const Span& span : lex(source, diagnostics).comments) result.emplace_back(source.text(span));
  return result;
}

// Whatever the layout was: same tree, same comments, nothing left to do; lines not too long.
void check_round_trip(const std::string& script) {
  const std::string tree = tree_of(script);
  const std::string once = formatted(script);
  ASSERT_EQ(tree_of(once), tree) << script;
  ASSERT_EQ(comments_of(once), comments_of(script)) << script;
  ASSERT_EQ(formatted(once), once) << script;
  ASSERT_EQ(once.find("\n\n\n"), std::string::npos) << script;
  ASSERT_EQ(once.find(" \n"), std::string::npos) << script;
}

bool parses(const std::string& script) { return errors_of(script).empty(); }

TEST(Format, EveryScriptOfTheRepository) {
  std::size_t n_checked = 0;
  for (const auto& path : repository_scripts()) {
    const std::string script = read_file(path);
    if (!parses(script)) continue;
    check_round_trip(script);
    ++n_checked;
  }
  EXPECT_GT(n_checked, 10U);
}

TEST(Format, EverySnippetOfTheCatalogue) {
  std::size_t n_checked = 0;
  for (const CatalogueEntry& entry : catalogue())
    for (const std::string_view snippet : {entry.wrong, entry.right}) {
      if (!parses(std::string(snippet))) continue;
      check_round_trip(std::string(snippet));
      ++n_checked;
    }
  EXPECT_GT(n_checked, 40U);
}

// Words of the grammar may be names, wherever lines end.
TEST(Format, ClauseWordsAsValues) {
  for (const std::string word : {"at", "by", "every", "for", "from", "in", "on", "such", "to",
                                 "using", "when", "where", "with", "within", "steps", "points"}) {
    const std::string script =
        "param a = W \"doc\" param b = W in [W, 2] \"doc\" fn f(W) = W units mm, N, s "
        "superpotential g(r, k = W) = | r < W -> W | otherwise -> W mesh m = W + W param c = W^W "
        "state xi on m with rate W from xi = W in [0, W] space V = vector P1 on W "
        "find u in V with u = W on W for t in [0, W] by W steps from u = W using W = W "
        "such that for all v in V W * integral(W, W) = 0 "
        "report table q = W, r = W at [W, 0] at t = W every W steps to \"x\" fields W, W "
        "picture W deformed = W at t = W picture W, W deformed = 2 line W from [0, 0] to [W, 0] "
        "by W points table s = W fields W to \"y\" plot W against W plot W against W "
        "expect q = W within W \"source\" expect q at t = W = W within W relative when W == W "
        "\"source\" study vary n in [W, 2] against exact W in V";
    std::string text, lines;
    for (const char c : script) text += c == 'W' ? word : std::string(1, c);
    for (const char c : text) lines += c == ' ' ? '\n' : c;
    EXPECT_EQ(errors_of(text), "") << text;
    EXPECT_EQ(tree_of(lines), tree_of(text)) << word;
    check_round_trip(text);
  }
}

// Blanks, line ends and comments strewn between the tokens of real scripts.
TEST(Format, ScriptsInWildLayout) {
  std::mt19937 random(7);
  const std::vector<std::string> gaps{
      " ", "  ", "\n", "\n\n\n", "\r\n", "\t", " # c\n", "\n# own\n", "\n\n  # own # twice\n\n"};
  for (const auto& path : repository_scripts()) {
    const std::string script = read_file(path);
    if (!parses(script)) continue;
    Diagnostics diagnostics;
    const SourceFile source(0, "a.hvi", script);
    const TokenStream stream = lex(source, diagnostics);
    for (int round = 0; round < 5; ++round) {
      std::string wild;
      for (const Token& token : stream.tokens)
        wild += std::string(source.text(token.span)) + gaps[random() % gaps.size()];
      check_round_trip(wild);
    }
  }
}

} // namespace
} // namespace hvi::lang
