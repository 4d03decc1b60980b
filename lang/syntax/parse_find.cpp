// The statement that is the inequality. See parser_impl.hpp.
#include "lang/diag/suggest.hpp"
#include "lang/syntax/parser_impl.hpp"

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
ast::Find Parser::find() {
  ast::Find result;
  result.keyword = take().span;
  do {
    ast::Unknown& unknown = result.unknowns.emplace_back();
    unknown.unknown = declared_name("the name of the unknown");
    if (at(TokenKind::open_bracket)) unknown.unit = unit_in_brackets();
    expect_word("in");
    unknown.space = name("the name of a space");
  } while (accept(TokenKind::comma));
  find_clauses(result);
  such_that(result);
  expect_word("for");
  expect_word("all");
  test_functions(result);
  result.left = form();
  relation(result);
  result.right = form();
  if (at(TokenKind::colon) || is_comparison(peek().kind)) fail_expected("`+`, `-` or the end");
  if (spoilt_) throw Abandoned{};
  result.span = span_from(result.keyword);
  return result;
}

/// One for each unknown, in their order.
void Parser::test_functions(ast::Find& find) {
  const Span first = peek().span;
  std::size_t count = 0;
  do {
    const ast::Name test = declared_name("the name of the test function");
    expect_word("in");
    const ast::Name space = name("the name of a space");
    if (count < find.unknowns.size()) {
      find.unknowns[count].test = test;
      find.unknowns[count].test_space = space;
    }
    ++count;
  } while (accept(TokenKind::comma));
  if (count == find.unknowns.size()) return;
  spoilt_ = true;
  report(diagnose("E0443", span_from(first),
                  fmt::format("{} test function{} for {} unknown{}", count, count == 1 ? "" : "s",
                              find.unknowns.size(), find.unknowns.size() == 1 ? "" : "s"))
             .with_help("each unknown has its own, in the same order: `find u in V, p in Q ... "
                        "for all v in V, q in Q`"));
}

void Parser::find_clauses(ast::Find& find) {
  std::array<Span, clause_words.size()> seen{};
  int last = -1;
  for (;;) {
    int clause = -1;
    for (int i = 0; i < 3; ++i)
      if (at_word(clause_words[std::size_t(i)])) clause = i;
    // `for all` without `such that` is for such_that() to report.
    if (clause < 0 || (clause == 1 && at_word("all", 1))) return;
    if (clause <= last)
      fail(diagnose("E0219", peek().span,
                    clause == last ? "this clause stands twice"
                                   : "the clauses of `find` are in the wrong order")
               .with_secondary(seen[std::size_t(last)],
                               clause == last ? "first here" : "must stand behind")
               .with_help("the order is `with`, `for t`, `using`, `such that`"));
    last = clause;
    seen[std::size_t(clause)] = peek().span;
    find_clause(find, clause);
  }
}

void Parser::find_clause(ast::Find& find, int clause) {
  if (clause == 0) return imposed_values(find);
  if (clause == 1) {
    find.time = time_clause();
    return;
  }
  settings(find);
}

void Parser::such_that(ast::Find& find) {
  if (at_word("such")) {
    find.such_that = take().span;
    find.such_that = join(find.such_that, expect_word("that").span);
    return;
  }
  const bool left_out = (at_word("for") && at_word("all", 1)) || at_word("integral") ||
                        at(TokenKind::number) || at(TokenKind::minus) || at(TokenKind::end) ||
                        begins_statement(at_);
  if (left_out)
    fail(diagnose("E0215", missing_place(), "`such that` is missing")
             .with_label("expected `such that`")
             .with_help("write `find u in V ... such that for all v in V` and the inequality"));
  fail_on_known_slip();
  constexpr std::array<std::string_view, 4> words{"with", "for", "using", "such"};
  fail(
      diagnose("E0201", peek().span, "expected `such that` or a clause of `find`, " + found(peek()))
          .with_label("expected `with`, `for`, `using` or `such that`")
          .with_help(did_you_mean(text(peek()), words)));
}

