// Statements that declare something, except parts (parse_region.cpp). See parser_impl.hpp.
#include "lang/diag/suggest.hpp"
#include "lang/syntax/parser_impl.hpp"

#include <algorithm>
#include <array>

namespace hvi::lang {

// statement = import | units | param | mesh | part | tensor | kernel | superpotential | state | fn
// | space | find | report | expect | study ;
std::optional<ast::Statement> Parser::statement() {
  const auto read = [this]() -> ast::Statement {
    switch (peek().kind) {
    case TokenKind::import_:
      return import_statement();
    case TokenKind::units:
      return units();
    case TokenKind::param:
      return param();
    case TokenKind::mesh:
      return mesh();
    case TokenKind::part:
      return part();
    case TokenKind::tensor:
      return tensor();
    case TokenKind::kernel:
      return kernel();
    case TokenKind::superpotential:
      return superpotential();
    case TokenKind::state:
      return state();
    case TokenKind::fn:
      return fn();
    case TokenKind::space:
      return space();
    case TokenKind::find:
      return find();
    case TokenKind::report:
      return report_statement();
    case TokenKind::expect:
      return expect_statement();
    case TokenKind::study:
      return study();
    default:
      fail_no_statement();
    }
  };
  ast::Statement result = read();
  end_of_statement();
  return result;
}

void Parser::fail_no_statement() {
  const Token& token = peek();
  if (token.kind == TokenKind::semicolon) {
    fail(diagnose("E0217", token.span, "statements have no `;`").with_help("leave it out"));
  }
  if (token.kind != TokenKind::name) fail_on_known_slip();
  const std::string_view written = text(token);
  constexpr std::array<std::string_view, 5> imports{"include", "use", "using", "require", "from"};
  const bool imports_something =
      std::find(imports.begin(), imports.end(), written) != imports.end();
  names_lost_ = names_lost_ || imports_something || suggest(written, statement_words()) == "import";
  // Its name is not unknown to the lines below, whatever the statement was meant to be.
  if (peek(1).kind == TokenKind::name)
    declared_.push_back({std::string(text(peek(1))), peek(1).span});
  std::string help = did_you_mean(text(token), statement_words());
  if (help.empty()) {
    help = "statements begin with";
    for (const std::string_view word : statement_words())
      help.append(word == "import" ? " `" : ", `").append(word).append("`");
  }
  report(diagnose("E0202", token.span, "expected a statement, " + found(token))
             .with_label("no statement begins like this")
             .with_help(std::move(help)));
  // `from friction import tresca`: what follows on the line belongs to it.
  if (imports_something) {
    do take();
    while (!at(TokenKind::end) && !peek().first_on_line);
  }
  throw Abandoned{};
}

// What follows must be the next statement. A new line is left to statement(), which knows better.
void Parser::end_of_statement() {
  if (at(TokenKind::semicolon)) {
    report(diagnose("E0217", peek().span, "statements have no `;`").with_help("leave it out"));
    take();
  }
  if (at(TokenKind::end) || peek().first_on_line || begins_statement(at_)) return;
  if (at(TokenKind::equal))
    fail(diagnose("E0201", peek().span, "expected the end of the statement, found `=`"));
  fail_on_known_slip();
  const TokenKind next = peek().kind;
  if ((next == TokenKind::name && !at_clause_word()) || next == TokenKind::number ||
      next == TokenKind::open_paren)
    fail_operator_missing("the end of the statement");
  fail_expected("the end of the statement");
}

void Parser::fail_operator_missing(const std::string& otherwise) {
  fail(diagnose("E0224", peek().span,
                "an operator is missing before `" + std::string(text(peek())) + "`")
           .with_label("expected an operator or " + otherwise)
           .with_help("a product is written with `*`"));
}

ast::Name Parser::name(std::string_view what) {
  const bool reserved = is_reserved(peek().kind) && !begins_statement(at_);
  if (!at(TokenKind::name) && !reserved) fail_expected(what);
  const Token token = take();
  const std::string written(text(token));
  // The same word again is the same mistake.
  if (reserved && reserved_names_.insert(written).second)
    report(diagnose("E0203", token.span, "`" + written + "` is a reserved word, not a name")
               .with_help("choose another name, such as `" + written + "_1`"));
  return {written, token.span};
}

ast::Name Parser::declared_name(std::string_view what) {
  ast::Name result = name(what);
  declared_.push_back(result);
  return result;
}

// Any word may follow "." or stand before the "=" of an argument.
ast::Name Parser::member_name() {
  if (!at(TokenKind::name) && !is_reserved(peek().kind)) fail_expected("a name");
  const Token token = take();
  return {std::string(text(token)), token.span};
}

ast::Text Parser::string() {
  const Token token = expect(TokenKind::string, "a text in double quotes");
  std::string_view written = text(token);
  if (written.starts_with('"')) written.remove_prefix(1);
  if (written.ends_with('"')) written.remove_suffix(1);
  return {std::string(written), token.span};
}

std::optional<ast::Text> Parser::optional_string() {
  if (!at(TokenKind::string)) return std::nullopt;
  return string();
}

// import = "import" ( name | string ) ;
ast::Import Parser::import_statement() {
  ast::Import result;
  result.keyword = take().span;
  if (at(TokenKind::string))
    result.module = string();
  else
    result.module = declared_name("the name of a module or a file in quotes");
  result.span = span_from(result.keyword);
  return result;
}

// units = "units" unit { "," unit } ;
ast::Units Parser::units() {
  ast::Units result;
  result.keyword = take().span;
  do result.units.push_back(unit());
  while (accept(TokenKind::comma));
  result.span = span_from(result.keyword);
  return result;
}

// param = "param" name "=" expr [ "in" list ] [ string ] ;
ast::Param Parser::param() {
  ast::Param result;
  result.keyword = take().span;
  result.name = declared_name("the name of the parameter");
  expect(TokenKind::equal);
  result.value = expr();
  if (accept_word("in")) result.range = list();
  result.doc = optional_string();
  result.span = span_from(result.keyword);
  return result;
}

namespace {

bool is_sum_of_names(const ast::Expr& e) {
  const auto* sum = std::get_if<ast::Binary>(&e.node);
  if (sum == nullptr || sum->op != ast::BinaryOp::add || e.parens > 0) return false;
  const auto is_name = [](const ast::Expr& part) {
    return std::holds_alternative<ast::Reference>(part.node) && part.parens == 0;
  };
  return is_name(*sum->right) && (is_name(*sum->left) || is_sum_of_names(*sum->left));
}

} // namespace

// mesh = "mesh" name "=" ( call | name "+" name { "+" name } ) ;
ast::Mesh Parser::mesh() {
  ast::Mesh result;
  result.keyword = take().span;
  result.name = declared_name("the name of the mesh");
  expect(TokenKind::equal);
  if (!at(TokenKind::name)) fail_expected("a mesh such as `rectangle(2, 1, cells = [64, 32])`");
  result.value = sum();
  const bool call = std::holds_alternative<ast::Call>(result.value.node);
  if (!(call || is_sum_of_names(result.value)) || result.value.parens > 0)
    fail(diagnose("E0201", result.value.span, "expected a call that makes a mesh")
             .with_help("write `rectangle(...)`, `box(...)` or `gmsh(\"file.msh\")`; meshes are "
                        "put together by their names: `upper + lower`"));
  result.span = span_from(result.keyword);
  return result;
}

// tensor = "tensor" name "=" expr ;
ast::Tensor Parser::tensor() {
  ast::Tensor result;
  result.keyword = take().span;
  result.name = declared_name("the name of the tensor");
  expect(TokenKind::equal);
  result.value = expr();
  result.span = span_from(result.keyword);
  return result;
}

// kernel = "kernel" name "(" name [ "," name ] ")" "=" expr ;
ast::Kernel Parser::kernel() {
  ast::Kernel result;
  result.keyword = take().span;
  result.name = declared_name("the name of the kernel");
  const Token open = expect(TokenKind::open_paren, "`(lag)` or `(t, s)`");
  open_.push_back(open);
  do result.parameters.push_back(name("the argument of the kernel"));
  while (accept(TokenKind::comma));
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  if (result.parameters.size() > 2)
    fail(diagnose("E0227", result.parameters[2].span, "a kernel has one or two arguments")
             .with_help("`(lag)` for a kernel of t - s, `(t, s)` for any other"));
  expect(TokenKind::equal);
  result.value = expr();
  result.span = span_from(result.keyword);
  return result;
}

// superpotential = "superpotential" name "(" name { "," name [ "=" expr ] } ")" ( "=" expr | "with"
// "slope" expr ) ;
ast::Superpotential Parser::superpotential() {
  ast::Superpotential result;
  result.keyword = take().span;
  result.name = declared_name("the name of the superpotential");
  const Token open = expect(TokenKind::open_paren, "`(` and the argument of the superpotential");
  open_.push_back(open);
  result.argument = name("the argument of the superpotential");
  result.parameters = law_parameters();
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  if (accept_word("with")) {
    expect_word("slope");
    result.by_slope = true;
    // `with slope = ...` mixes the two forms.
    if (at(TokenKind::equal))
      fail(diagnose("E0201", peek().span, "`with slope` is followed by the slope, without `=`"));
  } else {
    expect(TokenKind::equal, "`=` and the potential, or `with slope` and its slope");
  }
  result.value = expr();
  result.span = span_from(result.keyword);
  return result;
}

std::vector<ast::LawParameter> Parser::law_parameters() {
  std::vector<ast::LawParameter> result;
  while (accept(TokenKind::comma)) {
    ast::LawParameter& parameter = result.emplace_back();
    parameter.name = name("the name of a parameter");
    if (accept(TokenKind::equal)) parameter.value = expr();
  }
  return result;
}

// state = "state" name "on" name "with" "rate" expr "from" name "=" expr [ "in" list ] ;
ast::State Parser::state() {
  ast::State result;
  result.keyword = take().span;
  result.name = declared_name("the name of the state");
  expect_word("on");
  result.part = name("the name of a part");
  expect_word("with");
  expect_word("rate");
  result.rate = expr();
  const Span first = expect_word("from").span;
  result.initial.unknown = name("the name of the state");
  expect(TokenKind::equal);
  result.initial.value = expr();
  result.initial.span = span_from(first);
  if (accept_word("in")) result.range = list();
  result.span = span_from(result.keyword);
  return result;
}

// fn = "fn" name "(" [ name { "," name } ] ")" "=" expr ;
ast::Fn Parser::fn() {
  ast::Fn result;
  result.keyword = take().span;
  result.name = declared_name("the name of the function");
  const Token open = expect(TokenKind::open_paren, "`(` and the arguments");
  open_.push_back(open);
  if (!at(TokenKind::close_paren)) {
    do result.parameters.push_back(name("the name of an argument"));
    while (accept(TokenKind::comma));
  }
  if (!at(TokenKind::close_paren)) fail_unclosed(open, TokenKind::close_paren);
  take();
  open_.pop_back();
  expect(TokenKind::equal);
  result.value = expr();
  result.span = span_from(result.keyword);
  return result;
}

// space = "space" name "=" ( "scalar" | "vector" ) name "on" name { "," ( "zero" [ "." name ] "on"
// name | "periodic" [ "." name ] name "=" name ) } ;
ast::Space Parser::space() {
  ast::Space result;
  result.keyword = take().span;
  result.name = declared_name("the name of the space");
  expect(TokenKind::equal);
  if (!at_word("scalar") && !at_word("vector")) fail_expected("`scalar` or `vector`");
  result.vector = at_word("vector");
  result.shape_word = take().span;
  const bool left_out = at_word("on") && !at_word("on", 1);
  if (left_out) fail_expected("the element (`P1`, `P2`)");
  result.element = name("the element (`P1`, `P2`)");
  expect_word("on");
  result.domain = name("the name of a mesh or part");
  while (accept(TokenKind::comma))
    if (at_word("periodic"))
      result.periodic.push_back(periodic_condition());
    else
      result.zero.push_back(zero_condition());
  result.span = span_from(result.keyword);
  return result;
}

ast::PeriodicCondition Parser::periodic_condition() {
  ast::PeriodicCondition result;
  const Span first = take().span;
  if (accept(TokenKind::dot)) result.component = member_name();
  result.first = name("the name of a part");
  expect(TokenKind::equal);
  result.second = name("the name of the part on the other side");
  result.span = span_from(first);
  return result;
}

ast::ZeroCondition Parser::zero_condition() {
  ast::ZeroCondition result;
  const Span first = expect_word("zero").span;
  if (accept(TokenKind::dot)) result.component = member_name();
  expect_word("on");
  result.part = name("the name of a part");
  result.span = span_from(first);
  return result;
}

} // namespace hvi::lang
