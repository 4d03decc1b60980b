// What the parser says when it does not find what it expects, and where it picks up again. One
// mistake gives one message: a statement is left at its first error. See cursor.hpp.
#include "lang/diag/suggest.hpp"
#include "lang/syntax/cursor.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace hvi::lang {
namespace {

bool is_operator(TokenKind kind) {
  return (kind >= TokenKind::plus && kind <= TokenKind::colon) || is_comparison(kind);
}

bool is_closing(TokenKind kind) {
  return kind == TokenKind::close_paren || kind == TokenKind::close_bracket;
}

// Words that continue a statement, something stands behind them.
bool is_clause_word(std::string_view word) {
  constexpr std::array<std::string_view, 14> words{"at",   "by",    "every", "for",   "from",
                                                   "in",   "on",    "such",  "to",    "using",
                                                   "when", "where", "with",  "within"};
  return std::find(words.begin(), words.end(), word) != words.end();
}

// Words that stand behind an expression, which may be a name that is a clause word: `by on points`.
bool follows_expression(std::string_view word) {
  constexpr std::array<std::string_view, 10> words{"against", "deformed", "fields", "line",
                                                   "picture", "plot",     "points", "relative",
                                                   "steps",   "table"};
  return std::find(words.begin(), words.end(), word) != words.end();
}

// What stands between backquotes in a sentence: "`table` or `fields`" has two.
std::vector<std::string_view> quoted(std::string_view sentence) {
  std::vector<std::string_view> words;
  for (std::size_t open = sentence.find('`'); open != sentence.npos;) {
    const std::size_t close = sentence.find('`', open + 1);
    if (close == sentence.npos) break;
    words.push_back(sentence.substr(open + 1, close - open - 1));
    open = sentence.find('`', close + 1);
  }
  return words;
}

} // namespace

void Cursor::report(Diagnostic diagnostic) {
  // A lexical error left something out of this statement: what is missing now is that. Behind a
  // statement word the damage counts from there, else from the end of the statement before.
  const Token& first = tokens_[statement_begin_];
  const bool from_word = is_statement_word(first.kind) || statement_begin_ == 0;
  const std::uint32_t begin =
      from_word ? first.span.begin : tokens_[statement_begin_ - 1].span.end + 1;
  const auto damage = std::lower_bound(damage_.begin(), damage_.end(), begin);
  if (damage != damage_.end() && *damage <= peek().span.end) return;
  if (diagnostics_.has_error_at(diagnostic.primary)) return; // `body & wall`: said by the lexer
  ++n_errors_;
  diagnostics_.add(std::move(diagnostic));
}

void Cursor::fail(Diagnostic diagnostic) {
  report(std::move(diagnostic));
  throw Abandoned{};
}

std::string Cursor::found(const Token& token) const {
  if (token.kind == TokenKind::end) return "but the file ends";
  if (begins_statement(static_cast<std::size_t>(&token - tokens_.data())) && token.first_on_line)
    return "but the statement ends";
  if (token.kind == TokenKind::string) return "found a text";
  return "found `" + std::string(text(token)) + "`";
}

Span Cursor::missing_place() const {
  if (at_ > 0 && (at(TokenKind::end) || (peek().first_on_line && begins_statement(at_))))
    return after(previous().span);
  return peek().span;
}

void Cursor::fail_expected(std::string_view what) {
  fail_on_known_slip();
  const std::string expected(what);
  auto diagnostic =
      diagnose("E0201", missing_place(), "expected " + expected + ", " + found(peek()))
          .with_label("expected " + expected);
  const std::string nearest =
      at(TokenKind::name) ? did_you_mean(text(peek()), quoted(what)) : std::string();
  fail(nearest.empty() ? std::move(diagnostic) : std::move(diagnostic).with_help(nearest));
}

void Cursor::fail_at_line_end(std::string_view what) {
  const std::string expected(what);
  fail(diagnose("E0201", after(previous().span), "expected " + expected + ", but the line ends")
           .with_label("expected " + expected));
}

bool Cursor::at_clause_word() const {
  const TokenKind next = peek(1).kind;
  const bool word = next == TokenKind::name && !is_clause_word(text(peek(1))) &&
                    !follows_expression(text(peek(1)));
  // Elsewhere a text stands behind a value: `param a = to "what it is"`.
  const bool file =
      next == TokenKind::string && at_word("to") && statement_word() == TokenKind::report;
  const bool operand = word || file || next == TokenKind::number || next == TokenKind::open_bracket;
  return at(TokenKind::name) && operand && !peek(1).first_on_line && is_clause_word(text(peek()));
}

void Cursor::fail_unclosed(const Token& open, TokenKind close) {
  const std::string wanted = "`" + std::string(info(close).spelling) + "`";
  const bool line_ends = peek().first_on_line || at(TokenKind::end);
  if (!line_ends) fail_on_known_slip();
  if (is_closing(peek().kind) && peek().kind != close && close != TokenKind::semicolon)
    fail(diagnose("E0205", peek().span, "expected " + wanted + ", " + found(peek()))
             .with_label("expected " + wanted)
             .with_secondary(open.span, "opened here"));
  if (line_ends) fail_not_closed(open, close);
  const bool separated = close != TokenKind::semicolon && open.kind != TokenKind::clarke;
  const std::string expected = separated ? "`,`, an operator or " + wanted : wanted;
  const bool place = at_word("at") && statement_word() == TokenKind::report;
  fail(diagnose("E0201", peek().span, "expected " + expected + ", " + found(peek()))
           .with_label("expected " + expected)
           .with_secondary(open.span, "opened here")
           .with_help(place ? "`at` stands behind a whole column, `a = u.y/2 at [1, 0]`, which is "
                              "of one place: what is of two are two columns"
                            : ""));
}