void Parser::imposed_values(ast::Find& find) {
  find.with_word = take().span;
  do find.imposed.push_back(imposed_value());
  while (accept(TokenKind::comma));
}

// value = name [ "." name ] "=" expr "on" name ;
ast::ImposedValue Parser::imposed_value() {
  ast::ImposedValue result;
  const Span first = peek().span;
  result.unknown = name("the unknown");
  if (accept(TokenKind::dot)) result.component = member_name();
  expect(TokenKind::equal);
  result.value = expr();
  expect_word("on");
  result.part = name("the name of a part");
  result.span = span_from(first);
  return result;
}

ast::TimeClause Parser::time_clause() {
  ast::TimeClause result;
  const Span first = take().span;
  if (at(TokenKind::name) && !at_word("t") && at_word("in", 1))
    fail(diagnose("E0201", peek().span, "expected `t`, " + found(peek()))
             .with_label("the time is always called `t`"));
  expect_word("t");
  expect_word("in");
  result.range = list();
  if (accept_word("by")) {
    result.steps = expr();
    expect_word("steps");
  } else if (accept_word("at")) {
    result.by_steps = false;
    result.steps = expr();
  } else {
    fail_expected("`by N steps` or `at [times]`");
  }
  if (at_word("from")) {
    Span from = take().span; // a part of the first one
    do {
      result.initial.push_back(initial_value(result.initial.empty() ? from : peek().span));
    } while (accept(TokenKind::comma));
  }
  result.span = span_from(first);
  return result;
}

ast::InitialValue Parser::initial_value(const Span& first) {
  ast::InitialValue result;
  result.unknown = name("the unknown");
  result.rate = accept(TokenKind::prime);
  expect(TokenKind::equal);
  result.value = expr();
  result.span = span_from(first);
  return result;
}

void Parser::settings(ast::Find& find) {
  find.using_word = take().span;
  do {
    ast::Setting& setting = find.settings.emplace_back();
    setting.name = name("the name of a setting");
    expect(TokenKind::equal);
    setting.value = expr();
    setting.span = span_from(setting.name.span);
  } while (accept(TokenKind::comma));
}

void Parser::relation(ast::Find& find) {
  const Token sign = peek();
  find.relation = sign.span;
  if (accept(TokenKind::greater_equal)) return;
  find.inequality = false;
  const bool reversed_arrow = at(TokenKind::equal) && peek(1).kind == TokenKind::greater;
  if (!reversed_arrow && accept(TokenKind::equal)) return;
  const bool comparison = is_comparison(sign.kind) && sign.kind != TokenKind::not_equal;
  if (!comparison && !reversed_arrow) {
    if (at(TokenKind::colon))
      fail(diagnose("E0223", peek().span, "a term of the inequality is not an integral")
               .with_help("write `integral(part, ...)` around it"));
    fail_expected("`>=` or `=` and the right-hand side");
  }
  take();
  if (reversed_arrow) take();
  find.relation = span_from(sign.span);
  const std::string right = sign.kind == TokenKind::equal_equal ? "=" : ">=";
  find.inequality = true; // no second error on the same sign
  report(diagnose("E0213", find.relation,
                  "`" + std::string(source_.text(find.relation)) + "` between the two sides")
             .with_label("write `" + right + "`")
             .with_help("an inequality has `>=`, an equation `=`; for `<=` change the sign of "
                        "both sides"));
}

// form = [ "-" ] form-term { ( "+" | "-" ) form-term } ;
ast::Form Parser::form() {
  ast::Form result;
  const Span first = peek().span;
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
  const bool minus = at(TokenKind::minus);
  signed_term(minus, minus ? take().span : Span{});
  while (at(TokenKind::plus) || at(TokenKind::minus)) {
    const Token sign = take();
    signed_term(sign.kind == TokenKind::minus, sign.span);
  }
  result.span = span_from(first);
  return result;
}

