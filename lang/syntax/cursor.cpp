#include "lang/syntax/cursor.hpp"

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace {

/// Brackets, exponents and negations within each other; deeper is an error, not a crash.
constexpr int max_nesting = 400;

} // namespace

Cursor::Level::Level(Cursor& cursor) : cursor_(cursor) {
  if (cursor_.nesting_ >= max_nesting)
    cursor_.fail(diagnose("E0216", cursor_.peek().span, "this is nested too deeply")
                     .with_note("at most " + std::to_string(max_nesting) + " levels are read")
                     .with_help("give parts of it a name with `fn` or `tensor`"));
  ++cursor_.nesting_;
}

void Cursor::begin_statement() {
  statement_begin_ = at_;
  open_.clear();
  spoilt_ = false;
}

const Token& Cursor::peek(std::size_t ahead) const {
  return tokens_[std::min(at_ + ahead, tokens_.size() - 1)];
}

const Token& Cursor::previous() const { return tokens_[at_ > 0 ? at_ - 1 : 0]; }

bool Cursor::glued(const Token& left, const Token& right) const {
  return left.span.end == right.span.begin;
}

Token Cursor::take() {
  const Token token = peek();
  if (token.kind != TokenKind::end) ++at_;
  return token;
}

bool Cursor::accept(TokenKind kind) {
  if (!at(kind)) return false;
  take();
  return true;
}

bool Cursor::accept_word(std::string_view word) {
  if (!at_word(word)) return false;
  take();
  return true;
}

Token Cursor::expect(TokenKind kind, std::string_view what) {
  if (at(kind)) return take();
  const std::string sign = "`" + std::string(info(kind).spelling) + "`";
  if (what.empty()) what = sign;
  if (kind == TokenKind::equal && peek().first_on_line) fail_at_line_end(what);
  if (kind == TokenKind::equal && at(TokenKind::equal_equal)) {
    report(diagnose("E0201", peek().span, "expected `=`, found `==`")
               .with_label("write `=`")
               .with_help("`==` compares two values, in a condition"));
    return take(); // all else may be right
  }
  fail_expected(what);
}

Token Cursor::expect_word(std::string_view word) {
  const std::string what = "`" + std::string(word) + "`";
  if (peek().first_on_line && !at(TokenKind::name)) fail_at_line_end(what);
  if (!at_word(word)) fail_expected(what);
  return take();
}

bool Cursor::at_word(std::string_view word, std::size_t ahead) const {
  return peek(ahead).kind == TokenKind::name && text(peek(ahead)) == word;
}

} // namespace hvi::lang
