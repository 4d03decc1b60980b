// Statements that declare something, except parts (parse_region.cpp). See declaration_parser.hpp.
#include "lang/syntax/declaration_parser.hpp"

namespace hvi::lang {

// import = "import" ( name | string ) ;
ast::Import DeclarationParser::import_statement() {
  ast::Import result;
  result.keyword = cursor_.take().span;
  if (cursor_.at(TokenKind::string))
    result.module = names_.string();
  else
    result.module = names_.declared_name("the name of a module or a file in quotes");
  const bool dot = cursor_.at(TokenKind::dot), comma = cursor_.at(TokenKind::comma);
  if ((dot || comma) && !cursor_.peek().first_on_line)
    cursor_.fail(diagnose("E0201", cursor_.peek().span,
                          "expected the end of the statement, " + cursor_.found(cursor_.peek()))
                     .with_label("expected the end of the statement")
                     .with_help(dot ? "the name of a file stands in quotes"
                                    : "each module has its own `import`"));
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// units = "units" unit { "," unit } ;
ast::Units DeclarationParser::units() {
  ast::Units result;
  result.keyword = cursor_.take().span;
  do result.units.push_back(expressions_.unit());
  while (cursor_.accept(TokenKind::comma));
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// param = "param" name "=" expr [ "in" list ] [ string ] ;
ast::Param DeclarationParser::param() {
  ast::Param result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the parameter");
  cursor_.expect(TokenKind::equal);
  result.value = expressions_.expr();
  if (cursor_.accept_word("in")) result.range = expressions_.list();
  result.doc = names_.optional_string();
  result.span = cursor_.span_from(result.keyword);
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
ast::Mesh DeclarationParser::mesh() {
  ast::Mesh result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the mesh");
  cursor_.expect(TokenKind::equal);
  if (!cursor_.at(TokenKind::name))
    cursor_.fail_expected("a mesh such as `rectangle(2, 1, cells = [64, 32])`");
  result.value = expressions_.sum();
  const bool call = std::holds_alternative<ast::Call>(result.value.node);
  if (!(call || is_sum_of_names(result.value)) || result.value.parens > 0)
    cursor_.fail(
        diagnose("E0201", result.value.span, "expected a call that makes a mesh")
            .with_help("write `rectangle(...)`, `box(...)` or `gmsh(\"file.msh\")`; meshes are "
                       "put together by their names: `upper + lower`"));
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// tensor = "tensor" name "=" expr ;
ast::Tensor DeclarationParser::tensor() {
  ast::Tensor result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the tensor");
  cursor_.expect(TokenKind::equal);
  result.value = expressions_.expr();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// kernel = "kernel" name "(" name [ "," name ] ")" "=" expr ;
ast::Kernel DeclarationParser::kernel() {
  ast::Kernel result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the kernel");
  const Token open = cursor_.expect(TokenKind::open_paren, "`(lag)` or `(t, s)`");
  cursor_.opened(open);
  do result.parameters.push_back(names_.name("the argument of the kernel"));
  while (cursor_.accept(TokenKind::comma));
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  cursor_.closed();
  if (result.parameters.size() > 2)
    cursor_.fail(diagnose("E0227", result.parameters[2].span, "a kernel has one or two arguments")
                     .with_help("`(lag)` for a kernel of t - s, `(t, s)` for any other"));
  cursor_.expect(TokenKind::equal);
  result.value = expressions_.expr();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// superpotential = "superpotential" name "(" name { "," name [ "=" expr ] } ")" ( "=" expr | "with"
// "slope" expr ) ;
ast::Superpotential DeclarationParser::superpotential() {
  ast::Superpotential result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the superpotential");
  const Token open =
      cursor_.expect(TokenKind::open_paren, "`(` and the argument of the superpotential");
  cursor_.opened(open);
  result.argument = names_.name("the argument of the superpotential");
  result.parameters = law_parameters();
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  cursor_.closed();
  if (cursor_.accept_word("with")) {
    cursor_.expect_word("slope");
    result.by_slope = true;
    // `with slope = ...` mixes the two forms.
    if (cursor_.at(TokenKind::equal))
      cursor_.fail(diagnose("E0201", cursor_.peek().span,
                            "`with slope` is followed by the slope, without `=`"));
  } else {
    cursor_.expect(TokenKind::equal, "`=` and the potential, or `with slope` and its slope");
  }
  result.value = expressions_.expr();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

std::vector<ast::LawParameter> DeclarationParser::law_parameters() {
  std::vector<ast::LawParameter> result;
  while (cursor_.accept(TokenKind::comma)) {
    ast::LawParameter& parameter = result.emplace_back();
    parameter.name = names_.name("the name of a parameter");
    if (cursor_.accept(TokenKind::equal)) parameter.value = expressions_.expr();
  }
  return result;
}

// state = "state" name "on" name "with" "rate" expr "from" name "=" expr [ "in" list ] ;
ast::State DeclarationParser::state() {
  ast::State result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the state");
  cursor_.expect_word("on");
  result.part = names_.name("the name of a part");
  cursor_.expect_word("with");
  cursor_.expect_word("rate");
  result.rate = expressions_.expr();
  const Span first = cursor_.expect_word("from").span;
  result.initial.unknown = names_.name("the name of the state");
  cursor_.expect(TokenKind::equal);
  result.initial.value = expressions_.expr();
  result.initial.span = cursor_.span_from(first);
  if (cursor_.accept_word("in")) result.range = expressions_.list();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// fn = "fn" name "(" [ name { "," name } ] ")" "=" expr ;
ast::Fn DeclarationParser::fn() {
  ast::Fn result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the function");
  const Token open = cursor_.expect(TokenKind::open_paren, "`(` and the arguments");
  cursor_.opened(open);
  if (!cursor_.at(TokenKind::close_paren)) {
    do result.parameters.push_back(names_.name("the name of an argument"));
    while (cursor_.accept(TokenKind::comma));
  }
  if (!cursor_.at(TokenKind::close_paren)) cursor_.fail_unclosed(open, TokenKind::close_paren);
  cursor_.take();
  cursor_.closed();
  cursor_.expect(TokenKind::equal);
  result.value = expressions_.expr();
  result.span = cursor_.span_from(result.keyword);
  return result;
}

// space = "space" name "=" ( "scalar" | "vector" ) name "on" name { "," ( "zero" [ "." name ] "on"
// name | "periodic" [ "." name ] name "=" name ) } ;
ast::Space DeclarationParser::space() {
  ast::Space result;
  result.keyword = cursor_.take().span;
  result.name = names_.declared_name("the name of the space");
  cursor_.expect(TokenKind::equal);
  if (!cursor_.at_word("scalar") && !cursor_.at_word("vector"))
    cursor_.fail_expected("`scalar` or `vector`");
  result.vector = cursor_.at_word("vector");
  result.shape_word = cursor_.take().span;
  const bool left_out = cursor_.at_word("on") && !cursor_.at_word("on", 1);
  if (left_out) cursor_.fail_expected("the element (`P1`, `P2`)");
  result.element = names_.name("the element (`P1`, `P2`)");
  cursor_.expect_word("on");
  result.domain = names_.name("the name of a mesh or part");
  while (cursor_.accept(TokenKind::comma))
    if (cursor_.at_word("periodic"))
      result.periodic.push_back(periodic_condition());
    else
      result.zero.push_back(zero_condition());
  result.span = cursor_.span_from(result.keyword);
  return result;
}

ast::PeriodicCondition DeclarationParser::periodic_condition() {
  ast::PeriodicCondition result;
  const Span first = cursor_.take().span;
  if (cursor_.accept(TokenKind::dot)) result.component = names_.member_name();
  result.first = names_.name("the name of a part");
  cursor_.expect(TokenKind::equal);
  result.second = names_.name("the name of the part on the other side");
  result.span = cursor_.span_from(first);
  return result;
}

ast::ZeroCondition DeclarationParser::zero_condition() {
  ast::ZeroCondition result;
  const Span first = cursor_.expect_word("zero").span;
  if (cursor_.accept(TokenKind::dot)) result.component = names_.member_name();
  cursor_.expect_word("on");
  result.part = names_.name("the name of a part");
  result.span = cursor_.span_from(first);
  return result;
}

} // namespace hvi::lang
