// Where the parser stands among the tokens of a file, and what it says when it cannot go on.
#pragma once

#include "lang/diag/diagnostic.hpp"
#include "lang/syntax/token.hpp"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hvi::lang {

/// Thrown after an error was reported; caught where the parser picks up again.
struct Abandoned {};

class Cursor {
public:
  Cursor(const SourceFile& source, TokenStream stream, Diagnostics& diagnostics)
      : source_(source), diagnostics_(diagnostics), tokens_(std::move(stream.tokens)),
        damage_(std::move(stream.damage)) {}

  // One level of nesting, for as long as it lives.
  class Level {
  public:
    explicit Level(Cursor& cursor);
    ~Level() { --cursor_.nesting_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;

  private:
    Cursor& cursor_;
  };

  // A statement begins here: what was left open or out is that of the one before.
  void begin_statement();
  [[nodiscard]] TokenKind statement_word() const { return tokens_[statement_begin_].kind; }
  // Does another statement begin here?
  [[nodiscard]] bool at_statement() const { return begins_statement(at_); }
  // A part of the statement is left out after an error.
  void spoil() { spoilt_ = true; }
  [[nodiscard]] bool spoilt() const { return spoilt_; }
  [[nodiscard]] int n_errors() const { return n_errors_; }

  // Brackets that are not closed yet.
  void opened(const Token& open) { open_.push_back(open); }
  void closed() { open_.pop_back(); }
  void forget_open() { open_.clear(); }
  [[nodiscard]] const Token& innermost() const { return open_.back(); }

  [[nodiscard]] const std::vector<Token>& tokens() const { return tokens_; }
  [[nodiscard]] std::size_t place() const { return at_; }
  [[nodiscard]] const Token& peek(std::size_t ahead = 0) const;
  [[nodiscard]] const Token& previous() const;
  [[nodiscard]] bool at(TokenKind kind) const { return peek().kind == kind; }
  [[nodiscard]] bool at_word(std::string_view word, std::size_t ahead = 0) const;
  [[nodiscard]] std::string_view text(const Token& token) const { return text(token.span); }
  [[nodiscard]] std::string_view text(const Span& span) const { return source_.text(span); }
  [[nodiscard]] Span span_from(const Span& first) const { return join(first, previous().span); }
  // Two tokens without anything between them.
  [[nodiscard]] bool glued(const Token& left, const Token& right) const;
  Token take();
  bool accept(TokenKind kind);
  bool accept_word(std::string_view word);
  Token expect(TokenKind kind, std::string_view what = {});
  Token expect_word(std::string_view word);

  // What is wrong (parse_error.cpp).
  // Reports unless an earlier lexical error of the statement explains it.
  void report(Diagnostic diagnostic);
  [[noreturn]] void fail(Diagnostic diagnostic);
  [[noreturn]] void fail_expected(std::string_view what);
  // Something else stands where a bracket could close; or its line ends before it does.
  [[noreturn]] void fail_unclosed(const Token& open, TokenKind close);
  [[noreturn]] void fail_not_closed(const Token& open, TokenKind close);
  // What the parser found, for messages: "`)`", "the end of the file".
  [[nodiscard]] std::string found(const Token& token) const;
  // Where something is missing: the next token, or the end of the last line before a new statement.
  [[nodiscard]] Span missing_place() const;
  // Fails where the line before has ended without what belongs to it.
  [[noreturn]] void fail_at_line_end(std::string_view what);
  // A word that continues a statement (`at`, `within`, `where`), so that no expression begins here.
  [[nodiscard]] bool at_clause_word() const;
  // Slips that explain an unexpected token better than "expected, found"; fails if it knows one.
  void fail_on_known_slip();
  [[nodiscard]] bool at_decimal_comma() const;
  [[noreturn]] void fail_decimal_comma();
  // Fails where the token before is one.
  void check_decimal_comma_before();
  [[nodiscard]] bool begins_statement(std::size_t index) const;
  void recover();
  [[noreturn]] void fail_operator_missing(const std::string& otherwise);

private:
  [[nodiscard]] bool at_misspelt_statement() const;

  const SourceFile& source_;
  Diagnostics& diagnostics_;
  std::vector<Token> tokens_;
  std::vector<std::uint32_t> damage_;
  std::size_t at_ = 0;
  std::size_t statement_begin_ = 0; // token index
  int nesting_ = 0;
  int n_errors_ = 0;
  bool spoilt_ = false;
  std::vector<Token> open_;
};

} // namespace hvi::lang
