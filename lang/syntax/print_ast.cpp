// Dump of the syntax tree, see print.hpp. One function per node, in the order of ast.hpp.
#include "lang/syntax/print.hpp"

#include <fmt/format.h>

#include <array>

namespace hvi::lang {
namespace {

constexpr std::array<std::string_view, 6> operators{"+", "-", "*", "/", ":", "^"};
constexpr std::array<std::string_view, 6> comparisons{"<", "<=", ">", ">=", "==", "!="};

// Writes lines; every function takes the role of the node in its parent ("value: ").
class Printer {
public:
  explicit Printer(const SourceFile* source) : source_(source) {}
  std::string take() { return std::move(out_); }

  void print(std::string_view role, const ast::Expr& expr);
  void print(std::string_view role, const ast::Condition& condition);
  void print(const ast::Statement& statement) {
    std::visit([this](const auto& node) { (*this)(node); }, statement);
  }

  // Expressions: the line of the node itself is `head`, its children are one level deeper.
  void operator()(const ast::Number& node) { head(fmt::format("number {}", node.value)); }
  void operator()(const ast::Quantity& node);
  void operator()(const ast::String& node) { head("string \"" + node.text + "\""); }
  void operator()(const ast::Reference& node) { head("name " + node.name); }
  void operator()(const ast::List& node);
  void operator()(const ast::Negate& node);
  void operator()(const ast::Binary& node);
  void operator()(const ast::Cases& node);
  void operator()(const ast::Member& node);
  void operator()(const ast::Prime& node);
  void operator()(const ast::Call& node);
  void operator()(const ast::Clarke& node);
  void operator()(const ast::Compare& node);
  void operator()(const ast::Inside& node) { head("inside " + node.part.text); }
  void operator()(const ast::Not& node);
  void operator()(const ast::And& node) { operands("and", node.operands); }
  void operator()(const ast::Or& node) { operands("or", node.operands); }

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
  class Indent {
  public:
    explicit Indent(Printer& printer) : printer_(printer) { ++printer_.depth_; }
    ~Indent() { --printer_.depth_; }
    Indent(const Indent&) = delete;
    Indent& operator=(const Indent&) = delete;

  private:
    Printer& printer_;
  };

  void line(std::string_view text, const Span& span);
  void head(std::string_view text) { line(role_ + std::string(text), span_); }
  void operands(std::string_view word, const std::vector<ast::Condition>& operands);
  void region(std::string_view role, const ast::Region& region);
  void form(std::string_view role, const ast::Form& form);
  void form_term(const ast::FormTerm& term);
  void setting(std::string_view role, const ast::Setting& setting);
  void binding(const ast::Binding& binding);
  void find_time(const ast::TimeClause& time);
  void optional(std::string_view role, const std::optional<ast::Expr>& expr) {
    if (expr) print(role, *expr);
  }
  void optional(std::string_view role, const std::optional<ast::Text>& text) {
    if (text) line(std::string(role) + "\"" + text->text + "\"", text->span);
  }
  template <class Node>
  void named(std::string_view word, const Node& node) {
    line(std::string(word) + " " + node.name.text, node.span);
    const Indent indent(*this);
    print("", node.value);
  }
  static std::string names(const std::vector<ast::Name>& names);

