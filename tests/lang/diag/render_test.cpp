// Goldens of rendered diagnostics, for people and as JSON.
#include "lang/diag/render.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>

namespace hvi::lang {
namespace {

class Render : public testing::Test {
protected:
  // The span of `needle`, the n-th time it stands in the file.
  Span at(int file, const std::string& needle, int n = 1) {
    std::size_t begin = std::string_view::npos;
    for (int i = 0; i < n; ++i) begin = sources.file(file).text().find(needle, begin + 1);
    EXPECT_NE(begin, std::string_view::npos) << needle;
    return {file, static_cast<std::uint32_t>(begin),
            static_cast<std::uint32_t>(begin + needle.size())};
  }
  SourceMap sources;
};

TEST_F(Render, HasTheShapeOfTheManual) {
  std::string text(13, '\n');
  const int file = sources.add("creep.hvi", text + "  + integral(slab, B : eps(u) : eps(w))\n");
  const auto d = diagnose("E0312", at(file, "w"), "`w` is a test function of `W`")
                     .with_label("expected `v`")
                     .with_note("this inequality tests with `v` in `V`")
                     .with_help("did you mean `v`?");
  EXPECT_EQ(render(d, sources), R"(error[E0312]: `w` is a test function of `W`
  --> creep.hvi:14:37
   |
14 |   + integral(slab, B : eps(u) : eps(w))
   |                                     ^ expected `v`
   = note: this inequality tests with `v` in `V`
   = help: did you mean `v`?
)");
}

TEST_F(Render, PutsTwoMarksOfOneLineBelowEachOther) {
  const int file = sources.add("a.hvi", "tensor B = isotropic(young = 70\n");
  const auto d = diagnose("E0204", after(at(file, "70")), "this bracket is not closed")
                     .with_label("expected `)`")
                     .with_secondary(at(file, "("), "opened here");
  EXPECT_EQ(render(d, sources), R"(error[E0204]: this bracket is not closed
 --> a.hvi:1:32
  |
1 | tensor B = isotropic(young = 70
  |                     -          ^ expected `)`
  |                     |
  |                     opened here
)");
}

TEST_F(Render, HangsSeveralLabels) {
  const int file = sources.add("a.hvi", "aa bb cc\n");
  const auto d = diagnose("E0301", at(file, "aa"), "three marks")
                     .with_label("first")
                     .with_secondary(at(file, "bb"), "second")
                     .with_secondary(at(file, "cc"), "third");
  EXPECT_EQ(render(d, sources), R"(error[E0301]: three marks
 --> a.hvi:1:1
  |
1 | aa bb cc
  | ^^ -- -- third
  | |  |
  | |  second
  | first
)");
}

TEST_F(Render, ShowsOtherLinesAndLeavesOutThoseBetween) {
  const int file = sources.add("a.hvi", "one\ntwo\nthree\nfour\nfive\nsix\n");
  const auto d = diagnose("E0301", at(file, "six"), "far apart")
                     .with_secondary(at(file, "one"), "here")
                     .with_secondary(at(file, "four"), "and here");
  EXPECT_EQ(render(d, sources), R"(error[E0301]: far apart
 --> a.hvi:6:1
  |
1 | one
  | --- here
...
4 | four
  | ---- and here
5 | five
6 | six
  | ^^^
)");
}

TEST_F(Render, MarksFirstAndLastLineOfALongSpan) {
  const int file = sources.add("a.hvi", "find u in V\nsuch that\n    integral(x)\n >= 0\n");
  const auto d = diagnose("E0401", {file, 0, 43}, "not coercive").with_label("this statement");
  EXPECT_EQ(render(d, sources), R"(error[E0401]: not coercive
 --> a.hvi:1:1
  |
1 | find u in V
  | ^^^^^^^^^^^
...
4 |  >= 0
  |  ^^^^ this statement
)");
}

TEST_F(Render, ShowsASecondFile) {
  const int main = sources.add("main.hvi", "import laws\nfn f() = 1\n");
  const int other = sources.add("laws.hvi", "\n\nfn f() = 2\n");
  const auto d = diagnose("E0302", at(main, "f()"), "`f` is declared twice")
                     .with_secondary(at(other, "f()"), "first here");
  EXPECT_EQ(render(d, sources), R"(error[E0302]: `f` is declared twice
 --> main.hvi:2:4
  |
2 | fn f() = 1
  |    ^^^
 ::: laws.hvi:3:4
  |
3 | fn f() = 2
  |    --- first here
)");
}

TEST_F(Render, ExpandsTabsAndKnowsWideCharacters) {
  const int file = sources.add("a.hvi", "\tx = 1 # 漢字 y\n");
  EXPECT_EQ(render(diagnose("E0301", at(file, "y"), "behind wide characters"), sources),
            "error[E0301]: behind wide characters\n"
            " --> a.hvi:1:13\n"
            "  |\n"
            "1 |     x = 1 # 漢字 y\n"
            "  |                  ^\n");
}

TEST_F(Render, ReplacesWhatCannotBePrinted) {
  const int file = sources.add("a.hvi", "a\x01\xFF b\n");
  EXPECT_EQ(render(diagnose("E0107", at(file, "b"), "m"), sources),
            "error[E0107]: m\n --> a.hvi:1:5\n  |\n1 | a\uFFFD\uFFFD b\n  |     ^\n");
}

TEST_F(Render, CutsVeryLongLines) {
  const int file =
      sources.add("a.hvi", std::string(100000, 'x') + " here " + std::string(9999, 'y'));
  const std::string text = render(diagnose("E0301", at(file, "here"), "m"), sources);
  EXPECT_LT(text.size(), 800U);
  EXPECT_NE(text.find("a.hvi:1:100002"), std::string::npos);
  // The caret stands below the word.
  const std::size_t line = text.find("1 | ...");
  const std::size_t carets = text.find("^^^^");
  ASSERT_NE(line, std::string::npos);
  ASSERT_NE(carets, std::string::npos);
  EXPECT_EQ(text.find("here") - line, carets - (text.rfind('\n', carets) + 1));
}

TEST_F(Render, WithoutAPlaceThereIsNoSnippet) {
  EXPECT_EQ(
      render(diagnose("E0301", Span{}, "unknown parameter `m`").with_help("see `params`"), sources),
      "error[E0301]: unknown parameter `m`\n  = help: see `params`\n");
}

TEST_F(Render, AtTheEndOfTheFile) {
  const int file = sources.add("a.hvi", "param n =");
  EXPECT_EQ(render(diagnose("E0201", {file, 9, 9}, "m"), sources),
            "error[E0201]: m\n --> a.hvi:1:10\n  |\n1 | param n =\n  |          ^\n");
}

TEST_F(Render, Colours) {
  const int file = sources.add("a.hvi", "x\n");
  const std::string text = render(diagnose("W0101", at(file, "x"), "m"), sources, {true, 50});
  EXPECT_TRUE(text.starts_with("\x1b[1;33mwarning[W0101]\x1b[0m\x1b[1m: m\x1b[0m\n")) << text;
  EXPECT_NE(text.find("\x1b[1;33m^\x1b[0m"), std::string::npos);
}

TEST_F(Render, SeveralInOrderWithALimit) {
  const int file = sources.add("a.hvi", "a b c\n");
  Diagnostics diagnostics;
  for (const char* name : {"c", "b", "a"}) diagnostics.add("E0301", at(file, name), name);
  const std::string text = render(diagnostics, sources, {false, 2});
  EXPECT_EQ(text, "error[E0301]: a\n --> a.hvi:1:1\n  |\n1 | a b c\n  | ^\n\n"
                  "error[E0301]: b\n --> a.hvi:1:3\n  |\n1 | a b c\n  |   ^\n\nand 1 more\n");
}

TEST_F(Render, Json) {
  const int file = sources.add("a.hvi", "λ = \xFF x\n");
  Diagnostics diagnostics;
  diagnostics.add(diagnose("E0301", at(file, "x"), "unknown `\xFF`")
                      .with_label("here")
                      .with_secondary(at(file, "="), "there")
                      .with_note("n")
                      .with_help("h"));
  diagnostics.add("W0101", Span{}, "placeless");
  const std::string text = render_json(diagnostics, sources);
  const std::size_t end = text.find('\n');
  const auto first = nlohmann::json::parse(text.substr(0, end));
  const auto second = nlohmann::json::parse(text.substr(end + 1));
  const auto expected = nlohmann::json::parse(
      R"({"file": "a.hvi", "line": 1, "column": 7, "end_line": 1, "end_column": 8,
          "code": "E0301", "severity": "error", "message": "unknown `\ufffd`", "label": "here",
          "secondary": [{"file": "a.hvi", "line": 1, "column": 3, "end_line": 1, "end_column": 4,
                         "text": "there"}],
          "notes": ["n"], "help": "h"})");
  EXPECT_EQ(first, expected);
  EXPECT_TRUE(second["line"].is_null());
  EXPECT_EQ(second["severity"], "warning");
}

} // namespace
} // namespace hvi::lang
