// Entry of the parser and the loop over statements. See parser.hpp.
#include "lang/syntax/parser.hpp"

#include "lang/diag/suggest.hpp"
#include "lang/syntax/lexer.hpp"
#include "lang/syntax/parser_impl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::lang {

namespace {

/// After so many errors the rest of a file is not read: it is no script.
constexpr int max_syntax_errors = 200;

/// Where a word belongs that stands behind what it should stand before, or without its comma.
std::string place_of_word(std::string_view word) {
  if (word == "deformed") return "`deformed = 20` stands before `at t` and `to`";
  if (word == "relative") return "`relative` stands behind the tolerance: `within 1e-6 relative`";
  if (word == "zero" || word == "periodic")
    return "what holds for a space stands behind commas: `vector P1 on body, zero on wall`";
  return {};
}

std::string help_for_no_statement(std::string_view written) {
  if (std::ranges::find(report_item_words, written) != report_item_words.end())
    return fmt::format("`{0}` is a part of the report: `report {0} ...`", written);
  std::string help = did_you_mean(written, statement_words());
  if (!help.empty()) return help;
  help = "statements begin with";
  for (const std::string_view word : statement_words())
    help.append(word == "import" ? " `" : ", `").append(word).append("`");
  return help;
}

} // namespace

// script = { statement } ;
ast::Program Parser::program() {
  ast::Program program;
  program.file = source_.id();
  program.size = source_.text().size();
  expressions_.find_grouped_conditions();
  while (!cursor_.at(TokenKind::end) && cursor_.n_errors() < max_syntax_errors) {
    cursor_.begin_statement();
    names_.forget_declared();
    expressions_.in_integral = false;
    try {
      if (auto read = statement()) program.statements.push_back(std::move(*read));
    } catch (const Abandoned&) {
      const TokenKind kind = cursor_.statement_word();
      const std::vector<ast::Name>& declared = names_.declared();
      const bool declares = is_statement_word(kind) && kind != TokenKind::report &&
                            kind != TokenKind::expect && kind != TokenKind::study;
      names_lost_ = names_lost_ || kind == TokenKind::import_ || (declares && declared.empty());
      program.broken.insert(program.broken.end(), declared.begin(), declared.end());
      cursor_.recover();
    }
  }
  program.names_lost = names_lost_;
  program.units = expressions_.take_units();
  return program;
}

ast::Program parse(const SourceFile& source, Diagnostics& diagnostics) {
  return Parser(source, lex(source, diagnostics), diagnostics).program();
}

// statement = import | units | param | mesh | part | tensor | kernel | superpotential | state | fn
// | space | find | report | expect | study ;
std::optional<ast::Statement> Parser::statement() {
  const auto read = [this]() -> ast::Statement {
    switch (cursor_.peek().kind) {
    case TokenKind::import_:
      return declarations_.import_statement();
    case TokenKind::units:
      return declarations_.units();
    case TokenKind::param:
      return declarations_.param();
    case TokenKind::mesh:
      return declarations_.mesh();
    case TokenKind::part:
      return regions_.part();
    case TokenKind::tensor:
      return declarations_.tensor();
    case TokenKind::kernel:
      return declarations_.kernel();
    case TokenKind::superpotential:
      return declarations_.superpotential();
    case TokenKind::state:
      return declarations_.state();
    case TokenKind::fn:
      return declarations_.fn();
    case TokenKind::space:
      return declarations_.space();
    case TokenKind::find:
      return find_.find();
    case TokenKind::report:
      return report_.report_statement();
    case TokenKind::expect:
      return report_.expect_statement();
    case TokenKind::study:
      return report_.study();
    default:
      fail_no_statement();
    }
  };
  ast::Statement result = read();
  end_of_statement();
  return result;
}

// What follows must be the next statement. A new line is left to statement(), which knows better.
void Parser::end_of_statement() {
  if (cursor_.at(TokenKind::semicolon)) {
    cursor_.report(
        diagnose("E0217", cursor_.peek().span, "statements have no `;`").with_help("leave it out"));
    cursor_.take();
  }
  // `param a = on param b = 2`: what has been read is whole, so that `on` is a name.
  const bool another =
      is_statement_word(cursor_.peek().kind) &&
      (cursor_.peek(1).kind == TokenKind::name || cursor_.peek(1).kind == TokenKind::string);
  if (cursor_.at(TokenKind::end) || cursor_.peek().first_on_line || cursor_.at_statement() ||
      another)
    return;
  if (cursor_.at(TokenKind::equal))
    cursor_.fail(
        diagnose("E0201", cursor_.peek().span, "expected the end of the statement, found `=`"));
  cursor_.fail_on_known_slip();
  const TokenKind next = cursor_.peek().kind;
  if (const std::string help = place_of_word(cursor_.text(cursor_.peek())); !help.empty())
    cursor_.fail(diagnose("E0201", cursor_.peek().span,
                          "expected the end of the statement, " + cursor_.found(cursor_.peek()))
                     .with_label("expected the end of the statement")
                     .with_help(help));
  if ((next == TokenKind::name && !cursor_.at_clause_word()) || next == TokenKind::number ||
      next == TokenKind::open_paren)
    cursor_.fail_operator_missing("the end of the statement");
  cursor_.fail_expected("the end of the statement");
}

// Words that begin a statement only before what follows them there: that is missing.
void Parser::fail_late_word(std::string_view written) {
  if (written == info(TokenKind::units).spelling) {
    cursor_.take();
    if (!cursor_.at(TokenKind::name) || cursor_.peek().first_on_line)
      cursor_.fail_expected("units, as in `units mm, N, s`");
    cursor_.take();
    cursor_.fail_expected("`,` and another unit");
  }
  if (written == info(TokenKind::state).spelling) {
    cursor_.take();
    if (!cursor_.at(TokenKind::name)) cursor_.fail_expected("the name of the state");
    cursor_.take();
    cursor_.fail_expected("`on` and the part where the state lives");
  }
}

void Parser::fail_no_statement() {
  const Token& token = cursor_.peek();
  if (token.kind == TokenKind::semicolon) {
    cursor_.fail(diagnose("E0217", token.span, "statements have no `;`").with_help("leave it out"));
  }
  if (token.kind != TokenKind::name) cursor_.fail_on_known_slip();
  const std::string_view written = cursor_.text(token);
  constexpr std::array<std::string_view, 5> imports{"include", "use", "using", "require", "from"};
  const bool imports_something =
      std::find(imports.begin(), imports.end(), written) != imports.end();
  names_lost_ = names_lost_ || imports_something || suggest(written, statement_words()) == "import";
  // Its name is not unknown to the lines below, whatever the statement was meant to be.
  if (cursor_.peek(1).kind == TokenKind::name)
    names_.note_declared({std::string(cursor_.text(cursor_.peek(1))), cursor_.peek(1).span});
  fail_late_word(written);
  cursor_.report(diagnose("E0202", token.span, "expected a statement, " + cursor_.found(token))
                     .with_label("no statement begins like this")
                     .with_help(help_for_no_statement(written)));
  // `from friction import tresca`: what follows on the line belongs to it.
  if (imports_something) {
    do cursor_.take();
    while (!cursor_.at(TokenKind::end) && !cursor_.peek().first_on_line);
  }
  throw Abandoned{};
}

} // namespace hvi::lang
