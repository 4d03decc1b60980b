// One function for each node that holds names; see tree_names.hpp.
#include "lang/syntax/tree_names.hpp"

#include <optional>
#include <variant>
#include <vector>

namespace hvi::lang {

namespace {

class Walk {
public:
  explicit Walk(const NameVisitor& visitor) : visitor_(visitor) {}

  void operator()(const ast::Import&) {}
  void operator()(const ast::Units&) {}
  void operator()(const ast::Param& s) { visit(s.value), visit(s.range); }
  void operator()(const ast::Mesh& s) { visit(s.value); }
  void operator()(const ast::Part& s) { visit(s.region); }
  void operator()(const ast::Tensor& s) { visit(s.value); }
  void operator()(const ast::Kernel& s) { visit(s.value); }
  void operator()(const ast::Fn& s) { visit(s.value); }
  void operator()(const ast::Superpotential& s) {
    for (const ast::LawParameter& parameter : s.parameters) visit(parameter.value);
    visit(s.value);
  }
  void operator()(const ast::State& s) {
    visit(s.part), visit(s.rate), visit(s.initial), visit(s.range);
  }
  void operator()(const ast::Space& s) {
    visit(s.element), visit(s.domain);
    for (const ast::ZeroCondition& zero : s.zero) visit(zero.part);
    for (const ast::PeriodicCondition& p : s.periodic) visit(p.first), visit(p.second);
  }
  void operator()(const ast::Find& s) {
    for (const ast::Unknown& u : s.unknowns) visit(u.space), visit(u.test_space);
    for (const ast::ImposedValue& value : s.imposed)
      visit(value.unknown), visit(value.value), visit(value.part);
    if (s.time) {
      visit(s.time->range), visit(s.time->steps);
      for (const ast::InitialValue& initial : s.time->initial) visit(initial);
    }
    for (const ast::Setting& setting : s.settings) {
      const auto* name = std::get_if<ast::Reference>(&setting.value.node);
      if (setting.name.text == "accuracy_of" && name)
        visitor_.column(name->name, setting.value.span);
      else
        visit(setting.value);
    }
    visit(s.left), visit(s.right);
  }
  void operator()(const ast::Report& s) {
    for (const ast::ReportItem& item : s.items) std::visit(*this, item);
  }
  void operator()(const ast::TableItem& item) {
    for (const ast::Binding& b : item.columns) {
      visit(b.value), visit(b.point), visit(b.side), visit(b.time);
    }
    visit(item.every);
  }
  void operator()(const ast::FieldsItem& item) {
    for (const ast::Expr& field : item.fields) visit(field);
    visit(item.every);
  }
  void operator()(const ast::PictureItem& item) {
    visit(item.field), visit(item.deformed), visit(item.time);
    for (const ast::Expr& field : item.more) visit(field);
  }
  void operator()(const ast::LineItem& item) {
    for (const ast::Expr& field : item.fields) visit(field);
    visit(item.from), visit(item.end), visit(item.points), visit(item.time);
  }
  void operator()(const ast::PlotItem& item) {
    for (const ast::Name& column : item.columns) visitor_.column(column.text, column.span);
    visitor_.column(item.against.text, item.against.span);
  }
  void operator()(const ast::Expect& s) {
    visitor_.column(s.probe.text, s.probe.span);
    visit(s.time), visit(s.value), visit(s.tolerance), visit(s.when);
  }
  void operator()(const ast::Study& s) {
    for (const ast::Ladder& ladder : s.ladders) {
      visit(ladder.parameter), visit(ladder.values);
      for (const ast::Name& name : ladder.more) visit(name);
    }
    visit(s.exact), visit(s.norm);
  }

  // expressions
  void operator()(const ast::Number&) {}
  void operator()(const ast::Quantity& node) { visit(*node.value); }
  void operator()(const ast::String&) {}
  void operator()(const ast::Reference& node) { visitor_.use(node.name, here_); }
  void operator()(const ast::List& node) {
    for (const ast::Expr& item : node.items) visit(item);
  }
  void operator()(const ast::Negate& node) { visit(*node.operand); }
  void operator()(const ast::Binary& node) { visit(*node.left), visit(*node.right); }
  void operator()(const ast::Cases& node) {
    for (const ast::Case& one : node.cases) visit(one.condition), visit(one.value);
    visit(*node.otherwise);
  }
  void operator()(const ast::Member& node) { visit(*node.object); }
  void operator()(const ast::Prime& node) { visit(*node.operand); }
  void operator()(const ast::Call& node) {
    const auto* callee = std::get_if<ast::Reference>(&node.callee->node);
    visit(*node.callee);
    for (const ast::Argument& argument : node.arguments) {
      if (argument.name && callee && visitor_.argument)
        visitor_.argument(callee->name, *argument.name);
      visit(argument.value);
    }
  }
  void operator()(const ast::Clarke& node) {
    visit(*node.law), visit(*node.at), visit(*node.direction);
  }

  // conditions
  void operator()(const ast::Compare& node) { visit(node.left), visit(node.right); }
  void operator()(const ast::Inside& node) { visit(node.part); }
  void operator()(const ast::Not& node) { visit(*node.operand); }
  void operator()(const ast::And& node) {
    for (const ast::Condition& one : node.operands) visit(one);
  }
  void operator()(const ast::Or& node) {
    for (const ast::Condition& one : node.operands) visit(one);
  }

  void visit(const ast::Expr& e) {
    const Span outer = here_;
    here_ = e.span;
    std::visit(*this, e.node);
    here_ = outer;
  }

private:
  void visit(const ast::Name& name) { visitor_.use(name.text, name.span); }
  void visit(const ast::Condition& condition) { std::visit(*this, condition.node); }
  void visit(const ast::InitialValue& initial) { visit(initial.unknown), visit(initial.value); }
  void visit(const ast::Region& region) {
    for (const ast::RegionTerm& term : region.terms) {
      if (const auto* path = std::get_if<ast::Expr>(&term.term)) visit(*path);
      if (const auto* inner = std::get_if<Box<ast::Region>>(&term.term)) visit(**inner);
    }
    visit(region.where);
  }
  void visit(const ast::Form& form) {
    for (const ast::FormTerm& term : form.terms) {
      for (const ast::Expr& factor : term.factors) visit(factor);
      if (!term.integral) continue;
      visit(term.integral->domain), visit(term.integral->integrand);
      for (const ast::Setting& option : term.integral->options) visit(option.value);
    }
  }
  template <class T>
  void visit(const std::optional<T>& what) {
    if (what) visit(*what);
  }

  const NameVisitor& visitor_;
  Span here_; ///< of the expression that is visited
};

} // namespace

void visit_names(const ast::Statement& statement, const NameVisitor& visitor) {
  std::visit(Walk(visitor), statement);
}

void visit_names(const ast::Expr& expression, const NameVisitor& visitor) {
  Walk(visitor).visit(expression);
}

} // namespace hvi::lang