// A wrong term hides neither the next term nor the other side.
void Parser::recover_in_form() {
  spoilt_ = true;
  in_integral_ = false;
  open_.clear();
  for (; !at(TokenKind::end) && !begins_statement(at_); take()) {
    const bool sign = at(TokenKind::plus) || at(TokenKind::minus);
    if (sign && at_word("integral", 1)) return;
    if (is_comparison(peek().kind) && peek().first_on_line) return;
    if (at(TokenKind::greater_equal) || (at(TokenKind::equal) && at_word("integral", 1))) return;
  }
  throw Abandoned{};
}

// form-term = { factor "*" } "integral" "(" name "," expr { "," name "=" expr } ")" | "0" ;
ast::FormTerm Parser::form_term() {
  ast::FormTerm result;
  const Span first = peek().span;
  const auto at_integral = [this] {
    return at_word("integral") && peek(1).kind == TokenKind::open_paren;
  };
  while (!at_integral()) {
    if (at_word("integral")) {
      take();
      fail_expected("`(` and the part to integrate over");
    }
    result.factors.push_back(factor());
    if (accept(TokenKind::star)) continue;
    if (at_integral() && !peek().first_on_line) fail_expected("`*` before the integral");
    const ast::Expr& only = result.factors.front();
    const auto* number = std::get_if<ast::Number>(&only.node);
    const bool zero = result.factors.size() == 1 && number != nullptr && number->value == 0;
    if (zero && !at(TokenKind::slash) && !at(TokenKind::colon)) {
      result.factors.clear();
      result.span = span_from(first);
      return result;
    }
    if (at(TokenKind::slash))
      fail(diagnose("E0222", peek().span, "a quotient before an integral needs parentheses")
               .with_help("write `(a/b) * integral(...)`"));
    fail_no_integral(span_from(first));
  }
  result.integral = integral();
  check_after_integral();
  result.span = span_from(first);
  return result;
}

void Parser::fail_no_integral(const Span& term) {
  if (at_decimal_comma()) fail_decimal_comma();
  fail(diagnose("E0223", term, "a term of the inequality is not an integral")
           .with_label("expected `integral(part, ...)`, maybe with constants and `*` before it")
           .with_help("every term is an integral over a part, or 0"));
}

ast::Integral Parser::integral() {
  ast::Integral result;
  result.word = take().span;
  const Level level(*this);
  const Token open = take();
  open_.push_back(open);
  result.domain = name("the part to integrate over");
  if (!at(TokenKind::comma)) {
    fail(diagnose("E0201", missing_place(), "expected `,` and the integrand, " + found(peek()))
             .with_label("expected `,`")
             .with_help("an integral is written `integral(part, integrand)`"));
  }
  take();
  in_integral_ = true;
  result.integrand = expr();
  in_integral_ = false;
  while (accept(TokenKind::comma)) {
    if (at(TokenKind::name) && peek(1).kind != TokenKind::equal && !peek(1).first_on_line &&
        peek(1).kind != TokenKind::close_paren)
      fail_expected("an option such as `rule = gauss`");
    ast::Setting& option = result.options.emplace_back();
    option.name = name("an option such as `rule = gauss`");
    expect(TokenKind::equal);
    option.value = expr();
    option.span = span_from(option.name.span);
  }
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  result.span = span_from(result.word);
  return result;
}

void Parser::check_after_integral() {
  if (!at(TokenKind::star) && !at(TokenKind::slash) && !at(TokenKind::caret)) return;
  fail(diagnose("E0222", peek().span, "factors stand before their integral")
           .with_help("write `2 * integral(...)` or `(1/2) * integral(...)`"));
}

// factor = postfix [ "^" unary ] ;
ast::Expr Parser::factor() {
  if (at(TokenKind::end) || begins_statement(at_)) fail_expected("an integral");
  return power();
}

} // namespace hvi::lang
