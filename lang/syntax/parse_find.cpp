// The statement that is the inequality. See find_parser.hpp.
#include "lang/diag/suggest.hpp"
#include "lang/syntax/find_parser.hpp"

#include <fmt/format.h>

#include <array>

namespace hvi::lang {
namespace {

// In the order in which they stand.
constexpr std::array<std::string_view, 3> clause_words{"with", "for", "using"};

} // namespace

// find = "find" name "in" name { "," name "in" name }
//        [ "with" value { "," value } ]
//        [ "for" "t" "in" list ( "by" expr "steps" | "at" expr )
//          [ "from" name [ "'" ] "=" expr { "," name [ "'" ] "=" expr } ] ]
//        [ "using" name "=" expr { "," name "=" expr } ]
//        "such" "that" "for" "all" name "in" name { "," name "in" name }
//        form ( ">=" | "=" ) form ;
ast::Find FindParser::find() {
  ast::Find result;
  result.keyword = cursor_.take().span;
  do {
    ast::Unknown& unknown = result.unknowns.emplace_back();
    unknown.unknown = names_.declared_name("the name of the unknown");
    if (cursor_.at(TokenKind::open_bracket)) unknown.unit = expressions_.unit_in_brackets();
    cursor_.expect_word("in");
    unknown.space = names_.name("the name of a space");
  } while (cursor_.accept(TokenKind::comma));
  find_clauses(result);
  such_that(result);
  cursor_.expect_word("for");
  cursor_.expect_word("all");
  test_functions(result);
  result.left = form();
  relation(result);
  result.right = form();
  if (cursor_.at(TokenKind::colon) || is_comparison(cursor_.peek().kind))
    cursor_.fail_expected("`+`, `-` or the end");
  if (cursor_.spoilt()) throw Abandoned{};
  result.span = cursor_.span_from(result.keyword);
  return result;
}

/// One for each unknown, in their order.
void FindParser::test_functions(ast::Find& find) {
  const Span first = cursor_.peek().span;
  std::size_t count = 0;
  do {
    const ast::Name test = names_.declared_name("the name of the test function");
    cursor_.expect_word("in");
    const ast::Name space = names_.name("the name of a space");
    if (count < find.unknowns.size()) {
      find.unknowns[count].test = test;
      find.unknowns[count].test_space = space;
    }
    ++count;
  } while (cursor_.accept(TokenKind::comma));
  if (count == find.unknowns.size()) return;
  cursor_.spoil();
  cursor_.report(
      diagnose("E0443", cursor_.span_from(first),
               fmt::format("{} test function{} for {} unknown{}", count, count == 1 ? "" : "s",
                           find.unknowns.size(), find.unknowns.size() == 1 ? "" : "s"))
          .with_help("each unknown has its own, in the same order: `find u in V, p in Q ... "
                     "for all v in V, q in Q`"));
}

void FindParser::find_clauses(ast::Find& find) {
  std::array<Span, clause_words.size()> seen{};
  int last = -1;
  for (;;) {
    int clause = -1;
    for (int i = 0; i < 3; ++i)
      if (cursor_.at_word(clause_words[std::size_t(i)])) clause = i;
    // `for all` without `such that` is for such_that() to report.
    if (clause < 0 || (clause == 1 && cursor_.at_word("all", 1))) return;
    if (clause <= last)
      cursor_.fail(diagnose("E0219", cursor_.peek().span,
                            clause == last ? "this clause stands twice"
                                           : "the clauses of `find` are in the wrong order")
                       .with_secondary(seen[std::size_t(last)],
                                       clause == last ? "first here" : "must stand behind")
                       .with_help("the order is `with`, `for t`, `using`, `such that`"));
    last = clause;
    seen[std::size_t(clause)] = cursor_.peek().span;
    find_clause(find, clause);
  }
}

void FindParser::find_clause(ast::Find& find, int clause) {
  if (clause == 0) return imposed_values(find);
  if (clause == 1) {
    find.time = time_clause();
    return;
  }
  settings(find);
}

void FindParser::such_that(ast::Find& find) {
  if (cursor_.at_word("such")) {
    find.such_that = cursor_.take().span;
    find.such_that = join(find.such_that, cursor_.expect_word("that").span);
    return;
  }
  const bool left_out = (cursor_.at_word("for") && cursor_.at_word("all", 1)) ||
                        cursor_.at_word("integral") || cursor_.at(TokenKind::number) ||
                        cursor_.at(TokenKind::minus) || cursor_.at(TokenKind::end) ||
                        cursor_.at_statement();
  if (left_out)
    cursor_.fail(
        diagnose("E0215", cursor_.missing_place(), "`such that` is missing")
            .with_label("expected `such that`")
            .with_help("write `find u in V ... such that for all v in V` and the inequality"));
  cursor_.fail_on_known_slip();
  constexpr std::array<std::string_view, 4> words{"with", "for", "using", "such"};
  cursor_.fail(
      diagnose("E0201", cursor_.peek().span,
               "expected `such that` or a clause of `find`, " + cursor_.found(cursor_.peek()))
          .with_label("expected `with`, `for`, `using` or `such that`")
          .with_help(did_you_mean(cursor_.text(cursor_.peek()), words)));
}

void FindParser::imposed_values(ast::Find& find) {
  find.with_word = cursor_.take().span;
  do find.imposed.push_back(imposed_value());
  while (cursor_.accept(TokenKind::comma));
}

// value = name [ "." name ] "=" expr "on" name ;
ast::ImposedValue FindParser::imposed_value() {
  ast::ImposedValue result;
  const Span first = cursor_.peek().span;
  result.unknown = names_.name("the unknown");
  if (cursor_.accept(TokenKind::dot)) result.component = names_.member_name();
  cursor_.expect(TokenKind::equal);
  result.value = expressions_.expr();
  cursor_.expect_word("on");
  result.part = names_.name("the name of a part");
  result.span = cursor_.span_from(first);
  return result;
}

ast::TimeClause FindParser::time_clause() {
  ast::TimeClause result;
  const Span first = cursor_.take().span;
  if (cursor_.at(TokenKind::name) && !cursor_.at_word("t") && cursor_.at_word("in", 1))
    cursor_.fail(
        diagnose("E0201", cursor_.peek().span, "expected `t`, " + cursor_.found(cursor_.peek()))
            .with_label("the time is always called `t`"));
  cursor_.expect_word("t");
  cursor_.expect_word("in");
  result.range = expressions_.list();
  if (cursor_.accept_word("by")) {
    result.steps = expressions_.expr();
    cursor_.expect_word("steps");
  } else if (cursor_.accept_word("at")) {
    result.by_steps = false;
    result.steps = expressions_.expr();
  } else {
    cursor_.fail_expected("`by N steps` or `at [times]`");
  }
  if (cursor_.at_word("from")) {
    Span from = cursor_.take().span; // a part of the first one
    do {
      result.initial.push_back(
          declarations_.initial_value(result.initial.empty() ? from : cursor_.peek().span));
    } while (cursor_.accept(TokenKind::comma));
  }
  result.span = cursor_.span_from(first);
  return result;
}

ast::InitialValue DeclarationParser::initial_value(const Span& first) {
  ast::InitialValue result;
  result.unknown = names_.name("the unknown");
  result.rate = cursor_.accept(TokenKind::prime);
  if (result.rate && cursor_.at(TokenKind::prime))
    cursor_.fail(diagnose("E0201", cursor_.peek().span, "expected `=`, found another `'`")
                     .with_label("expected `=`")
                     .with_help("values and rates are given; the acceleration at the initial time "
                                "follows from the inequality"));
  cursor_.expect(TokenKind::equal);
  result.value = expressions_.expr();
  result.span = cursor_.span_from(first);
  return result;
}

void FindParser::settings(ast::Find& find) {
  find.using_word = cursor_.take().span;
  do {
    ast::Setting& setting = find.settings.emplace_back();
    setting.name = names_.name("the name of a setting");
    cursor_.expect(TokenKind::equal);
    setting.value = expressions_.expr();
    setting.span = cursor_.span_from(setting.name.span);
  } while (cursor_.accept(TokenKind::comma));
}

void FindParser::relation(ast::Find& find) {
  const Token sign = cursor_.peek();
  find.relation = sign.span;
  if (cursor_.accept(TokenKind::greater_equal)) return;
  find.inequality = false;
  const bool reversed_arrow =
      cursor_.at(TokenKind::equal) && cursor_.peek(1).kind == TokenKind::greater;
  if (!reversed_arrow && cursor_.accept(TokenKind::equal)) return;
  const bool comparison = is_comparison(sign.kind) && sign.kind != TokenKind::not_equal;
  if (!comparison && !reversed_arrow) {
    if (cursor_.at(TokenKind::colon))
      cursor_.fail(
          diagnose("E0223", cursor_.peek().span, "a term of the inequality is not an integral")
              .with_help("write `integral(part, ...)` around it"));
    cursor_.fail_expected("`>=` or `=` and the right-hand side");
  }
  cursor_.take();
  if (reversed_arrow) cursor_.take();
  find.relation = cursor_.span_from(sign.span);
  const std::string right = sign.kind == TokenKind::equal_equal ? "=" : ">=";
  find.inequality = true; // no second error on the same sign
  cursor_.report(
      diagnose("E0213", find.relation,
               "`" + std::string(cursor_.text(find.relation)) + "` between the two sides")
          .with_label("write `" + right + "`")
          .with_help("an inequality has `>=`, an equation `=`; for `<=` change the sign of "
                     "both sides"));
}

// form = [ "-" ] form-term { ( "+" | "-" ) form-term } ;
ast::Form FindParser::form() {
  ast::Form result;
  const Span first = cursor_.peek().span;
  const auto signed_term = [&](bool minus, const Span& sign) {
    try {
      ast::FormTerm term = form_term();
      term.minus = minus;
      term.sign = sign;
      result.terms.push_back(std::move(term));
    } catch (const Abandoned&) {
      recover_in_form();
    }
  };
  const bool minus = cursor_.at(TokenKind::minus);
  signed_term(minus, minus ? cursor_.take().span : Span{});
  while (cursor_.at(TokenKind::plus) || cursor_.at(TokenKind::minus)) {
    const Token sign = cursor_.take();
    signed_term(sign.kind == TokenKind::minus, sign.span);
  }
  result.span = cursor_.span_from(first);
  return result;
}

// A wrong term hides neither the next term nor the other side.
void FindParser::recover_in_form() {
  cursor_.spoil();
  expressions_.in_integral = false;
  cursor_.forget_open();
  for (; !cursor_.at(TokenKind::end) && !cursor_.at_statement(); cursor_.take()) {
    const bool sign = cursor_.at(TokenKind::plus) || cursor_.at(TokenKind::minus);
    if (sign && cursor_.at_word("integral", 1)) return;
    if (is_comparison(cursor_.peek().kind) && cursor_.peek().first_on_line) return;
    if (cursor_.at(TokenKind::greater_equal) ||
        (cursor_.at(TokenKind::equal) && cursor_.at_word("integral", 1)))
      return;
  }
  throw Abandoned{};
}

// form-term = { factor "*" } "integral" "(" name "," expr { "," name "=" expr } ")" | "0" ;
ast::FormTerm FindParser::form_term() {
  ast::FormTerm result;
  const Span first = cursor_.peek().span;
  const auto at_integral = [this] {
    return cursor_.at_word("integral") && cursor_.peek(1).kind == TokenKind::open_paren;
  };
  while (!at_integral()) {
    if (cursor_.at_word("integral")) {
      cursor_.take();
      cursor_.fail_expected("`(` and the part to integrate over");
    }
    result.factors.push_back(factor());
    if (cursor_.accept(TokenKind::star)) continue;
    if (at_integral() && !cursor_.peek().first_on_line)
      cursor_.fail_expected("`*` before the integral");
    const ast::Expr& only = result.factors.front();
    const auto* number = std::get_if<ast::Number>(&only.node);
    const bool zero = result.factors.size() == 1 && number != nullptr && number->value == 0;
    if (zero && !cursor_.at(TokenKind::slash) && !cursor_.at(TokenKind::colon)) {
      result.factors.clear();
      result.span = cursor_.span_from(first);
      return result;
    }
    if (cursor_.at(TokenKind::slash))
      cursor_.fail(
          diagnose("E0222", cursor_.peek().span, "a quotient before an integral needs parentheses")
              .with_help("write `(a/b) * integral(...)`"));
    fail_no_integral(cursor_.span_from(first));
  }
  result.integral = integral();
  check_after_integral();
  result.span = cursor_.span_from(first);
  return result;
}

void FindParser::fail_no_integral(const Span& term) {
  if (cursor_.at_decimal_comma()) cursor_.fail_decimal_comma();
  cursor_.fail(
      diagnose("E0223", term, "a term of the inequality is not an integral")
          .with_label("expected `integral(part, ...)`, maybe with constants and `*` before it")
          .with_help("every term is an integral over a part, or 0"));
}

void FindParser::fail_no_integrand() {
  const bool side = cursor_.at(TokenKind::dot); // integral(body.top, ...)
  cursor_.fail(diagnose("E0201", cursor_.missing_place(),
                        "expected `,` and the integrand, " + cursor_.found(cursor_.peek()))
                   .with_label("expected `,`")
                   .with_help(side ? "name the part first, as in `part roof = body.top`"
                                   : "an integral is written `integral(part, integrand)`"));
}

ast::Integral FindParser::integral() {
  ast::Integral result;
  result.word = cursor_.take().span;
  const Cursor::Level level(cursor_);
  const Token open = cursor_.take();
  cursor_.opened(open);
  result.domain = names_.name("the part to integrate over");
  if (!cursor_.at(TokenKind::comma)) fail_no_integrand();
  cursor_.take();
  expressions_.in_integral = true;
  result.integrand = expressions_.expr();
  expressions_.in_integral = false;
  while (cursor_.accept(TokenKind::comma)) {
    if (cursor_.at(TokenKind::name) && cursor_.peek(1).kind != TokenKind::equal &&
        !cursor_.peek(1).first_on_line && cursor_.peek(1).kind != TokenKind::close_paren)
      cursor_.fail_expected("an option such as `rule = gauss`");
    ast::Setting& option = result.options.emplace_back();
    option.name = names_.name("an option such as `rule = gauss`");
    cursor_.expect(TokenKind::equal);
    option.value = expressions_.expr();
    option.span = cursor_.span_from(option.name.span);
  }
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  cursor_.closed();
  result.span = cursor_.span_from(result.word);
  return result;
}

void FindParser::check_after_integral() {
  if (!cursor_.at(TokenKind::star) && !cursor_.at(TokenKind::slash) &&
      !cursor_.at(TokenKind::caret))
    return;
  cursor_.fail(diagnose("E0222", cursor_.peek().span, "factors stand before their integral")
                   .with_help("write `2 * integral(...)` or `(1/2) * integral(...)`"));
}

// factor = postfix [ "^" unary ] ;
ast::Expr FindParser::factor() {
  if (cursor_.at(TokenKind::end) || cursor_.at_statement()) cursor_.fail_expected("an integral");
  return expressions_.power();
}

} // namespace hvi::lang
