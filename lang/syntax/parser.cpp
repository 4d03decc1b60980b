// Entry of the parser, its cursor, and the loop over statements. See parser.hpp.
#include "lang/syntax/parser.hpp"

#include "lang/syntax/lexer.hpp"
#include "lang/syntax/parser_impl.hpp"

#include <algorithm>

namespace hvi::lang {

Parser::Parser(const SourceFile& source, TokenStream stream, Diagnostics& diagnostics)
    : source_(source), diagnostics_(diagnostics), tokens_(std::move(stream.tokens)),
      damage_(std::move(stream.damage)) {
  find_grouped_conditions();
}

const Token& Parser::peek(std::size_t ahead) const {
  return tokens_[std::min(at_ + ahead, tokens_.size() - 1)];
}

const Token& Parser::previous() const { return tokens_[at_ > 0 ? at_ - 1 : 0]; }

std::string_view Parser::text(const Token& token) const { return source_.text(token.span); }

bool Parser::at_word(std::string_view word, std::size_t ahead) const {
  return peek(ahead).kind == TokenKind::name && text(peek(ahead)) == word;
}

bool Parser::glued(const Token& left, const Token& right) const {
  return left.span.end == right.span.begin;
}

Token Parser::take() {
  const Token token = peek();
  if (token.kind != TokenKind::end) ++at_;
  return token;
}

bool Parser::accept(TokenKind kind) {
  if (!at(kind)) return false;
  take();
  return true;
}

bool Parser::accept_word(std::string_view word) {
  if (!at_word(word)) return false;
  take();
  return true;
}

Token Parser::expect(TokenKind kind, std::string_view what) {
  if (at(kind)) return take();
  const std::string sign = "`" + std::string(info(kind).spelling) + "`";
  if (what.empty()) what = sign;
  if (kind == TokenKind::equal && peek().first_on_line) fail_at_line_end(what);
  fail_expected(what);
}

Token Parser::expect_word(std::string_view word) {
  const std::string what = "`" + std::string(word) + "`";
  if (peek().first_on_line && !at(TokenKind::name)) fail_at_line_end(what);
  if (!at_word(word)) fail_expected(what);
  return take();
}

Parser::Level::Level(Parser& parser) : parser_(parser) {
  if (parser_.nesting_ >= max_nesting)
    parser_.fail(diagnose("E0216", parser_.peek().span, "this is nested too deeply")
                     .with_note("at most " + std::to_string(max_nesting) + " levels are read")
                     .with_help("give parts of it a name with `fn` or `tensor`"));
  ++parser_.nesting_;
}

// script = { statement } ;
ast::Program Parser::program() {
  ast::Program program;
  program.file = source_.id();
  program.size = source_.text().size();
  while (!at(TokenKind::end) && n_errors_ < max_syntax_errors) {
    statement_begin_ = at_;
    declared_.clear();
    open_.clear();
    in_integral_ = false;
    spoilt_ = false;
    try {
      if (auto read = statement()) program.statements.push_back(std::move(*read));
    } catch (const Abandoned&) {
      const TokenKind kind = tokens_[statement_begin_].kind;
      const bool declares = is_statement_word(kind) && kind != TokenKind::report &&
                            kind != TokenKind::expect && kind != TokenKind::study;
      names_lost_ = names_lost_ || kind == TokenKind::import_ || (declares && declared_.empty());
      program.broken.insert(program.broken.end(), declared_.begin(), declared_.end());
      recover();
    }
  }
  program.names_lost = names_lost_;
  program.units = std::move(units_);
  return program;
}

std::optional<ast::Expr> Parser::whole_expression() {
  try {
    ast::Expr result = expr();
    if (!at(TokenKind::end)) fail_expected("the end of the expression");
    return result;
  } catch (const Abandoned&) {
    return std::nullopt;
  }
}

ast::Program parse(const SourceFile& source, Diagnostics& diagnostics) {
  return Parser(source, lex(source, diagnostics), diagnostics).program();
}

std::optional<ast::Expr> parse_expression(const SourceFile& source, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.n_errors();
  TokenStream stream = lex(source, diagnostics);
  auto result = Parser(source, std::move(stream), diagnostics).whole_expression();
  if (diagnostics.n_errors() > errors_before) return std::nullopt;
  return result;
}

} // namespace hvi::lang
