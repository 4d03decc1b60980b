// Wrong scripts: exactly these codes at exactly these places, and nothing besides.
#include "lang/diag/catalogue.hpp"
#include "syntax_helpers.hpp"

#include <gtest/gtest.h>

namespace hvi::lang {
namespace {

struct WrongScript {
  std::string script;
  std::string errors;
};

void expect_errors(const std::vector<WrongScript>& scripts) {
  for (const WrongScript& wrong : scripts)
    EXPECT_EQ(errors_of(wrong.script), wrong.errors) << wrong.script;
}

TEST(SyntaxErrors, Declarations) {
  expect_errors({
      {"param n 4", "E0201 1:9-10"},
      {"param n == 4\nparam m == 5", "E0201 1:9-11; E0201 2:9-11"},
      {"units", "E0201 1:6-6"},
      {"units 3", "E0201 1:7-8"},
      {"units mm N\nparam m = 5", "E0201 1:10-11"},
      {"state beta with rate 1 from beta = 0", "E0201 1:12-16"},
      {"state = 3", "E0201 1:7-8"},
      {"part p = body & wall", "E0110 1:15-16"},
      {"part p = body && wall", "E0110 1:15-17"},
      {"space V = vector P1 on slab zero on roof", "E0201 1:29-33"},
      {"param n =\nparam m = 1", "E0201 1:10-10"},
      {"param n = 4 in 3", "E0201 1:16-17"},
      {"param = 4\nparam m = 1", "E0201 1:7-8"},
      {"param mesh = 4\nparam m = mesh", "E0203 1:7-11"},
      {"param and = 4", "E0203 1:7-10"},
      {"param n = 4;\nparam m = 5;", "E0217 1:12-13; E0217 2:12-13"},
      {"param n = 4 5", "E0224 1:13-14"},
      {"param n = 4 = 5", "E0201 1:13-14"},
      {"param n = 0,5", "E0218 1:11-14"},
      {"param n = 1,000", "E0218 1:11-16"},
      {"param n = 4 'cells'", "E0225 1:13-14"},
      {"import", "E0201 1:7-7"},
      {"import 'laws.hvi'", "E0225 1:8-9"},
      {"mesh m = 3", "E0201 1:10-11"},
      {"mesh m = rectangle", "E0201 1:10-19"},
      {"tensor A = isotropic(1, 2))", "E0205 1:27-28"},
      {"tensor A = [1, 2)", "E0205 1:17-18"},
      {"tensor A = isotropic(lambda = 1,5, mu = 2)", "E0218 1:31-34"},
      {"tensor A = isotropic(1 2)", "E0201 1:24-25"},
      {"tensor A = isotropic(lambda == 5)", "E0221 1:29-31"},
      {"tensor A = isotropic(1,)", "E0201 1:24-25"},
      {"tensor A = [ ]", "E0201 1:14-15"},
      {"kernel C = 3", "E0201 1:10-11"},
      {"kernel C() = 3", "E0201 1:10-11"},
      {"kernel C(t, s, r) = 3", "E0227 1:16-17"},
      {"superpotential j = 3", "E0201 1:18-19"},
      {"superpotential j(r) with = 3", "E0201 1:26-27"},
      {"superpotential j(r) with slope = 3", "E0201 1:32-33"},
      {"superpotential j(r) 3", "E0201 1:21-22"},
      {"fn f(x = 3", "E0201 1:8-9"},
      {"fn f(x) x", "E0201 1:9-10"},
      {"fn f(x = 3) = x", "E0201 1:8-9"},
      {"space V = tensor P1 on slab", "E0201 1:11-17"},
      {"space V = vector P1 slab", "E0201 1:21-25"},
      {"space V = vector P1 on slab, on roof", "E0201 1:30-32"},
      {"part p = slab.", "E0201 1:15-15"},
      {"part p = slab.top where x", "E0201 1:26-26"},
      {"part p = (slab.top where x > 1", "E0204 1:31-31"},
      {"part p = slab.top + 3", "E0201 1:21-22"},
  });
}

TEST(SyntaxErrors, NoStatement) {
  expect_errors({
      {"tensr A = 3\ntensor B = 4", "E0202 1:1-6"},
      {"3 + 4", "E0202 1:1-2"},
      {"param n = 3\nfoo\nparam m = 4", "E0202 2:1-4"},
      {"; param n = 3", "E0217 1:1-2"},
      {")", "E0205 1:1-2"},
      {"Param n = 3", "E0202 1:1-6"},
  });
}

TEST(SyntaxErrors, Expressions) {
  expect_errors({
      {"fn f(x) = x +", "E0201 1:14-14"},
      {"fn f(x) = * x", "E0201 1:11-12"},
      {"fn f(x) = --x", "E0201 1:12-13"},
      {"fn f(x) = (x + 1", "E0204 1:17-17"},
      {"fn f(x) = (x + 1\nfn g(x) = x", "E0204 1:17-17"},
      {"fn f(x) = exp(-x))", "E0205 1:18-19"},
      {"fn f(x) = 2(x)", "E0220 1:12-13"},
      {"fn f(x) = (x + 1)(x - 1)", "E0220 1:18-19"},
      {"fn f(x) = [1, 2](x)", "E0220 1:17-18"},
      {"fn f(x) = x > 2", "E0221 1:13-14"},
      {"fn f(x) = 2*|x|", "E0226 1:13-14"},
      {"fn f(x) = |x|", "E0226 1:13-14"},
      {"fn f(x) = x**2 + x**3", "E0211 1:12-14; E0211 1:19-21"},
      {"fn f(x) = x.3", "E0201 1:13-14"},
      {"fn f(x) = .5", "E0201 1:11-13"},
      {"fn f(x) = j^0(x, x)", "E0228 1:16-17"},
      {"fn f(x) = j^0(x)", "E0228 1:16-17"},
      {"fn f(x) = j(x; x)", "E0214 1:14-15"},
      {"fn f(x) = x − 1 + 2", "E0102 1:13-14"},
  });
}

TEST(SyntaxErrors, CasesAndConditions) {
  expect_errors({
      {"fn f(x) =\n  | x < 0 -> 0\n  | x < 1 -> x\nparam n = 1", "E0208 3:15-15"},
      {"fn f(x) = | otherwise -> x", "E0229 1:13-22"},
      {"fn f(x) = | x < 0 -> 0 | otherwise -> x | x > 1 -> 1", "E0229 1:41-42"},
      {"fn f(x) = | x < 0 : 0 | otherwise -> x", "E0209 1:19-20"},
      {"fn f(x) = | x < 0 = 0 | otherwise -> x", "E0209 1:19-20"},
      {"fn f(x) = | x < 0 => 0 | otherwise -> x", "E0209 1:19-21"},
      {"fn f(x) = | x < 0 0 | otherwise -> x", "E0201 1:19-20"},
      {"fn f(x) = | x -> 0 | otherwise -> x", "E0201 1:15-17"},
      {"part p = m.top where x = 1", "E0206 1:24-25"},
      {"part p = m.top where (x = 1 and y > 2) or not (y = 3)", "E0206 1:25-26; E0206 1:50-51"},
      {"part p = m.top where 0 < x < 1", "E0207 1:28-29"},
      {"part p = m.top where x => 1", "E0212 1:24-26"},
      {"part p = m.top where x =< 1", "E0212 1:24-26"},
      {"part p = m.top where x > 1 && y > 2 || z > 3", "E0110 1:28-30; E0212 1:37-39"},
      {"part p = m.top where !(x > 1)", "E0110 1:22-23"},
      {"part p = m.top where not not x > 1", "E0201 1:26-29"},
      {"part p = m.top where (x > 1", "E0204 1:28-28"},
      {"part p = m.top where inside(3)", "E0201 1:29-30"},
      {"part p = m.top where x > 1 and", "E0201 1:31-31"},
  });
}

const std::string head = "find u in V such that for all v in V\n";

TEST(SyntaxErrors, Find) {
  expect_errors({
      {"find u V", "E0201 1:8-9"},
      {"find u in V for all v in V integral(s, u) = 0", "E0215 1:13-16"},
      {"find u in V\n  integral(s, u) = 0", "E0215 2:3-11"},
      {"find u in V\nparam n = 3", "E0215 1:12-12"},
      {"find u in V fro t in [0, 1]", "E0201 1:13-16"},
      {"find u in V such for all v in V", "E0201 1:18-21"},
      {"find u in V for x in [0, 1] by 3 steps", "E0201 1:17-18"},
      {"find u in V for t in [0, 1] such that", "E0201 1:29-33"},
      {"find u in V for t in [0, 1] by 3", "E0201 1:33-33"},
      {"find u in V using a = 1 with u = 0 on p", "E0219 1:25-29"},
      {"find u in V using a = 1 using b = 0", "E0219 1:25-30"},
      {"find u in V with u.y = 0 roof such that", "E0201 1:26-30"},
      {head + " integral(s, u) <= 0", "E0213 2:17-19"},
      {head + " integral(s, u) == 0", "E0213 2:17-19"},
      {head + " integral(s, u) => 0", "E0213 2:17-19"},
      {head + " integral(s, u)", "E0201 2:16-16"},
      {head + " integral(s, u) >=", "E0201 2:19-19"},
      {head + " B : eps(u) : eps(v) = 0", "E0223 2:2-3"},
      {head + " 2 * u >= 0", "E0223 2:2-7"},
      {head + " integral(s, u)/2 = 0", "E0222 2:16-17"},
      {head + " 1/2*integral(s, u) = 0", "E0222 2:3-4"},
      {head + " integral(u) = 0", "E0201 2:12-13"},
      {head + " integral(s, u, gauss) = 0", "E0201 2:22-23"},
      {head + " integral(s, B : u\n + integral(s, u)\n = 0", "E0204 2:19-19"},
      {head + " integral(s, B : u + integral(s, u) = 0", "E0204 2:19-19"},
      {head + " integral(s, B : u\n = 0", "E0204 2:19-19"},
      {head + " integral(s, j(u; v)) >= 0", "E0214 2:17-18"},
  });
}

TEST(SyntaxErrors, AWrongTermDoesNotHideTheOthers) {
  expect_errors({{head + " integral(s, B : u\n + integral(s, j(u; v))\n <= u",
                  "E0204 2:19-19; E0214 3:19-20; E0213 4:2-4; E0223 4:5-6"}});
}

TEST(SyntaxErrors, Results) {
  expect_errors({
      {"report", "E0201 1:7-7"},
      {"report tabel a = u", "E0201 1:8-13"},
      {"report table a", "E0201 1:15-15"},
      {"report table a = u every 3", "E0201 1:27-27"},
      {"report table a = u at 3", "E0201 1:23-24"},
      {"report\n  table a u\n  fields u\n  picture u to 3", "E0201 2:11-12; E0201 4:16-17"},
      {"expect a = 3", "E0201 1:13-13"},
      {"expect a == 3 within 1", "E0201 1:10-12"},
      {"expect a = 3 within 1 when n", "E0201 1:29-29"},
      {"study n in [1, 2]", "E0201 1:7-8"},
      {"study vary n in [1, 2] against nothing", "E0201 1:32-39"},
      {"study vary n in 3 against finest", "E0201 1:17-18"},
  });
}

TEST(SyntaxErrors, LexicalDamageIsNotReportedTwice) {
  expect_errors({
      {"param n = @\nparam m = 4", "E0101 1:11-12"},
      {"param @ = 4", "E0101 1:7-8"},
      {"@\nparam n 4", "E0101 1:1-2; E0201 2:9-10"},
      {"param n = 2x y\nparam m 4", "E0104 1:11-13; E0201 2:9-10"},
      {"param n = 4  // a mesh of the part\nparam m = 4", "E0210 1:14-16"},
      {"param n = 4 \"cells\nparam m 4", "E0106 1:13-19; E0201 2:9-10"},
  });
}

TEST(SyntaxErrors, OneMessagePerMistakeInOneGo) {
  EXPECT_EQ(errors_of("param n 4\ntensr A = 3\nfn f(x) = x > 2\nparam k = 2x\nparam z = 3;\n"),
            "E0201 1:9-10; E0202 2:1-6; E0221 3:13-14; E0104 4:11-13; E0217 5:12-13");
}

TEST(SyntaxErrors, KeepTheNamesOfBrokenStatements) {
  Diagnostics diagnostics;
  const SourceFile source(0, "a.hvi",
                          "param n 4\ntensr A = 3\nfind u in V such that for all v in\n");
  const ast::Program program = parse(source, diagnostics);
  EXPECT_TRUE(program.statements.empty());
  std::string names;
  for (const ast::Name& name : program.broken) names += name.text + " ";
  EXPECT_EQ(names, "n A u v ");
}

TEST(SyntaxErrors, HelpNamesTheWayOut) {
  const auto help = [](const std::string& script) {
    Diagnostics diagnostics;
    const SourceFile source(0, "a.hvi", script);
    static_cast<void>(parse(source, diagnostics));
    return diagnostics.size() == 1 ? diagnostics.items()[0].help : "";
  };
  EXPECT_EQ(help("tensr A = 3"), "did you mean `tensor`?");
  EXPECT_EQ(help("param n = 0,5"), "write `0.5`");
  EXPECT_EQ(help("param n = 1,000"), "write `1.000` or `1000`");
  EXPECT_EQ(help("param k = 2x"), "a product is written `2*x`");
  EXPECT_EQ(help("find u in V fro t in [0, 1]"), "did you mean `for`?");
  EXPECT_EQ(help("report\n  tabel y = u.y at [0, 0]"), "did you mean `table`?");
  EXPECT_EQ(help("report\n  table y = u.y at [0, 0]\n  pictur u"), "did you mean `picture`?");
  EXPECT_EQ(help("space V = vectr P1 on slab"), "did you mean `vector`?");
  EXPECT_EQ(help("space V = 3 P1 on slab"), "");
  EXPECT_EQ(help(head + " integral(s, layer(u; v)) >= 0"),
            "the generalised directional derivative is written `layer^0(u; v)`");
  EXPECT_EQ(help(head + " integral(s.top, u*v) >= 0"),
            "name the part first, as in `part roof = body.top`");
  EXPECT_EQ(help("report\n  table u.y"), "a column has a name, as in `height = u.y`");
  EXPECT_EQ(help("table a = u.y at [0, 0]"), "`table` is a part of the report: `report table ...`");
  EXPECT_EQ(help("expect a == 3 within 1"), "`==` compares two values, in a condition");
  EXPECT_EQ(help("report picture u at t = 1 deformed = 3"),
            "`deformed = 20` stands before `at t` and `to`");
  EXPECT_EQ(help("space V = vector P1 on slab zero on roof"),
            "what holds for a space stands behind commas: `vector P1 on body, zero on wall`");
  EXPECT_EQ(help("param a = .5"), "write `0.5`");
  EXPECT_EQ(help("param a = if 1 < 2 then 3 else 4"),
            "values by cases are written `| x > 0 -> 1 | otherwise -> 0`");
  EXPECT_EQ(help("import laws.hvi"), "the name of a file stands in quotes");
  EXPECT_EQ(help("import contact, friction"), "each module has its own `import`");
  EXPECT_EQ(help("param a = 1 # b\rparam c = 2"),
            "lines end with a line feed: save the script with such line ends");
  EXPECT_EQ(help("find u in V for t in [0, 1] by 2 steps from u = 0, u'' = 0"),
            "values and rates are given; the acceleration at the initial time follows from the "
            "inequality");
}

// `inner` with n times `open` before it and n times `close` behind it.
std::string repeated(const std::string& open, int n, const std::string& inner,
                     const std::string& close) {
  std::string result;
  for (int i = 0; i < n; ++i) result += open;
  result += inner;
  for (int i = 0; i < n; ++i) result += close;
  return result;
}

TEST(Nesting, TwoHundredLevelsAreRead) {
  for (const auto& [open, close] :
       std::vector<std::pair<std::string, std::string>>{{"(", ")"},
                                                        {"[", "]"},
                                                        {"f(", ")"},
                                                        {"-(1 + 2*", ")^2"},
                                                        {"2^-", ""},
                                                        {"j^0(x; ", ")"},
                                                        {"A : (B*(", "))"},
                                                        {"(| x < 1 -> 0 | otherwise -> ", ")"}}) {
    const int n = open == "A : (B*(" ? 100 : 200;
    EXPECT_EQ(errors_of("fn g(x) = " + repeated(open, n, "x", close)), "") << open;
  }
  EXPECT_EQ(errors_of("part p = m where " + repeated("not (", 200, "x < 1", ")")), "");
  EXPECT_EQ(errors_of("part p = m where " + repeated("(", 200, "x", ")") + " < 1"), "");
  EXPECT_EQ(errors_of("part p = m where (" + repeated("(", 200, "x", ")") + " < 1)"), "");
  EXPECT_EQ(errors_of("part p = " + repeated("(", 200, "m.top", ")")), "");
}

TEST(Nesting, TooMuchIsOneErrorAndNoCrash) {
  for (const auto& [open, close] :
       std::vector<std::pair<std::string, std::string>>{{"(", ")"},
                                                        {"[", "]"},
                                                        {"f(", ")"},
                                                        {"-(1 + 2*", ")^2"},
                                                        {"2^-", ""},
                                                        {"j^0(x; ", ")"},
                                                        {"(", ""},
                                                        {"x + ", ""},
                                                        {"x*", ""},
                                                        {"x : ", ""},
                                                        {"(| x < 1 -> 0 | otherwise -> ", ")"},
                                                        {"", "'"},
                                                        {"", ".x"}})
    for (const int n : {2000, 100000})
      EXPECT_TRUE(errors_of("fn g(x) = " + repeated(open, n, "x", close)).starts_with("E0216 1:"))
          << open << close << n;
  std::string conditions = "part p = m where ";
  for (int i = 0; i < 100000; ++i) conditions += "(not ";
  EXPECT_TRUE(errors_of(conditions + "x < 1").starts_with("E0216 1:"));
  std::string regions = "part p = ";
  for (int i = 0; i < 100000; ++i) regions += "(";
  EXPECT_TRUE(errors_of(regions + "m").starts_with("E0216 1:"));
}

// The catalogue's own snippets are scripts: the wrong ones give their code and nothing else.
TEST(CatalogueSnippets, OfLexicalAndSyntaxErrors) {
  const auto check = [](const CatalogueEntry& entry) {
    const std::string code(entry.code);
    EXPECT_EQ(errors_of(std::string(entry.right)), "") << code;
    // These cannot be written down in a table.
    if (code == "E0107" || code == "E0108" || code == "E0109" || code == "E0216") return;
    const std::string errors = errors_of(std::string(entry.wrong));
    EXPECT_TRUE(errors.starts_with(code)) << code << ": " << errors;
    EXPECT_EQ(errors.find(';'), std::string::npos) << code << ": " << errors;
  };
  for (const CatalogueEntry& entry : catalogue_lexical()) check(entry);
  for (const CatalogueEntry& entry : catalogue_syntax()) check(entry);
}

} // namespace
} // namespace hvi::lang
