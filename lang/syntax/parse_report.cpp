// What comes out: reports, expectations and studies. See parser_impl.hpp.
#include "lang/syntax/parser_impl.hpp"

namespace hvi::lang {

// report = "report" report-item { report-item } ;
ast::Report Parser::report_statement() {
  ast::Report result;
  result.keyword = take().span;
  do {
    try {
      result.items.push_back(report_item());
    } catch (const Abandoned&) {
      recover_in_report();
    }
  } while (at_report_item());
  if (spoilt_) throw Abandoned{};
  result.span = span_from(result.keyword);
  return result;
}

// A wrong item does not hide the items on the lines below.
void Parser::recover_in_report() {
  spoilt_ = true;
  open_.clear();
  while (!at(TokenKind::end) && !begins_statement(at_)) {
    if (at_report_item() && peek().first_on_line) return;
    take();
  }
  throw Abandoned{};
}

bool Parser::at_report_item() const {
  return at_word("table") || at_word("fields") || at_word("picture") || at_word("line") ||
         at_word("plot");
}

// report-item = "table" binding { "," binding } [ "every" expr "steps" ] [ "from" "start" ]
//               [ "to" string ]
//             | "fields" expr { "," expr } [ "every" expr "steps" ] [ "from" "start" ] [ "to"
//             string ] | "picture" expr { "," expr } [ "deformed" "=" expr ] [ "at" "t" "=" expr ]
//               [ "to" string ]
//             | "line" expr { "," expr } "from" list "to" list "by" expr "points"
//               [ "at" "t" "=" expr ] [ "to" string ]
//             | "plot" name { "," name } "against" name [ "to" string ] ;
ast::ReportItem Parser::report_item() {
  if (at_word("table")) return table_item();
  if (at_word("fields")) return fields_item();
  if (at_word("picture")) return picture_item();
  if (at_word("line")) return line_item();
  if (at_word("plot")) return plot_item();
  fail_expected("`table`, `fields`, `picture`, `line` or `plot`");
}

ast::TableItem Parser::table_item() {
  ast::TableItem result;
  result.keyword = take().span;
  do result.columns.push_back(binding());
  while (accept(TokenKind::comma));
  result.every = every_steps();
  result.from_start = from_start();
  result.to = to_file();
  result.span = span_from(result.keyword);
  return result;
}

ast::FieldsItem Parser::fields_item() {
  ast::FieldsItem result;
  result.keyword = take().span;
  do result.fields.push_back(expr());
  while (accept(TokenKind::comma));
  result.every = every_steps();
  result.from_start = from_start();
  result.to = to_file();
  result.span = span_from(result.keyword);
  return result;
}

ast::PictureItem Parser::picture_item() {
  ast::PictureItem result;
  result.keyword = take().span;
  result.field = expr();
  while (accept(TokenKind::comma)) result.more.push_back(expr());
  if (accept_word("deformed")) {
    expect(TokenKind::equal, "`=` and how many times the displacement is drawn");
    result.deformed = expr();
  }
  result.time = optional_time();
  result.to = to_file();
  result.span = span_from(result.keyword);
  return result;
}

ast::LineItem Parser::line_item() {
  ast::LineItem result;
  result.keyword = take().span;
  do result.fields.push_back(expr());
  while (accept(TokenKind::comma));
  expect_word("from");
  result.from = list();
  expect_word("to");
  result.end = list();
  expect_word("by");
  result.points = expr();
  expect_word("points");
  result.time = optional_time();
  result.to = to_file();
  result.span = span_from(result.keyword);
  return result;
}

ast::PlotItem Parser::plot_item() {
  ast::PlotItem result;
  result.keyword = take().span;
  do result.columns.push_back(name("the name of a column"));
  while (accept(TokenKind::comma));
  expect_word("against");
  result.against = name("the name of a column, or t");
  result.to = to_file();
  result.span = span_from(result.keyword);
  return result;
}

// binding = name "=" expr [ "at" list ] [ "at" "t" "=" expr ] ;
ast::Binding Parser::binding() {
  ast::Binding result;
  result.name = name("the name of a column");
  expect(TokenKind::equal, "`=` and what the column shows");
  result.value = expr();
  if (at_word("at") && !at_time()) {
    take();
    result.point = list();
  }
  if (at_time()) result.time = time_value();
  result.span = span_from(result.name.span);
  return result;
}

std::optional<ast::Expr> Parser::every_steps() {
  if (!accept_word("every")) return std::nullopt;
  ast::Expr result = expr();
  expect_word("steps");
  return result;
}

// Of tables and fields: they have the initial state, too.
Span Parser::from_start() {
  if (!at_word("from")) return {};
  const Span first = take().span;
  expect_word("start");
  return span_from(first);
}

std::optional<ast::Text> Parser::to_file() {
  if (!accept_word("to")) return std::nullopt;
  return string();
}

// A picture has no `at [x, y]`: after `at` only a time can follow.
std::optional<ast::Expr> Parser::optional_time() {
  if (!accept_word("at")) return std::nullopt;
  expect_word("t");
  expect(TokenKind::equal);
  return expr();
}

bool Parser::at_time() const {
  return at_word("at") && at_word("t", 1) && peek(2).kind == TokenKind::equal;
}

ast::Expr Parser::time_value() {
  take();
  take();
  take();
  return expr();
}

// expect = "expect" name [ "at" "t" "=" expr ] "=" expr "within" expr [ "relative" ] [ "when"
// condition ] [ string ] ;
ast::Expect Parser::expect_statement() {
  ast::Expect result;
  result.keyword = take().span;
  result.probe = name("the name of a column of the report");
  if (at_time()) result.time = time_value();
  expect(TokenKind::equal);
  result.value = expr();
  expect_word("within");
  result.tolerance = expr();
  result.relative = accept_word("relative");
  if (accept_word("when")) result.when = condition();
  result.source = optional_string();
  result.span = span_from(result.keyword);
  return result;
}

// study = "study" "vary" ladder { "and" ladder }
//         [ "against" ( "finest" | "richardson" | "exact" expr ) [ "in" name ] ] ;
ast::Study Parser::study() {
  ast::Study result;
  result.keyword = take().span;
  expect_word("vary");
  do result.ladders.push_back(ladder());
  while (accept(TokenKind::and_));
  if (!at_word("against")) {
    result.reference = ast::StudyReference::none;
    result.span = span_from(result.keyword);
    return result;
  }
  result.against_word = take().span;
  result.reference_word = peek().span;
  if (accept_word("richardson")) {
    result.reference = ast::StudyReference::richardson;
  } else if (accept_word("exact")) {
    result.reference = ast::StudyReference::exact;
    result.exact = expr();
  } else if (!accept_word("finest")) {
    fail_expected("`finest`, `richardson` or `exact` and a solution");
  }
  if (accept_word("in")) result.norm = name("the name of a norm");
  result.span = span_from(result.keyword);
  return result;
}

// ladder = name { "," name } "in" list ;
ast::Ladder Parser::ladder() {
  ast::Ladder result;
  result.parameter = name("the name of a parameter");
  while (accept(TokenKind::comma)) result.more.push_back(name("the name of a parameter"));
  expect_word("in");
  result.values = list();
  result.span = span_from(result.parameter.span);
  return result;
}

} // namespace hvi::lang