void Cursor::fail_not_closed(const Token& open, TokenKind close) {
  fail(diagnose("E0204", after(previous().span), "this bracket is not closed")
           .with_label("expected `" + std::string(info(close).spelling) + "`")
           .with_secondary(open.span, "opened here"));
}

bool Cursor::at_decimal_comma() const {
  return at(TokenKind::comma) && at_ > 0 && previous().kind == TokenKind::number &&
         peek(1).kind == TokenKind::number && glued(previous(), peek()) && glued(peek(), peek(1));
}

void Cursor::fail_decimal_comma() {
  const std::string whole(text(previous()));
  const std::string rest(text(peek(1)));
  // 1,000 may be a thousand; 0,5 and 1,25 are not.
  const std::string thousands = rest.size() == 3 ? " or `" + whole + rest + "`" : "";
  fail(diagnose("E0218", join(previous().span, peek(1).span), "a number with a comma")
           .with_label("a number has a decimal point and no separators")
           .with_help("write `" + whole + "." + rest + "`" + thousands));
}

void Cursor::fail_on_known_slip() {
  const Token& token = peek();
  if (at_decimal_comma()) fail_decimal_comma();
  if (token.kind == TokenKind::dot && peek(1).kind == TokenKind::number && glued(token, peek(1)))
    fail(diagnose("E0201", join(token.span, peek(1).span), "expected a digit before `.`")
             .with_help("write `0." + std::string(text(peek(1))) + "`"));
  if (is_closing(token.kind) && open_.empty())
    fail(diagnose("E0205", token.span, "this " + std::string(text(token)) + " closes nothing")
             .with_label("no bracket is open"));
  if (token.kind == TokenKind::prime)
    fail(diagnose("E0225", token.span, "`'` is the time derivative and follows a name")
             .with_help("texts stand between double quotes, \"like this\""));
  if (token.kind == TokenKind::bar)
    fail(diagnose("E0226", token.span, "cases cannot begin here")
             .with_help("write `abs(x)` or `norm(x)` for |x|, and cases within a formula in "
                        "parentheses: `2*(| r < 0 -> 0 | otherwise -> r)`"));
  if (is_comparison(token.kind))
    fail(diagnose("E0221", token.span, "a comparison is not a value")
             .with_help("conditions stand in cases (`| x > 0 -> 1 | otherwise -> 0`), behind "
                        "`where` and behind `when`"));
}

// Every statement word is followed by a name or a text; anything else means that the word is meant
// as a name (`mesh.top`, `part = ...`), unless the line begins with it.
bool Cursor::begins_statement(std::size_t index) const {
  if (!is_statement_word(tokens_[index].kind)) return false;
  const TokenKind before = index > 0 ? tokens_[index - 1].kind : TokenKind::end;
  if (before == TokenKind::dot) return false;
  const bool first = tokens_[index].first_on_line;
  const bool after_operand = before == TokenKind::name || before == TokenKind::number ||
                             before == TokenKind::string || before == TokenKind::prime ||
                             is_closing(before);
  if (!first && index > 0 && !after_operand) return false;
  // `by mesh steps`; but in `zero on in find u ...` the `in` is a name.
  const bool named = index > 1 && tokens_[index - 2].kind == TokenKind::name &&
                     is_clause_word(text(tokens_[index - 2]));
  if (!first && !named && before == TokenKind::name && is_clause_word(text(tokens_[index - 1])))
    return false;
  const Token& next = tokens_[std::min(index + 1, tokens_.size() - 1)];
  if (next.kind == TokenKind::name || next.kind == TokenKind::string || is_reserved(next.kind))
    return true;
  const bool continued = before == TokenKind::comma || before == TokenKind::open_paren ||
                         before == TokenKind::open_bracket || is_operator(before);
  return first && !continued;
}

// A line that begins with a misspelt statement word: `tensr A = ...`.
bool Cursor::at_misspelt_statement() const {
  const TokenKind third = peek(2).kind;
  return peek().first_on_line && at(TokenKind::name) && peek(1).kind == TokenKind::name &&
         (third == TokenKind::equal || third == TokenKind::open_paren) &&
         suggest(text(peek()), statement_words()).has_value();
}

void Cursor::recover() {
  if (at_ == statement_begin_) take();
  while (!at(TokenKind::end) && !begins_statement(at_) && !at_misspelt_statement()) take();
}

void Cursor::fail_operator_missing(const std::string& otherwise) {
  fail(diagnose("E0224", peek().span,
                "an operator is missing before `" + std::string(text(peek())) + "`")
           .with_label("expected an operator or " + otherwise)
           .with_help(previous().kind == TokenKind::name && text(previous()) == "if"
                          ? "values by cases are written `| x > 0 -> 1 | otherwise -> 0`"
                          : "a product is written with `*`"));
}

void Cursor::check_decimal_comma_before() {
  --at_;
  if (at_decimal_comma()) fail_decimal_comma();
  ++at_;
}

} // namespace hvi::lang
