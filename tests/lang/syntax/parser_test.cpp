// The parser: trees of right scripts, production by production.
#include "syntax_helpers.hpp"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

namespace hvi::lang {
namespace {

TEST(Expressions, BindAsTheGrammarSays) {
  // Explicit brackets leave no trace in the tree, so they say how the left side must be read.
  const std::vector<std::pair<std::string, std::string>> same{
      {"a - b - c", "(a - b) - c"},
      {"a + b*c", "a + (b*c)"},
      {"a/b*c", "(a/b)*c"},
      {"A : B : C", "(A : B) : C"},
      {"2*A : B/3", "(2*A) : (B/3)"},
      {"A : B + C : D", "(A : B) + (C : D)"},
      {"-a^2", "-(a^2)"},
      {"-a*b", "(-a)*b"},
      {"a^b^c", "a^(b^c)"},
      {"a^-b", "a^(-b)"},
      {"a*-b", "a*(-b)"},
      {"u.nu'", "(u.nu)'"},
      {"u'.nu", "(u').nu"},
      {"f(x)^2", "(f(x))^2"},
      {"x^0 + 1", "(x^0) + 1"},
  };
  for (const auto& [left, right] : same)
    EXPECT_EQ(expression_tree(left), expression_tree(right)) << left;
  EXPECT_NE(expression_tree("a - (b - c)"), expression_tree("a - b - c"));
}

TEST(Expressions, Tree) {
  EXPECT_EQ(expression_tree("slab.group(\"roof\", [1, x'], k = -2.5e-3)"),
            "call\n"
            "  callee: member .group\n"
            "    name slab\n"
            "  string \"roof\"\n"
            "  list\n"
            "    number 1\n"
            "    prime\n"
            "      name x\n"
            "  k = negate\n"
            "    number 0.0025\n");
  EXPECT_EQ(expression_tree("layer^0 (u.nu - g; v.nu)"), "clarke\n"
                                                         "  law: name layer\n"
                                                         "  at: binary -\n"
                                                         "    member .nu\n"
                                                         "      name u\n"
                                                         "    name g\n"
                                                         "  direction: member .nu\n"
                                                         "    name v\n");
}

TEST(Expressions, ReservedWordsMayFollowADotAndNameArguments) {
  EXPECT_EQ(expression_tree("model.part + f(mesh = 1)"), "binary +\n"
                                                         "  member .part\n"
                                                         "    name model\n"
                                                         "  call\n"
                                                         "    callee: name f\n"
                                                         "    mesh = number 1\n");
}

TEST(Expressions, CasesAnywhereInParentheses) {
  EXPECT_EQ(expression_tree("2*(| r < 0 -> 0 | otherwise -> r)"), "binary *\n"
                                                                  "  number 2\n"
                                                                  "  cases\n"
                                                                  "    case\n"
                                                                  "      if: compare <\n"
                                                                  "        name r\n"
                                                                  "        number 0\n"
                                                                  "      value: number 0\n"
                                                                  "    otherwise: name r\n");
}

TEST(Expressions, SpansIncludeTheirParentheses) {
  Diagnostics diagnostics;
  const SourceFile source(0, "a.hvi", "param p = ((a + b))*c");
  const ast::Program program = parse(source, diagnostics);
  ASSERT_EQ(program.statements.size(), 1U);
  const ast::Expr& value = std::get<ast::Param>(program.statements.front()).value;
  const auto& product = std::get<ast::Binary>(value.node);
  EXPECT_EQ(source.text(value.span), "((a + b))*c");
  EXPECT_EQ(source.text(product.left->span), "((a + b))");
  EXPECT_EQ(source.text(product.op_span), "*");
  EXPECT_EQ(product.left->parens, 2);
  EXPECT_EQ(source.text(std::get<ast::Binary>(product.left->node).left->span), "a");
}

TEST(Expressions, TheWholeTextMustBeOne) {
  EXPECT_EQ(errors_of("param p = 1 + 2 3"), "E0224 1:17-18");
  EXPECT_EQ(errors_of("param p ="), "E0201 1:10-10");
}

TEST(Conditions, ParenthesesAroundSumsAndConditions) {
  const auto where = [](const std::string& text) { return tree_of("part p = m where " + text); };
  EXPECT_EQ(where("(x + 1)*2 > 3"), where("((x + 1)*2) > 3"));
  EXPECT_EQ(where("(x) > 3"), where("x > 3"));
  EXPECT_EQ(where("((x > 3))"), where("x > 3"));
  EXPECT_EQ(where("(x > 3 and (y) < (2))"), where("x > 3 and y < 2"));
  EXPECT_EQ(where("((x) > 3 and y < 2) or inside(q)"), where("(x > 3 and y < 2) or inside(q)"));
  EXPECT_EQ(where("x > 3 and y < 2 or z > 1"), where("(x > 3 and y < 2) or z > 1"));
  EXPECT_EQ(where("not x > 3 and y < 2"), where("(not x > 3) and y < 2"));
  EXPECT_EQ(where("(f(x, k = 1) > 3)"), where("f(x, k = 1) > 3"));
  EXPECT_EQ(where("((| x > 1 -> 1 | otherwise -> 2) > 1)"),
            where("(| x > 1 -> 1 | otherwise -> 2) > 1"));
  EXPECT_EQ(where("(inside(q))"), where("inside(q)"));
  EXPECT_EQ(where("not (x < 1 or inside(q))"), "part p\n"
                                               "  region\n"
                                               "    + name m\n"
                                               "    where: not\n"
                                               "      or\n"
                                               "        compare <\n"
                                               "          name x\n"
                                               "          number 1\n"
                                               "        inside q\n");
}

TEST(Statements, Declarations) {
  EXPECT_EQ(tree_of("import friction import \"own/laws.hvi\"\n"
                    "param n = 32 in [1, 512] \"cells\" param e = P1\n"
                    "mesh slab = rectangle(2, 1)\n"
                    "part p = slab.top + (a - b where x > 1) - point(slab, [0, 0])\n"
                    "tensor A = [[1, 2], [3, 4]]\n"
                    "kernel C(lag) = 1 kernel q(t, s) = 2\n"
                    "superpotential j(r, mu = 0.3, k) = r superpotential s(xi) with slope xi\n"
                    "fn f() = 1 fn g(x, y) = 2\n"
                    "space V = vector P2 on slab, zero on p, zero.y on q space W = scalar P1 on p"),
            "import friction\n"
            "import \"own/laws.hvi\"\n"
            "param n\n"
            "  number 32\n"
            "  in: list\n"
            "    number 1\n"
            "    number 512\n"
            "  doc: \"cells\"\n"
            "param e\n"
            "  name P1\n"
            "mesh slab\n"
            "  call\n"
            "    callee: name rectangle\n"
            "    number 2\n"
            "    number 1\n"
            "part p\n"
            "  region\n"
            "    + member .top\n"
            "      name slab\n"
            "    + region\n"
            "      + name a\n"
            "      - name b\n"
            "      where: compare >\n"
            "        name x\n"
            "        number 1\n"
            "    - call\n"
            "      callee: name point\n"
            "      name slab\n"
            "      list\n"
            "        number 0\n"
            "        number 0\n"
            "tensor A\n"
            "  list\n"
            "    list\n"
            "      number 1\n"
            "      number 2\n"
            "    list\n"
            "      number 3\n"
            "      number 4\n"
            "kernel C(lag)\n"
            "  number 1\n"
            "kernel q(t, s)\n"
            "  number 2\n"
            "superpotential j(r)\n"
            "  parameter mu\n"
            "    default: number 0.3\n"
            "  parameter k\n"
            "  name r\n"
            "superpotential s(xi) with slope\n"
            "  name xi\n"
            "fn f()\n"
            "  number 1\n"
            "fn g(x, y)\n"
            "  number 2\n"
            "space V: vector P2 on slab\n"
            "  zero on p\n"
            "  zero.y on q\n"
            "space W: scalar P1 on p\n");
}

TEST(Statements, Find) {
  EXPECT_EQ(tree_of("find u in V with u.y = -t on roof, u = 0 on p for t in [0, 1] by 2*N steps "
                    "from u = 0 using scheme = euler, accuracy = 1e-3\n"
                    "such that for all v in V\n"
                    "- 2*(1/3)^2*integral(s, u, rule = gauss) + 0 >= integral(s, v) - 0"),
            "find u in V for all v in V\n"
            "  with u.y on roof\n"
            "    negate\n"
            "      name t\n"
            "  with u on p\n"
            "    number 0\n"
            "  for t\n"
            "    in: list\n"
            "      number 0\n"
            "      number 1\n"
            "    steps: binary *\n"
            "      number 2\n"
            "      name N\n"
            "    from u\n"
            "      number 0\n"
            "  using scheme\n"
            "    name euler\n"
            "  using accuracy\n"
            "    number 0.001\n"
            "  left: form\n"
            "    - integral over s\n"
            "      factor: number 2\n"
            "      factor: binary ^\n"
            "        binary /\n"
            "          number 1\n"
            "          number 3\n"
            "        number 2\n"
            "      name u\n"
            "      option rule\n"
            "        name gauss\n"
            "    + 0\n"
            "  relation >=\n"
            "  right: form\n"
            "    + integral over s\n"
            "      name v\n"
            "    - 0\n");
  EXPECT_EQ(tree_of("find u in V for t in [0, 1] at [0.1, 1] such that for all v in V "
                    "integral(s, u) = 0"),
            "find u in V for all v in V\n"
            "  for t\n"
            "    in: list\n"
            "      number 0\n"
            "      number 1\n"
            "    times: list\n"
            "      number 0.1\n"
            "      number 1\n"
            "  left: form\n"
            "    + integral over s\n"
            "      name u\n"
            "  relation =\n"
            "  right: form\n"
            "    + 0\n");
}

TEST(Statements, Results) {
  EXPECT_EQ(
      tree_of("report table a = u.y at [1, 0] at t = 0.5, table = w every 2 steps to \"a.csv\" "
              "fields u, v every 8 steps picture norm(u) at t = 1 to \"a.png\"\n"
              "expect a at t = 1 = 3 within 1e-9 relative when n == 16 and N > 4 \"analytic\"\n"
              "study vary n in [1, 2] and k in [3] against exact [x, y] in V\n"
              "study vary n in [1, 2] against richardson"),
      "report\n"
      "  table\n"
      "    column a\n"
      "      member .y\n"
      "        name u\n"
      "      at: list\n"
      "        number 1\n"
      "        number 0\n"
      "      t: number 0.5\n"
      "    column table\n"
      "      name w\n"
      "    every: number 2\n"
      "    to: \"a.csv\"\n"
      "  fields\n"
      "    name u\n"
      "    name v\n"
      "    every: number 8\n"
      "  picture\n"
      "    call\n"
      "      callee: name norm\n"
      "      name u\n"
      "    t: number 1\n"
      "    to: \"a.png\"\n"
      "expect a relative\n"
      "  t: number 1\n"
      "  value: number 3\n"
      "  within: number 1e-09\n"
      "  when: and\n"
      "    compare ==\n"
      "      name n\n"
      "      number 16\n"
      "    compare >\n"
      "      name N\n"
      "      number 4\n"
      "  source: \"analytic\"\n"
      "study\n"
      "  vary n: list\n"
      "    number 1\n"
      "    number 2\n"
      "  vary k: list\n"
      "    number 3\n"
      "  against exact\n"
      "  exact: list\n"
      "    name x\n"
      "    name y\n"
      "  in V\n"
      "study\n"
      "  vary n: list\n"
      "    number 1\n"
      "    number 2\n"
      "  against richardson\n");
}

TEST(Statements, LayoutMeansNothing) {
  const std::string script = read_file(std::filesystem::path(HVI_SOURCE_DIR) / "examples/slab.hvi");
  Diagnostics diagnostics;
  const SourceFile source(0, "slab.hvi", script);
  const TokenStream stream = lex(source, diagnostics);
  std::string one_line;
  std::string many_lines;
  for (const Token& token : stream.tokens) {
    one_line += std::string(source.text(token.span)) + " ";
    many_lines += std::string(source.text(token.span)) + "\r\n";
  }
  EXPECT_EQ(tree_of(one_line), tree_of(script));
  EXPECT_EQ(tree_of(many_lines), tree_of(script));
}

TEST(Statements, AnEmptyScriptIsAScript) {
  EXPECT_EQ(tree_of(""), "");
  EXPECT_EQ(tree_of("\xEF\xBB\xBF# nothing\r\n"), "");
}

TEST(Statements, EveryScriptOfTheRepositoryParses) {
  const auto scripts = repository_scripts();
  EXPECT_GT(scripts.size(), 10U);
  std::size_t n_statements = 0;
  for (const auto& path : scripts) {
    if (path.parent_path().filename() == "errors") continue;
    Diagnostics diagnostics;
    const SourceFile source(0, path.string(), read_file(path));
    n_statements += parse(source, diagnostics).statements.size();
    EXPECT_EQ(places(diagnostics, source), "") << path;
  }
  EXPECT_GT(n_statements, 50U);
}

// The productions above the parser's functions are a grammar: each name is defined once, and every
// name that a production uses is defined.
TEST(Grammar, StandsAboveTheFunctionsAndIsClosed) {
  std::map<std::string, std::string> productions;
  const auto folder = std::filesystem::path(HVI_SOURCE_DIR) / "lang/syntax";
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".cpp") continue;
    std::istringstream lines(read_file(file.path()));
    std::string comment;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("//")) {
        comment += line.substr(2);
        continue;
      }
      std::smatch match;
      if (std::regex_match(comment, match, std::regex(" ([a-z][a-z-]*) = (.*) ; *"))) {
        EXPECT_TRUE(productions.emplace(match[1], match[2]).second) << match[1] << " stands twice";
      }
      comment.clear();
    }
  }
  EXPECT_GE(productions.size(), 44U);
  const std::set<std::string> described{"letter", "digit", "any",    "character",
                                        "but",    "and",   "newline"};
  for (const auto& [name, body] : productions) {
    const std::string bare = std::regex_replace(body, std::regex("\"[^\"]*\"|'[^']*'"), " ");
    const std::regex word("[a-z][a-z-]*");
    for (std::sregex_iterator it(bare.begin(), bare.end(), word), end; it != end; ++it)
      EXPECT_TRUE(productions.contains(it->str()) || described.contains(it->str()))
          << it->str() << " in " << name;
  }
}

} // namespace
} // namespace hvi::lang
