// Dump of the syntax tree, see print.hpp. One function per node, in the order of ast.hpp.
#include "lang/syntax/print.hpp"
#include "lang/syntax/print_expression.hpp"

#include <fmt/format.h>

namespace hvi::lang {
namespace {

class StatementPrinter {
public:
  explicit StatementPrinter(TreeLines& lines) : lines_(lines), expressions_(lines) {}

  void print(const ast::Statement& statement) {
    std::visit([this](const auto& node) { (*this)(node); }, statement);
  }

  void operator()(const ast::Import& node);
  void operator()(const ast::Units& node);
  void operator()(const ast::Param& node);
  void operator()(const ast::Mesh& node) { named("mesh", node); }
  void operator()(const ast::Part& node);
  void operator()(const ast::Tensor& node) { named("tensor", node); }
  void operator()(const ast::Kernel& node);
  void operator()(const ast::Superpotential& node);
  void operator()(const ast::State& node);
  void operator()(const ast::Fn& node);
  void operator()(const ast::Space& node);
  void operator()(const ast::Find& node);
  void operator()(const ast::Report& node);
  void operator()(const ast::TableItem& node);
  void operator()(const ast::FieldsItem& node);
  void operator()(const ast::PictureItem& node);
  void operator()(const ast::LineItem& node);
  void operator()(const ast::PlotItem& node);
  void operator()(const ast::Expect& node);
  void operator()(const ast::Study& node);

private:
  void form(std::string_view role, const ast::Form& form);
  void form_term(const ast::FormTerm& term);
  void setting(std::string_view role, const ast::Setting& setting);
  void binding(const ast::Binding& binding);
  void find_time(const ast::TimeClause& time);
  void optional(std::string_view role, const std::optional<ast::Expr>& expr) {
    if (expr) expressions_.print(role, *expr);
  }
  void optional(std::string_view role, const std::optional<ast::Text>& text) {
    if (text) lines_.line(std::string(role) + "\"" + text->text + "\"", text->span);
  }
  template <class Node>
  void named(std::string_view word, const Node& node) {
    lines_.line(std::string(word) + " " + node.name.text, node.span);
    const TreeLines::Indent indent(lines_);
    expressions_.print("", node.value);
  }
  static std::string names(const std::vector<ast::Name>& names);

