// What comes out: reports, expectations and studies. See report_parser.hpp.
#include "lang/diag/suggest.hpp"
#include "lang/syntax/report_parser.hpp"

#include <algorithm>
#include <string_view>

namespace hvi::lang {

// report = "report" report-item { report-item } ;
ast::Report ReportParser::report_statement() {
  ast::Report result;
  result.keyword = cursor_.take().span;
  do {
    try {
      result.items.push_back(report_item());
    } catch (const Abandoned&) {
      recover_in_report();
    }
  } while (at_report_item() || at_misspelt_item());
  if (cursor_.spoilt()) throw Abandoned{};
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// A wrong item does not hide the items on the lines below.
void ReportParser::recover_in_report() {
  cursor_.spoil();
  cursor_.forget_open();
  while (!cursor_.at(TokenKind::end) && !cursor_.at_statement()) {
    if (at_report_item() && cursor_.peek().first_on_line) return;
    cursor_.take();
  }
  throw Abandoned{};
}

bool ReportParser::at_report_item() const {
  return std::ranges::any_of(report_item_words, [&](auto word) { return cursor_.at_word(word); });
}

// No statement begins with a name that is none of its words: `pictur u` is an item.
bool ReportParser::at_misspelt_item() const {
  return cursor_.at(TokenKind::name) && cursor_.peek().first_on_line &&
         suggest(cursor_.text(cursor_.peek()), report_item_words).has_value();
}

// report-item = table-item | fields-item | picture-item | line-item | plot-item ;
ast::ReportItem ReportParser::report_item() {
  if (cursor_.at_word("table")) return table_item();
  if (cursor_.at_word("fields")) return fields_item();
  if (cursor_.at_word("picture")) return picture_item();
  if (cursor_.at_word("line")) return line_item();
  if (cursor_.at_word("plot")) return plot_item();
  cursor_.fail_expected("`table`, `fields`, `picture`, `line` or `plot`");
}

// rows-and-file = [ "every" expr "steps" ] [ "from" "start" ] [ "to" string ] ;
template <class Item>
void ReportParser::rows_and_file(Item& item) {
  item.every = every_steps();
  item.from_start = from_start();
  item.to = to_file();
  item.span = cursor_.span_from(item.keyword);
}

// table-item = "table" binding { "," binding } rows-and-file ;
ast::TableItem ReportParser::table_item() {
  ast::TableItem result;
  result.keyword = cursor_.take().span;
  do result.columns.push_back(binding());
  while (cursor_.accept(TokenKind::comma));
  rows_and_file(result);
  return result;
}

// fields-item = "fields" expr { "," expr } rows-and-file ;
ast::FieldsItem ReportParser::fields_item() {
  ast::FieldsItem result;
  result.keyword = cursor_.take().span;
  do result.fields.push_back(expressions_.expr());
  while (cursor_.accept(TokenKind::comma));
  rows_and_file(result);
  return result;
}

// picture-item = "picture" expr { "," expr } [ "deformed" "=" expr ] [ "at" "t" "=" expr ]
//                [ "to" string ] ;
ast::PictureItem ReportParser::picture_item() {
  ast::PictureItem result;
  result.keyword = cursor_.take().span;
  result.field = expressions_.expr();
  while (cursor_.accept(TokenKind::comma)) result.more.push_back(expressions_.expr());
  if (cursor_.accept_word("deformed")) {
    cursor_.expect(TokenKind::equal, "`=` and how many times the displacement is drawn");
    result.deformed = expressions_.expr();
  }
  result.time = optional_time();
  result.to = to_file();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// line-item = "line" expr { "," expr } "from" list "to" list "by" expr "points"
//             [ "at" "t" "=" expr ] [ "to" string ] ;
ast::LineItem ReportParser::line_item() {
  ast::LineItem result;
  result.keyword = cursor_.take().span;
  do result.fields.push_back(expressions_.expr());
  while (cursor_.accept(TokenKind::comma));
  cursor_.expect_word("from");
  result.from = expressions_.list();
  cursor_.expect_word("to");
  result.end = expressions_.list();
  cursor_.expect_word("by");
  result.points = expressions_.expr();
  cursor_.expect_word("points");
  result.time = optional_time();
  result.to = to_file();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// plot-item = "plot" name { "," name } "against" name [ "to" string ] ;
ast::PlotItem ReportParser::plot_item() {
  ast::PlotItem result;
  result.keyword = cursor_.take().span;
  do result.columns.push_back(names_.name("the name of a column"));
  while (cursor_.accept(TokenKind::comma));
  cursor_.expect_word("against");
  result.against = names_.name("the name of a column, or t");
  result.to = to_file();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// binding = name "=" expr [ "at" list [ "on" name ] ] [ "at" "t" "=" expr ] ;
ast::Binding ReportParser::binding() {
  ast::Binding result;
  result.name = names_.name("the name of a column");
  if (cursor_.at(TokenKind::dot)) { // table u.y
    cursor_.fail(
        diagnose("E0201", cursor_.peek().span,
                 "expected `=` and what the column shows, " + cursor_.found(cursor_.peek()))
            .with_label("expected `=`")
            .with_help("a column has a name, as in `height = u.y`"));
  }
  cursor_.expect(TokenKind::equal, "`=` and what the column shows");
  result.value = expressions_.expr();
  if (cursor_.at_word("at") && !at_time()) {
    cursor_.take();
    result.point = expressions_.list();
    if (cursor_.accept_word("on")) result.side = names_.name("the name of a part");
  }
  if (at_time()) result.time = time_value();
  result.span = cursor_.span_from(result.name.span);
  return result;
}

std::optional<ast::Expr> ReportParser::every_steps() {
  if (!cursor_.accept_word("every")) return std::nullopt;
  ast::Expr result = expressions_.expr();
  cursor_.expect_word("steps");
  return result;
}

// Of tables and fields: they have the initial state, too.
Span ReportParser::from_start() {
  if (!cursor_.at_word("from")) return {};
  const Span first = cursor_.take().span;
  cursor_.expect_word("start");
  return cursor_.span_from(first);
}

std::optional<ast::Text> ReportParser::to_file() {
  if (!cursor_.accept_word("to")) return std::nullopt;
  return names_.string();
}

// A picture has no `at [x, y]`: after `at` only a time can follow.
std::optional<ast::Expr> ReportParser::optional_time() {
  if (!cursor_.accept_word("at")) return std::nullopt;
  cursor_.expect_word("t");
  cursor_.expect(TokenKind::equal);
  return expressions_.expr();
}

bool ReportParser::at_time() const {
  return cursor_.at_word("at") && cursor_.at_word("t", 1) &&
         cursor_.peek(2).kind == TokenKind::equal;
}

ast::Expr ReportParser::time_value() {
  cursor_.take();
  cursor_.take();
  cursor_.take();
  return expressions_.expr();
}

// expect = "expect" name [ "at" "t" "=" expr ] "=" expr "within" expr [ "relative" ] [ "when"
// condition ] [ string ] ;
ast::Expect ReportParser::expect_statement() {
  ast::Expect result;
  result.keyword = cursor_.take().span;
  result.probe = names_.name("the name of a column of the report");
  if (at_time()) result.time = time_value();
  cursor_.expect(TokenKind::equal);
  result.value = expressions_.expr();
  cursor_.expect_word("within");
  result.tolerance = expressions_.expr();
  result.relative = cursor_.accept_word("relative");
  if (cursor_.accept_word("when")) result.when = expressions_.condition();
  result.source = names_.optional_string();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// study = "study" "vary" ladder { "and" ladder }
//         [ "against" ( "finest" | "richardson" | "exact" expr ) [ "in" name ] ] ;
ast::Study ReportParser::study() {
  ast::Study result;
  result.keyword = cursor_.take().span;
  cursor_.expect_word("vary");
  do result.ladders.push_back(ladder());
  while (cursor_.accept(TokenKind::and_));
  if (!cursor_.at_word("against")) {
    result.reference = ast::StudyReference::none;
    result.span = cursor_.span_from(result.keyword);
    return result;
  }
  result.against_word = cursor_.take().span;
  result.reference_word = cursor_.peek().span;
  if (cursor_.accept_word("richardson")) {
    result.reference = ast::StudyReference::richardson;
  } else if (cursor_.accept_word("exact")) {
    result.reference = ast::StudyReference::exact;
    result.exact = expressions_.expr();
  } else if (!cursor_.accept_word("finest")) {
    cursor_.fail_expected("`finest`, `richardson` or `exact` and a solution");
  }
  if (cursor_.accept_word("in")) result.norm = names_.name("the name of a norm");
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// ladder = name { "," name } "in" list ;
ast::Ladder ReportParser::ladder() {
  ast::Ladder result;
  result.parameter = names_.name("the name of a parameter");
  while (cursor_.accept(TokenKind::comma))
    result.more.push_back(names_.name("the name of a parameter"));
  cursor_.expect_word("in");
  result.values = expressions_.list();
  result.span = cursor_.span_from(result.parameter.span);
  return result;
}

} // namespace hvi::lang
