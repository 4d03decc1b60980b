// The lexer: tokens, comments and lexical errors.
#include "syntax_helpers.hpp"

#include <gtest/gtest.h>

namespace hvi::lang {
namespace {

// The kinds of all tokens but the last, by name.
std::string kinds(const std::string& text) {
  Diagnostics diagnostics;
  const SourceFile source(0, "script.hvi", text);
  std::string result;
  for (const Token& token : lex(source, diagnostics).tokens)
    if (token.kind != TokenKind::end)
      result.append(result.empty() ? "" : " ").append(info(token.kind).name);
  return result;
}

std::string lexical_errors(const std::string& text) {
  Diagnostics diagnostics;
  const SourceFile source(0, "script.hvi", text);
  static_cast<void>(lex(source, diagnostics));
  return places(diagnostics, source);
}

TEST(Lexer, KnowsEveryWordAndSign) {
  for (const TokenInfo& entry : token_table())
    if (!entry.spelling.empty() && entry.kind != TokenKind::state &&
        entry.kind != TokenKind::units) {
      EXPECT_EQ(kinds(std::string(entry.spelling)), entry.name);
      EXPECT_EQ(lexical_errors(std::string(entry.spelling)), "");
    }
}

TEST(Lexer, NoTokenReachesBeyondTheText) {
  for (const TokenInfo& entry : token_table()) {
    const std::string text = "a " + std::string(entry.spelling);
    Diagnostics diagnostics;
    const SourceFile source(0, "script.hvi", text);
    for (const Token& token : lex(source, diagnostics).tokens)
      EXPECT_LE(token.span.end, text.size()) << text;
  }
}

/// Scripts may call things so elsewhere.
TEST(Lexer, StateIsAWordBeforeANameAndOn) {
  EXPECT_EQ(kinds("state bond on glue"), "state name name name");
  EXPECT_EQ(kinds("fn state(x) = state"), "fn name open-paren name close-paren equal name");
}

TEST(Lexer, TakesTheLongestSign) {
  EXPECT_EQ(kinds("a<=b<c==d=e->f-g>h"),
            "name less-equal name less name equal-equal name equal name arrow name minus name "
            "greater name");
}

TEST(Lexer, ReservedWordsAreWholeWords) {
  EXPECT_EQ(kinds("part parts Part part_ _"), "part name name name");
  EXPECT_EQ(kinds("integral such that for all in by steps at accuracy"),
            "name name name name name name name name name name");
}

TEST(Lexer, DerivativeOfClarkeAndPowers) {
  EXPECT_EQ(kinds("j^0(u; v)"), "name clarke name semicolon name close-paren");
  EXPECT_EQ(kinds("j^0 \t\n (u; v)"), "name clarke name semicolon name close-paren");
  EXPECT_EQ(kinds("x^0"), "name caret number");
  EXPECT_EQ(kinds("x^0 + (y)"), "name caret number plus open-paren name close-paren");
  EXPECT_EQ(kinds("x^0.5(y)"), "name caret number open-paren name close-paren");
  EXPECT_EQ(kinds("x^ 0"), "name caret number");
  EXPECT_EQ(kinds("x^00(y)"), "name caret number open-paren name close-paren");
}

TEST(Lexer, Numbers) {
  EXPECT_EQ(kinds("1 1. 1.5 1e3 1.e-3 1.5E+10 007"),
            "number number number number number number number");
  EXPECT_EQ(lexical_errors("1 1. 1.5 1e3 1.e-3 1.5E+10 007 1e308 1e-307"), "");
  EXPECT_EQ(kinds("1.5.x"), "number dot name");
  EXPECT_EQ(kinds(".5"), "dot number");
}

TEST(Lexer, TextsCommentsAndPlaces) {
  Diagnostics diagnostics;
  const SourceFile source(0, "a.hvi",
                          "\xEF\xBB\xBFparam n = 1 \"Länge #\"  # größe  \r\n# two\r\nx");
  const TokenStream stream = lex(source, diagnostics);
  EXPECT_EQ(diagnostics.size(), 0U);
  EXPECT_EQ(print_tokens(source, stream), "1:1      param           param\n"
                                          "1:7      name            n\n"
                                          "1:9      equal           =\n"
                                          "1:11     number          1\n"
                                          "1:13     string          \"Länge #\"\n"
                                          "1:24     comment         # größe\n"
                                          "2:1      comment         # two\n"
                                          "3:1      name            x\n"
                                          "3:2      end\n");
}

struct LexicalCase {
  std::string text;
  std::string errors;
  std::string kinds; // what is left after repair
};

TEST(Lexer, ReportsAndRepairs) {
  const std::vector<LexicalCase> cases{
      {"a @ b", "E0101 1:3-4", "name name"},
      {"a { b }", "E0101 1:3-4", "name name"},
      {"_a b", "E0101 1:1-2", "name"},
      {"€", "E0101 1:1-2", ""},
      {"x − 2", "E0102 1:3-4", "name minus number"},
      {"a·b", "E0102 1:2-3", "name star name"},
      {"a ≤ b", "E0102 1:3-4", "name less-equal name"},
      {"a\u00A0b", "E0102 1:2-3", "name name"},
      {"“text” x", "E0102 1:1-2", "string name"},
      {"u’ x", "E0102 1:2-3", "name prime name"},
      {"x² + 1", "E0102 1:2-3", "name plus number"},
      {"größe + größe", "E0103 1:3-4", "name plus name"},
      {"λ", "E0103 1:1-2", "name"},
      {"2x + 1", "E0104 1:1-3", "number plus number"},
      {"1.2.3 x", "E0104 1:1-6", "number name"},
      {"0x1F", "E0104 1:1-5", "number"},
      {"1e", "E0104 1:1-3", "number"},
      {"10_000", "E0104 1:1-7", "number"},
      {"1e999 x", "E0105 1:1-6", "number name"},
      {"1e-999", "E0105 1:1-7", "number"},
      {"\"open\nx", "E0106 1:1-6", "string name"},
      {"\"open  \r\nx", "E0106 1:1-6", "string name"},
      {"a\x01\x01 b", "E0107 1:2-4", "name name"},
      {"a\rb", "E0107 1:2-3", "name name"},
      {"a # c\rb\rc\nd # e\rf\r\n", "E0107 1:6-7", "name name"},
      {"a \xFF\xFE b", "E0108 1:3-5", "name name"},
      {"a && b", "E0110 1:3-5", "name and name"},
      {"!a & b", "E0110 1:1-2; E0110 1:4-5", "not name and name"},
      {"a % b\nc", "E0110 1:3-4", "name name"},
      {"5 % b\nc", "E0110 1:3-4", "number name"}, // a comment behind a number
      {"5 [%] + 2 %) c\nd", "E0110 1:4-5; E0110 1:11-12",
       "number open-bracket close-bracket plus number name"},
      {"5 [\u00b5m*k\u03a9]", "E0330 1:4-6; E0330 1:7-9",
       "number open-bracket name star name close-bracket"},
      {"[\u00b5, 1]", "E0103 1:2-3", "open-bracket name comma number close-bracket"},
      {"a // b\nc", "E0210 1:3-5", "name name"},
      {"a /* b\n c */ d", "E0210 1:3-5", "name name"},
      {"a**b", "E0211 1:2-4", "name caret name"},
      {"a || b <> c", "E0212 1:3-5; E0212 1:8-10", "name or name not-equal name"},
  };
  for (const LexicalCase& c : cases) {
    EXPECT_EQ(lexical_errors(c.text), c.errors) << c.text;
    EXPECT_EQ(kinds(c.text), c.kinds) << c.text;
  }
}

TEST(Lexer, NamesTheAsciiCharacterThatIsMeant) {
  Diagnostics diagnostics;
  const SourceFile source(0, "a.hvi", "x − μ");
  static_cast<void>(lex(source, diagnostics));
  ASSERT_EQ(diagnostics.size(), 2U);
  EXPECT_EQ(diagnostics.items()[0].help, "write `-`");
  EXPECT_EQ(diagnostics.items()[1].help, "write `mu`");
}

TEST(Lexer, LimitsTheErrorsOfAFile) {
  Diagnostics diagnostics;
  const SourceFile source(0, "a.hvi", std::string(300000, '@'));
  static_cast<void>(lex(source, diagnostics));
  EXPECT_EQ(diagnostics.size(), 100U);
}

TEST(Lexer, RefusesAFileThatIsTooLarge) {
  EXPECT_EQ(lexical_errors(std::string(max_script_bytes + 1, '@')), "E0109 1:1-1");
  EXPECT_EQ(lexical_errors(std::string(max_script_bytes, ' ')), "");
}

} // namespace
} // namespace hvi::lang