  TreeLines& lines_;
  ExpressionPrinter expressions_;
};

// --- declarations ------------------------------------------------------------------------------

void StatementPrinter::operator()(const ast::Import& node) {
  if (const auto* name = std::get_if<ast::Name>(&node.module))
    lines_.line("import " + name->text, node.span);
  else
    lines_.line("import \"" + std::get<ast::Text>(node.module).text + "\"", node.span);
}

void StatementPrinter::operator()(const ast::Units& node) {
  std::string units;
  for (const ast::UnitText& unit : node.units) units += (units.empty() ? " " : ", ") + unit.text;
  lines_.line("units" + units, node.span);
}

void StatementPrinter::operator()(const ast::Param& node) {
  lines_.line("param " + node.name.text, node.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("", node.value);
  optional("in: ", node.range);
  optional("doc: ", node.doc);
}

void StatementPrinter::operator()(const ast::Part& node) {
  lines_.line("part " + node.name.text, node.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("", node.region);
}

void StatementPrinter::operator()(const ast::Kernel& node) {
  lines_.line("kernel " + node.name.text + "(" + names(node.parameters) + ")", node.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("", node.value);
}

void StatementPrinter::operator()(const ast::Superpotential& node) {
  const std::string how = node.by_slope ? " with slope" : "";
  lines_.line("superpotential " + node.name.text + "(" + node.argument.text + ")" + how, node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::LawParameter& parameter : node.parameters) {
    lines_.line("parameter " + parameter.name.text, parameter.name.span);
    const TreeLines::Indent deeper(lines_);
    optional("default: ", parameter.value);
  }
  expressions_.print("", node.value);
}

void StatementPrinter::operator()(const ast::State& node) {
  lines_.line("state " + node.name.text + " on " + node.part.text, node.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("rate: ", node.rate);
  expressions_.print("from: ", node.initial.value);
  optional("range: ", node.range);
}

void StatementPrinter::operator()(const ast::Fn& node) {
  lines_.line("fn " + node.name.text + "(" + names(node.parameters) + ")", node.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("", node.value);
}

void StatementPrinter::operator()(const ast::Space& node) {
  lines_.line(fmt::format("space {}: {} {} on {}", node.name.text,
                          node.vector ? "vector" : "scalar", node.element.text, node.domain.text),
              node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::ZeroCondition& zero : node.zero)
    lines_.line("zero" + (zero.component ? "." + zero.component->text : "") + " on " +
                    zero.part.text,
                zero.span);
  for (const ast::PeriodicCondition& periodic : node.periodic)
    lines_.line("periodic" + (periodic.component ? "." + periodic.component->text : "") + " " +
                    periodic.first.text + " = " + periodic.second.text,
                periodic.span);
}

// --- the inequality ----------------------------------------------------------------------------

void StatementPrinter::operator()(const ast::Find& node) {
  std::string unknowns, tests;
  for (const ast::Unknown& u : node.unknowns) {
    const char* comma = unknowns.empty() ? "" : ", ";
    unknowns += fmt::format("{}{} in {}", comma, u.unknown.text, u.space.text);
    tests += fmt::format("{}{} in {}", comma, u.test.text, u.test_space.text);
  }
  lines_.line(fmt::format("find {} for all {}", unknowns, tests), node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::ImposedValue& value : node.imposed) {
    const std::string component = value.component ? "." + value.component->text : "";
    lines_.line("with " + value.unknown.text + component + " on " + value.part.text, value.span);
    const TreeLines::Indent deeper(lines_);
    expressions_.print("", value.value);
  }
  if (node.time) find_time(*node.time);
  for (const ast::Setting& item : node.settings) setting("using ", item);
  form("left: ", node.left);
  lines_.line(node.inequality ? "relation >=" : "relation =", node.relation);
  form("right: ", node.right);
}

void StatementPrinter::find_time(const ast::TimeClause& time) {
  lines_.line("for t", time.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("in: ", time.range);
  expressions_.print(time.by_steps ? "steps: " : "times: ", time.steps);
  for (const ast::InitialValue& value : time.initial) {
    lines_.line("from " + value.unknown.text + (value.rate ? "'" : ""), value.span);
    const TreeLines::Indent deeper(lines_);
    expressions_.print("", value.value);
  }
}

void StatementPrinter::setting(std::string_view role, const ast::Setting& setting) {
  lines_.line(std::string(role) + setting.name.text, setting.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("", setting.value);
}

void StatementPrinter::form(std::string_view role, const ast::Form& form) {
  lines_.line(std::string(role) + "form", form.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::FormTerm& term : form.terms) form_term(term);
}

void StatementPrinter::form_term(const ast::FormTerm& term) {
  const std::string sign = term.minus ? "- " : "+ ";
  if (!term.integral) return lines_.line(sign + "0", term.span);
  lines_.line(sign + "integral over " + term.integral->domain.text, term.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::Expr& factor : term.factors) expressions_.print("factor: ", factor);
  expressions_.print("", term.integral->integrand);
  for (const ast::Setting& option : term.integral->options) setting("option ", option);
}

// --- results -----------------------------------------------------------------------------------

void StatementPrinter::operator()(const ast::Report& node) {
  lines_.line("report", node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::ReportItem& item : node.items)
    std::visit([this](const auto& it) { (*this)(it); }, item);
}

void StatementPrinter::operator()(const ast::TableItem& node) {
  lines_.line("table", node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::Binding& column : node.columns) binding(column);
  optional("every: ", node.every);
  if (node.from_start.valid()) lines_.line("from start", node.from_start);
  optional("to: ", node.to);
}

void StatementPrinter::binding(const ast::Binding& binding) {
  lines_.line("column " + binding.name.text, binding.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("", binding.value);
  optional("at: ", binding.point);
  if (binding.side) lines_.line("on " + binding.side->text, binding.side->span);
  optional("t: ", binding.time);
}

void StatementPrinter::operator()(const ast::FieldsItem& node) {
  lines_.line("fields", node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::Expr& field : node.fields) expressions_.print("", field);
  optional("every: ", node.every);
  if (node.from_start.valid()) lines_.line("from start", node.from_start);
  optional("to: ", node.to);
}

void StatementPrinter::operator()(const ast::PictureItem& node) {
  lines_.line("picture", node.span);
  const TreeLines::Indent indent(lines_);
  expressions_.print("", node.field);
  for (const ast::Expr& field : node.more) expressions_.print("", field);
  optional("deformed: ", node.deformed);
  optional("t: ", node.time);
  optional("to: ", node.to);
}

void StatementPrinter::operator()(const ast::LineItem& node) {
  lines_.line("line", node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::Expr& field : node.fields) expressions_.print("", field);
  expressions_.print("from: ", node.from);
  expressions_.print("to: ", node.end);
  expressions_.print("points: ", node.points);
  optional("t: ", node.time);
  optional("to: ", node.to);
}

void StatementPrinter::operator()(const ast::PlotItem& node) {
  std::string names;
  for (const ast::Name& name : node.columns) names += (names.empty() ? "" : ", ") + name.text;
  lines_.line("plot " + names + " against " + node.against.text, node.span);
  const TreeLines::Indent indent(lines_);
  optional("to: ", node.to);
}

void StatementPrinter::operator()(const ast::Expect& node) {
  lines_.line("expect " + node.probe.text + (node.relative ? " relative" : ""), node.span);
  const TreeLines::Indent indent(lines_);
  optional("t: ", node.time);
  expressions_.print("value: ", node.value);
  expressions_.print("within: ", node.tolerance);
  if (node.when) expressions_.print("when: ", *node.when);
  optional("source: ", node.source);
}

void StatementPrinter::operator()(const ast::Study& node) {
  lines_.line("study", node.span);
  const TreeLines::Indent indent(lines_);
  for (const ast::Ladder& ladder : node.ladders) {
    std::string names = ladder.parameter.text;
    for (const ast::Name& name : ladder.more) names += ", " + name.text;
    expressions_.print("vary " + names + ": ", ladder.values);
  }
  if (node.reference == ast::StudyReference::none) return;
  constexpr std::array<std::string_view, 3> references{"finest", "richardson", "exact"};
  lines_.line("against " + std::string(references[static_cast<std::size_t>(node.reference)]),
              node.reference_word);
  optional("exact: ", node.exact);
  if (node.norm) lines_.line("in " + node.norm->text, node.norm->span);
}

std::string StatementPrinter::names(const std::vector<ast::Name>& names) {
  std::string result;
  for (const ast::Name& name : names) result += (result.empty() ? "" : ", ") + name.text;
  return result;
}

} // namespace

std::string print_ast(const ast::Program& program, const SourceFile* source) {
  TreeLines lines(source);
  StatementPrinter printer(lines);
  for (const ast::Statement& statement : program.statements) printer.print(statement);
  return lines.take();
}

} // namespace hvi::lang