  const SourceFile* source_;
  std::string out_;
  std::size_t depth_ = 0;
  std::string role_; // of the node being visited
  Span span_;        // of the node being visited
};

void Printer::line(std::string_view text, const Span& span) {
  out_.append(2 * depth_, ' ').append(text);
  if (source_ != nullptr) {
    const Position begin = source_->position(span.begin);
    const Position end = source_->position(span.end);
    out_ += fmt::format("  @{}:{}-{}:{}", begin.line, begin.column, end.line, end.column);
  }
  out_ += '\n';
}

void Printer::print(std::string_view role, const ast::Expr& expr) {
  role_ = role;
  span_ = expr.span;
  std::visit([this](const auto& node) { (*this)(node); }, expr.node);
}

void Printer::print(std::string_view role, const ast::Condition& condition) {
  role_ = role;
  span_ = condition.span;
  std::visit([this](const auto& node) { (*this)(node); }, condition.node);
}

std::string Printer::names(const std::vector<ast::Name>& names) {
  std::string result;
  for (const ast::Name& name : names) result += (result.empty() ? "" : ", ") + name.text;
  return result;
}

// --- expressions and conditions ----------------------------------------------------------------

void Printer::operator()(const ast::List& node) {
  head("list");
  const Indent indent(*this);
  for (const ast::Expr& item : node.items) print("", item);
}

void Printer::operator()(const ast::Negate& node) {
  head("negate");
  const Indent indent(*this);
  print("", *node.operand);
}

void Printer::operator()(const ast::Binary& node) {
  head("binary " + std::string(operators[static_cast<std::size_t>(node.op)]));
  const Indent indent(*this);
  print("", *node.left);
  print("", *node.right);
}

void Printer::operator()(const ast::Cases& node) {
  head("cases");
  const Indent indent(*this);
  for (const ast::Case& item : node.cases) {
    line("case", item.span);
    const Indent deeper(*this);
    print("if: ", item.condition);
    print("value: ", item.value);
  }
  print("otherwise: ", *node.otherwise);
}

void Printer::operator()(const ast::Member& node) {
  head("member ." + node.member.text);
  const Indent indent(*this);
  print("", *node.object);
}

void Printer::operator()(const ast::Quantity& node) {
  head("unit " + node.unit.text);
  const Indent indent(*this);
  print("", *node.value);
}

void Printer::operator()(const ast::Prime& node) {
  head("prime");
  const Indent indent(*this);
  print("", *node.operand);
}

void Printer::operator()(const ast::Call& node) {
  head("call");
  const Indent indent(*this);
  print("callee: ", *node.callee);
  for (const ast::Argument& argument : node.arguments)
    print(argument.name ? argument.name->text + " = " : "", argument.value);
}

void Printer::operator()(const ast::Clarke& node) {
  head("clarke");
  const Indent indent(*this);
  print("law: ", *node.law);
  print("at: ", *node.at);
  print("direction: ", *node.direction);
}

void Printer::operator()(const ast::Compare& node) {
  head("compare " + std::string(comparisons[static_cast<std::size_t>(node.op)]));
  const Indent indent(*this);
  print("", node.left);
  print("", node.right);
}

void Printer::operator()(const ast::Not& node) {
  head("not");
  const Indent indent(*this);
  print("", *node.operand);
}

void Printer::operands(std::string_view word, const std::vector<ast::Condition>& operands) {
  head(word);
  const Indent indent(*this);
  for (const ast::Condition& operand : operands) print("", operand);
}

// --- declarations ------------------------------------------------------------------------------

void Printer::operator()(const ast::Import& node) {
  if (const auto* name = std::get_if<ast::Name>(&node.module))
    line("import " + name->text, node.span);
  else
    line("import \"" + std::get<ast::Text>(node.module).text + "\"", node.span);
}

void Printer::operator()(const ast::Units& node) {
  std::string units;
  for (const ast::UnitText& unit : node.units) units += (units.empty() ? " " : ", ") + unit.text;
  line("units" + units, node.span);
}

void Printer::operator()(const ast::Param& node) {
  line("param " + node.name.text, node.span);
  const Indent indent(*this);
  print("", node.value);
  optional("in: ", node.range);
  optional("doc: ", node.doc);
}

void Printer::operator()(const ast::Part& node) {
  line("part " + node.name.text, node.span);
  const Indent indent(*this);
  region("", node.region);
}

void Printer::region(std::string_view role, const ast::Region& region) {
  line(std::string(role) + "region", region.span);
  const Indent indent(*this);
  for (const ast::RegionTerm& term : region.terms) {
    const std::string sign = term.minus ? "- " : "+ ";
    if (const auto* path = std::get_if<ast::Expr>(&term.term))
      print(sign, *path);
    else
      this->region(sign, *std::get<Box<ast::Region>>(term.term));
  }
  if (region.where) print("where: ", *region.where);
}

void Printer::operator()(const ast::Kernel& node) {
  line("kernel " + node.name.text + "(" + names(node.parameters) + ")", node.span);
  const Indent indent(*this);
  print("", node.value);
}

void Printer::operator()(const ast::Superpotential& node) {
  const std::string how = node.by_slope ? " with slope" : "";
  line("superpotential " + node.name.text + "(" + node.argument.text + ")" + how, node.span);
  const Indent indent(*this);
  for (const ast::LawParameter& parameter : node.parameters) {
    line("parameter " + parameter.name.text, parameter.name.span);
    const Indent deeper(*this);
    optional("default: ", parameter.value);
  }
  print("", node.value);
}

void Printer::operator()(const ast::State& node) {
  line("state " + node.name.text + " on " + node.part.text, node.span);
  const Indent indent(*this);
  print("rate: ", node.rate);
  print("from: ", node.initial.value);
  optional("range: ", node.range);
}

void Printer::operator()(const ast::Fn& node) {
  line("fn " + node.name.text + "(" + names(node.parameters) + ")", node.span);
  const Indent indent(*this);
  print("", node.value);
}

void Printer::operator()(const ast::Space& node) {
  line(fmt::format("space {}: {} {} on {}", node.name.text, node.vector ? "vector" : "scalar",
                   node.element.text, node.domain.text),
       node.span);
  const Indent indent(*this);
  for (const ast::ZeroCondition& zero : node.zero)
    line("zero" + (zero.component ? "." + zero.component->text : "") + " on " + zero.part.text,
         zero.span);
  for (const ast::PeriodicCondition& periodic : node.periodic)
    line("periodic" + (periodic.component ? "." + periodic.component->text : "") + " " +
             periodic.first.text + " = " + periodic.second.text,
         periodic.span);
}

// --- the inequality ----------------------------------------------------------------------------

void Printer::operator()(const ast::Find& node) {
  std::string unknowns, tests;
  for (const ast::Unknown& u : node.unknowns) {
    const char* comma = unknowns.empty() ? "" : ", ";
    unknowns += fmt::format("{}{} in {}", comma, u.unknown.text, u.space.text);
    tests += fmt::format("{}{} in {}", comma, u.test.text, u.test_space.text);
  }
  line(fmt::format("find {} for all {}", unknowns, tests), node.span);
  const Indent indent(*this);
  for (const ast::ImposedValue& value : node.imposed) {
    const std::string component = value.component ? "." + value.component->text : "";
    line("with " + value.unknown.text + component + " on " + value.part.text, value.span);
    const Indent deeper(*this);
    print("", value.value);
  }
  if (node.time) find_time(*node.time);
  for (const ast::Setting& item : node.settings) setting("using ", item);
  form("left: ", node.left);
  line(node.inequality ? "relation >=" : "relation =", node.relation);
  form("right: ", node.right);
}

void Printer::find_time(const ast::TimeClause& time) {
  line("for t", time.span);
  const Indent indent(*this);
  print("in: ", time.range);
  print(time.by_steps ? "steps: " : "times: ", time.steps);
  for (const ast::InitialValue& value : time.initial) {
    line("from " + value.unknown.text + (value.rate ? "'" : ""), value.span);
    const Indent deeper(*this);
    print("", value.value);
  }
}

void Printer::setting(std::string_view role, const ast::Setting& setting) {
  line(std::string(role) + setting.name.text, setting.span);
  const Indent indent(*this);
  print("", setting.value);
}

void Printer::form(std::string_view role, const ast::Form& form) {
  line(std::string(role) + "form", form.span);
  const Indent indent(*this);
  for (const ast::FormTerm& term : form.terms) form_term(term);
}

void Printer::form_term(const ast::FormTerm& term) {
  const std::string sign = term.minus ? "- " : "+ ";
  if (!term.integral) return line(sign + "0", term.span);
  line(sign + "integral over " + term.integral->domain.text, term.span);
  const Indent indent(*this);
  for (const ast::Expr& factor : term.factors) print("factor: ", factor);
  print("", term.integral->integrand);
  for (const ast::Setting& option : term.integral->options) setting("option ", option);
}

// --- results -----------------------------------------------------------------------------------

void Printer::operator()(const ast::Report& node) {
  line("report", node.span);
  const Indent indent(*this);
  for (const ast::ReportItem& item : node.items)
    std::visit([this](const auto& it) { (*this)(it); }, item);
}

void Printer::operator()(const ast::TableItem& node) {
  line("table", node.span);
  const Indent indent(*this);
  for (const ast::Binding& column : node.columns) binding(column);
  optional("every: ", node.every);
  if (node.from_start.valid()) line("from start", node.from_start);
  optional("to: ", node.to);
}

void Printer::binding(const ast::Binding& binding) {
  line("column " + binding.name.text, binding.span);
  const Indent indent(*this);
  print("", binding.value);
  optional("at: ", binding.point);
  optional("t: ", binding.time);
}

void Printer::operator()(const ast::FieldsItem& node) {
  line("fields", node.span);
  const Indent indent(*this);
  for (const ast::Expr& field : node.fields) print("", field);
  optional("every: ", node.every);
  if (node.from_start.valid()) line("from start", node.from_start);
  optional("to: ", node.to);
}

void Printer::operator()(const ast::PictureItem& node) {
  line("picture", node.span);
  const Indent indent(*this);
  print("", node.field);
  for (const ast::Expr& field : node.more) print("", field);
  optional("deformed: ", node.deformed);
  optional("t: ", node.time);
  optional("to: ", node.to);
}

void Printer::operator()(const ast::LineItem& node) {
  line("line", node.span);
  const Indent indent(*this);
  for (const ast::Expr& field : node.fields) print("", field);
  print("from: ", node.from);
  print("to: ", node.end);
  print("points: ", node.points);
  optional("t: ", node.time);
  optional("to: ", node.to);
}

void Printer::operator()(const ast::PlotItem& node) {
  std::string names;
  for (const ast::Name& name : node.columns) names += (names.empty() ? "" : ", ") + name.text;
  line("plot " + names + " against " + node.against.text, node.span);
  const Indent indent(*this);
  optional("to: ", node.to);
}

void Printer::operator()(const ast::Expect& node) {
  line("expect " + node.probe.text + (node.relative ? " relative" : ""), node.span);
  const Indent indent(*this);
  optional("t: ", node.time);
  print("value: ", node.value);
  print("within: ", node.tolerance);
  if (node.when) print("when: ", *node.when);
  optional("source: ", node.source);
}

void Printer::operator()(const ast::Study& node) {
  line("study", node.span);
  const Indent indent(*this);
  for (const ast::Ladder& ladder : node.ladders) {
    std::string names = ladder.parameter.text;
    for (const ast::Name& name : ladder.more) names += ", " + name.text;
    print("vary " + names + ": ", ladder.values);
  }
  if (node.reference == ast::StudyReference::none) return;
  constexpr std::array<std::string_view, 3> references{"finest", "richardson", "exact"};
  line("against " + std::string(references[static_cast<std::size_t>(node.reference)]),
       node.reference_word);
  optional("exact: ", node.exact);
  if (node.norm) line("in " + node.norm->text, node.norm->span);
}

} // namespace

std::string print_ast(const ast::Program& program, const SourceFile* source) {
  Printer printer(source);
  for (const ast::Statement& statement : program.statements) printer.print(statement);
  return printer.take();
}

std::string print_ast(const ast::Expr& expr, const SourceFile* source) {
  Printer printer(source);
  printer.print("", expr);
  return printer.take();
}

} // namespace hvi::lang
