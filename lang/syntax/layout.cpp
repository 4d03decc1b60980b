// The layout of a syntax tree, see layout.hpp.
#include "lang/syntax/layout.hpp"

#include <type_traits>

namespace hvi::lang {
namespace {

class LayoutMaker {
public:
  Layout take() { return std::move(layout_); }
  void statement(const ast::Statement& statement);

  // Expressions: calls and negations at any depth.
  void operator()(const ast::Number&) {}
  void operator()(const ast::Quantity& node) { expr(*node.value); }
  void operator()(const ast::String&) {}
  void operator()(const ast::Reference&) {}
  void operator()(const ast::List& node) {
    for (const ast::Expr& item : node.items) expr(item);
  }
  void operator()(const ast::Negate& node) {
    glue_behind(node.op);
    expr(*node.operand);
  }
  void operator()(const ast::Binary& node) {
    expr(*node.left);
    expr(*node.right);
  }
  void operator()(const ast::Cases& node);
  void operator()(const ast::Member& node) { expr(*node.object); }
  void operator()(const ast::Prime& node) { expr(*node.operand); }
  void operator()(const ast::Call& node);
  void operator()(const ast::Clarke& node) {
    expr(*node.law);
    expr(*node.at);
    expr(*node.direction);
  }
  void operator()(const ast::Compare& node) {
    expr(node.left);
    expr(node.right);
  }
  void operator()(const ast::Inside& node) { glue_behind(node.word); }
  void operator()(const ast::Not& node) { condition(*node.operand); }
  void operator()(const ast::And& node) {
    for (const ast::Condition& operand : node.operands) condition(operand);
  }
  void operator()(const ast::Or& node) {
    for (const ast::Condition& operand : node.operands) condition(operand);
  }

  void operator()(const ast::Import&) {}
  void operator()(const ast::Units&) {}
  void operator()(const ast::Param& node);
  void operator()(const ast::Mesh& node) { expr(node.value); }
  void operator()(const ast::Part& node) { region(node.region); }
  void operator()(const ast::Tensor& node) { definition(node.value); }
  void operator()(const ast::Kernel& node) {
    glue_behind(node.name.span);
    definition(node.value);
  }
  void operator()(const ast::Superpotential& node);
  void operator()(const ast::State& node);
  void operator()(const ast::Fn& node) {
    glue_behind(node.name.span);
    definition(node.value);
  }
  void operator()(const ast::Space&) {}
  void operator()(const ast::Find& node);
  void operator()(const ast::Report& node);
  void operator()(const ast::TableItem& node);
  void operator()(const ast::FieldsItem& node);
  void operator()(const ast::PictureItem& node);
  void operator()(const ast::LineItem& node);
  void operator()(const ast::PlotItem&) {}
  void operator()(const ast::Expect& node);
  void operator()(const ast::Study& node);

private:
  void expr(const ast::Expr& expr) {
    std::visit([this](const auto& node) { (*this)(node); }, expr.node);
  }
  void optional(const std::optional<ast::Expr>& value) {
    if (value) expr(*value);
  }
  void condition(const ast::Condition& condition) {
    std::visit([this](const auto& node) { (*this)(node); }, condition.node);
  }
  void definition(const ast::Expr& value);
  void region(const ast::Region& region);
  void form(const ast::Form& form, bool left);
  void break_at(const Span& span, std::size_t indent) { layout_.breaks[span.begin] = indent; }
  void soft_break_at(const Span& span, std::size_t indent) {
    layout_.soft_breaks[span.begin] = indent;
  }

  void glue_behind(const Span& span) { layout_.glued_right.insert(span.begin); }

