// The parser's class, shared by the parse_*.cpp files: one file per group of productions.
#pragma once

#include "lang/diag/diagnostic.hpp"
#include "lang/syntax/ast.hpp"
#include "lang/syntax/token.hpp"

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hvi::lang {

/// Brackets, exponents and negations within each other; deeper is an error, not a crash.
inline constexpr int max_nesting = 400;
/// After so many errors the rest of a file is not read: it is no script.
inline constexpr int max_syntax_errors = 200;
/// Height of one tree, which long chains (a + b + c + ...) add to. Later phases recurse over it.
inline constexpr int max_height = 1200;

class Parser {
public:
  Parser(const SourceFile& source, TokenStream stream, Diagnostics& diagnostics);

  ast::Program program();
  std::optional<ast::Expr> whole_expression();

private:
  // Thrown after an error was reported; caught where the parser picks up again.
  struct Abandoned {};

  // One level of nesting, for as long as it lives.
  class Level {
  public:
    explicit Level(Parser& parser);
    ~Level() { --parser_.nesting_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;

  private:
    Parser& parser_;
  };

  // --- cursor (parser.cpp)
  [[nodiscard]] const Token& peek(std::size_t ahead = 0) const;
  [[nodiscard]] const Token& previous() const;
  [[nodiscard]] bool at(TokenKind kind) const { return peek().kind == kind; }
  [[nodiscard]] bool at_word(std::string_view word, std::size_t ahead = 0) const;
  [[nodiscard]] std::string_view text(const Token& token) const;
  [[nodiscard]] Span span_from(const Span& first) const { return join(first, previous().span); }
  // Two tokens without anything between them.
  [[nodiscard]] bool glued(const Token& left, const Token& right) const;
  Token take();
  bool accept(TokenKind kind);
  bool accept_word(std::string_view word);
  Token expect(TokenKind kind, std::string_view what = {});
  Token expect_word(std::string_view word);

  // --- errors (parse_error.cpp)
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
  [[nodiscard]] bool begins_statement(std::size_t index) const;
  [[nodiscard]] bool at_misspelt_statement() const;
  void recover();

  // --- statements (parse_decl.cpp)
  std::optional<ast::Statement> statement();
  void end_of_statement();
  [[noreturn]] void fail_no_statement();
  [[noreturn]] void fail_operator_missing(const std::string& otherwise);
  ast::Name name(std::string_view what);
  ast::Name declared_name(std::string_view what);
  ast::Name member_name();
  ast::Text string();
  std::optional<ast::Text> optional_string();
  ast::Import import_statement();
  ast::Units units();
  ast::Param param();
  ast::Mesh mesh();
  ast::Tensor tensor();
  ast::Kernel kernel();
  ast::Superpotential superpotential();
  ast::State state();
  std::vector<ast::LawParameter> law_parameters();
  ast::Fn fn();
  ast::Space space();
  ast::ZeroCondition zero_condition();
  ast::PeriodicCondition periodic_condition();

  // --- regions (parse_region.cpp)
  ast::Part part();
  ast::Region region();
  ast::RegionTerm region_term();
  ast::Expr region_path();

  // --- the inequality (parse_find.cpp)
  ast::Find find();
  void find_clauses(ast::Find& find);
  void find_clause(ast::Find& find, int clause);
  void such_that(ast::Find& find);
  void imposed_values(ast::Find& find);
  ast::ImposedValue imposed_value();
  ast::TimeClause time_clause();
  ast::InitialValue initial_value(const Span& first);
  void test_functions(ast::Find& find);
  void settings(ast::Find& find);
  void relation(ast::Find& find);
  ast::Form form();
  void recover_in_form();
  ast::FormTerm form_term();
  ast::Integral integral();
  void check_after_integral();
  ast::Expr factor();
  [[noreturn]] void fail_no_integral(const Span& term);

  // --- results (parse_report.cpp)
  ast::Report report_statement();
  void recover_in_report();
  ast::ReportItem report_item();
  [[nodiscard]] bool at_report_item() const;
  Span from_start();
  ast::TableItem table_item();
  ast::FieldsItem fields_item();
  ast::PictureItem picture_item();
  ast::LineItem line_item();
  ast::PlotItem plot_item();
  ast::Binding binding();
  std::optional<ast::Expr> every_steps();
  std::optional<ast::Text> to_file();
  ast::Expr time_value();
  [[nodiscard]] bool at_time() const;
  std::optional<ast::Expr> optional_time();
  ast::Expect expect_statement();
  ast::Study study();
  ast::Ladder ladder();

  // --- expressions (parse_expr.cpp, parse_postfix.cpp)
  ast::Expr expr();
  ast::Expr cases();
  ast::Case single_case();
  void check_colon_as_arrow(const ast::Condition& condition);
  ast::Expr sum();
  ast::Expr contraction();
  ast::Expr product();
  ast::Expr unary();
  ast::Expr power();
  ast::Expr postfix();
  ast::Expr primary();
  ast::Expr number();
  ast::UnitText unit();
  void unit_power();
  void unit_exponent();
  ast::UnitText unit_in_brackets();
  ast::Expr with_unit(ast::Expr value);
  ast::Expr reference();
  ast::Expr parenthesised();
  ast::Expr list();
  ast::Expr call_tail(ast::Expr callee);
  std::vector<ast::Argument> arguments(const Token& open, const ast::Expr& callee);
  ast::Argument argument();
  ast::Expr clarke_tail(ast::Expr law);
  ast::Expr make(ast::Expr::Node node, const Span& span);
  ast::Expr binary(ast::BinaryOp op, const Span& op_span, ast::Expr left, ast::Expr right);
  void check_callee(const ast::Expr& callee);

  // --- conditions (parse_condition.cpp)
  ast::Condition condition();
  ast::Condition and_condition();
  ast::Condition not_condition();
  ast::Condition comparison();
  ast::Condition grouped_condition();
  ast::Condition inside();
  ast::CompareOp comparison_sign();
  ast::Condition make_condition(ast::Condition::Node node, const Span& span);
  void find_grouped_conditions();

  const SourceFile& source_;
  Diagnostics& diagnostics_;
  std::vector<Token> tokens_;
  std::vector<std::uint32_t> damage_;
  std::vector<bool> groups_condition_; // by token: a "(" around a condition
  std::size_t at_ = 0;
  std::size_t statement_begin_ = 0; // token index
  int nesting_ = 0;
  int n_errors_ = 0;
  bool spoilt_ = false;                  // a part of the statement was left out after an error
  bool names_lost_ = false;              // what it would have declared is not known
  bool in_integral_ = false;             // within the integrand of a form
  std::vector<Token> open_;              // brackets not closed yet
  std::vector<ast::Name> declared_;      // by the statement being read
  std::vector<ast::UnitText> units_;     // of the file so far
  std::set<std::string> reserved_names_; // words that were reported as names
};

} // namespace hvi::lang