  Layout layout_;
};

void LayoutMaker::operator()(const ast::Cases& node) {
  for (const ast::Case& item : node.cases) {
    condition(item.condition);
    expr(item.value);
  }
  expr(*node.otherwise);
}

void LayoutMaker::operator()(const ast::Call& node) {
  layout_.glued_left.insert(node.open.begin);
  expr(*node.callee);
  for (const ast::Argument& argument : node.arguments) expr(argument.value);
}

void LayoutMaker::statement(const ast::Statement& statement) {
  std::visit(
      [this](const auto& node) {
        break_at(node.keyword, 0);
        (*this)(node);
      },
      statement);
}

void LayoutMaker::operator()(const ast::Param& node) {
  expr(node.value);
  optional(node.range);
  if (!node.doc) return;
  layout_.set_apart.insert(node.doc->span.begin);
  soft_break_at(node.doc->span, 4);
}

// The value of a definition: cases stand on lines of their own, their arrows in a column.
void LayoutMaker::definition(const ast::Expr& value) {
  expr(value);
  const auto* cases = std::get_if<ast::Cases>(&value.node);
  if (cases == nullptr || value.parens > 0) return soft_break_at(value.span, 2);
  const int group = layout_.n_groups++;
  for (const ast::Case& item : cases->cases) {
    break_at(item.span, 2);
    layout_.groups[item.arrow.begin] = group;
  }
  break_at(cases->otherwise_bar, 2);
  layout_.groups[cases->otherwise_arrow.begin] = group;
}

void LayoutMaker::operator()(const ast::Superpotential& node) {
  glue_behind(node.name.span);
  for (const ast::LawParameter& parameter : node.parameters) optional(parameter.value);
  definition(node.value);
}

void LayoutMaker::operator()(const ast::State& node) {
  expr(node.rate);
  expr(node.initial.value);
  optional(node.range);
  soft_break_at(node.initial.span, 2);
}

void LayoutMaker::region(const ast::Region& region) {
  for (const ast::RegionTerm& term : region.terms) {
    if (const auto* path = std::get_if<ast::Expr>(&term.term))
      expr(*path);
    else
      this->region(*std::get<Box<ast::Region>>(term.term));
  }
  if (region.where) condition(*region.where);
}

void LayoutMaker::operator()(const ast::Find& node) {
  for (const ast::ImposedValue& value : node.imposed) expr(value.value);
  if (!node.imposed.empty()) soft_break_at(node.with_word, 2);
  if (node.time) {
    soft_break_at(node.time->span, 2);
    expr(node.time->range);
    expr(node.time->steps);
    for (const ast::InitialValue& value : node.time->initial) expr(value.value);
  }
  if (!node.settings.empty()) soft_break_at(node.using_word, 2);
  for (const ast::Setting& setting : node.settings) expr(setting.value);
  break_at(node.such_that, 0);
  form(node.left, true);
  break_at(node.relation, node.inequality ? 1 : 2);
  form(node.right, false);
}

//     integral(...)          signs in the column of "=", terms behind them
//   + integral(...)
//  >= integral(...)
void LayoutMaker::form(const ast::Form& form, bool left) {
  for (std::size_t i = 0; i < form.terms.size(); ++i) {
    const ast::FormTerm& term = form.terms[i];
    const bool with_sign = term.sign.valid();
    if (i > 0 || (left && with_sign))
      break_at(term.sign, 2);
    else if (left)
      break_at(term.span, 4);
    else if (with_sign)
      glue_behind(term.sign);
    for (const ast::Expr& factor : term.factors) expr(factor);
    if (!term.integral) continue;
    glue_behind(term.integral->word);
    expr(term.integral->integrand);
    for (const ast::Setting& option : term.integral->options) expr(option.value);
  }
}

void LayoutMaker::operator()(const ast::Report& node) {
  const int group = layout_.n_groups++;
  for (const ast::ReportItem& item : node.items)
    std::visit(
        [&](const auto& it) {
          break_at(it.keyword, 2);
          (*this)(it);
        },
        item);
  const auto first_of = [](const auto& it) {
    using Item = std::decay_t<decltype(it)>;
    if constexpr (std::is_same_v<Item, ast::TableItem>) return it.columns.front().span;
    if constexpr (std::is_same_v<Item, ast::FieldsItem>) return it.fields.front().span;
    if constexpr (std::is_same_v<Item, ast::PictureItem>) return it.field.span;
    if constexpr (std::is_same_v<Item, ast::LineItem>) return it.fields.front().span;
    if constexpr (std::is_same_v<Item, ast::PlotItem>) return it.columns.front().span;
  };
  for (const ast::ReportItem& item : node.items)
    layout_.groups[std::visit(first_of, item).begin] = group;
}

void LayoutMaker::operator()(const ast::TableItem& node) {
  for (const ast::Binding& column : node.columns) {
    expr(column.value);
    optional(column.point);
    optional(column.time);
  }
  optional(node.every);
}

void LayoutMaker::operator()(const ast::FieldsItem& node) {
  for (const ast::Expr& field : node.fields) expr(field);
  optional(node.every);
}

void LayoutMaker::operator()(const ast::PictureItem& node) {
  expr(node.field);
  for (const ast::Expr& field : node.more) expr(field);
  optional(node.deformed);
  optional(node.time);
}

void LayoutMaker::operator()(const ast::LineItem& node) {
  for (const ast::Expr& field : node.fields) expr(field);
  expr(node.from);
  expr(node.end);
  expr(node.points);
  optional(node.time);
}

void LayoutMaker::operator()(const ast::Expect& node) {
  optional(node.time);
  expr(node.value);
  expr(node.tolerance);
  if (node.when) condition(*node.when);
  if (node.source) soft_break_at(node.source->span, 2);
}

void LayoutMaker::operator()(const ast::Study& node) {
  for (const ast::Ladder& ladder : node.ladders) expr(ladder.values);
  if (node.reference != ast::StudyReference::none) soft_break_at(node.against_word, 2);
  optional(node.exact);
}

} // namespace

Layout lay_out(const ast::Program& program) {
  LayoutMaker maker;
  for (const ast::Statement& statement : program.statements) maker.statement(statement);
  return maker.take();
}

} // namespace hvi::lang
