// See mathematics.hpp.
#include "lang/report/mathematics.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <string_view>
#include <utility>

namespace hvi::lang {
namespace {

using Json = nlohmann::ordered_json;

Json node(const char* name, std::initializer_list<Json> children) {
  Json out = Json::array({name});
  for (const Json& child : children) out.push_back(child);
  return out;
}
Json sign(const char* text) { return node("mo", {text}); }
Json row() { return Json::array({"mrow"}); }

/// Letters as the field writes them.
constexpr std::array<std::pair<std::string_view, const char*>, 26> letters{{
    {"alpha", "α"}, {"beta", "β"},  {"gamma", "γ"},  {"delta", "δ"}, {"eps", "ε"},   {"eta", "η"},
    {"theta", "θ"}, {"kappa", "κ"}, {"lambda", "λ"}, {"mu", "μ"},    {"nu", "ν"},    {"xi", "ξ"},
    {"pi", "π"},    {"rho", "ρ"},   {"sigma", "σ"},  {"tau", "τ"},   {"phi", "φ"},   {"chi", "χ"},
    {"psi", "ψ"},   {"omega", "ω"}, {"Gamma", "Γ"},  {"Delta", "Δ"}, {"Omega", "Ω"}, {"Sigma", "Σ"},
    {"Phi", "Φ"},   {"zeta", "ζ"},
}};

Json name_of(std::string_view text) {
  for (const auto& [word, letter] : letters)
    if (word == text) return node("mi", {letter});
  return node("mi", {std::string(text)});
}

const char* sign_of(ast::BinaryOp op) {
  switch (op) {
  case ast::BinaryOp::add:
    return "+";
  case ast::BinaryOp::subtract:
    return "−";
  case ast::BinaryOp::contract:
    return ":";
  default:
    return "\u2062"; // invisible times
  }
}
const char* sign_of(ast::CompareOp op) {
  constexpr const char* signs[] = {"<", "≤", ">", "≥", "=", "≠"};
  return signs[static_cast<int>(op)];
}

/// How tightly an expression holds together: what stands in a tighter one needs brackets.
enum class Tightness { sum, product, atom };

Tightness tightness_of(const ast::Expr& e) {
  if (std::holds_alternative<ast::Negate>(e.node)) return Tightness::sum;
  const auto* binary = std::get_if<ast::Binary>(&e.node);
  if (!binary) return Tightness::atom;
  switch (binary->op) {
  case ast::BinaryOp::add:
  case ast::BinaryOp::subtract:
    return Tightness::sum;
  case ast::BinaryOp::multiply:
  case ast::BinaryOp::contract:
    return Tightness::product;
  default:
    return Tightness::atom;
  }
}

Json of(const ast::Expr& e);
Json of(const ast::Condition& c);

Json in_brackets(Json inside, const char* open = "(", const char* close = ")") {
  return node("mrow", {sign(open), std::move(inside), sign(close)});
}

Json at_least(const ast::Expr& e, Tightness wanted) {
  return tightness_of(e) < wanted ? in_brackets(of(e)) : of(e);
}

Json separated(const std::vector<const ast::Expr*>& items, const char* by = ",") {
  Json out = row();
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) out.push_back(sign(by));
    out.push_back(of(*items[i]));
  }
  return out;
}

/// int_0^t q(t, s) x(s) ds
Json memory(const ast::Expr& kernel, const ast::Expr& of_what) {
  Json integral = node("msubsup", {sign("∫"), node("mn", {"0"}), node("mi", {"t"})});
  const auto* name = std::get_if<ast::Reference>(&kernel.node);
  Json weight = name ? node("mrow", {name_of(name->name), sign("("), node("mi", {"t"}), sign(","),
                                     node("mi", {"s"}), sign(")")})
                     : in_brackets(of(kernel));
  return node("mrow", {integral, weight, of(of_what), sign("("), node("mi", {"s"}), sign(")"),
                       node("mi", {"ds"})});
}

Json call(const ast::Call& c) {
  std::vector<const ast::Expr*> a;
  for (const auto& argument : c.arguments) a.push_back(&argument.value);
  const auto* callee = std::get_if<ast::Reference>(&c.callee->node);
  const std::string name = callee ? callee->name : "";
  if (name == "dot" && a.size() == 2)
    return node("mrow", {at_least(*a[0], Tightness::product), sign("·"),
                         at_least(*a[1], Tightness::product)});
  if (name == "history" && a.size() == 2) return memory(*a[0], *a[1]);
  if (name == "grad" && a.size() == 1)
    return node("mrow", {sign("∇"), at_least(*a[0], Tightness::atom)});
  if ((name == "norm" || name == "abs") && a.size() == 1)
    return in_brackets(of(*a[0]), name == "abs" ? "|" : "‖", name == "abs" ? "|" : "‖");
  if (name == "sqrt" && a.size() == 1) return node("msqrt", {of(*a[0])});
  if (name == "exp" && a.size() == 1) return node("msup", {node("mi", {"e"}), of(*a[0])});
  if (name == "jump" && a.size() == 1) return in_brackets(of(*a[0]), "⟦", "⟧");
  if (name == "mean" && a.size() == 1) return in_brackets(of(*a[0]), "{", "}");
  if (name == "pos" && a.size() == 1)
    return node("msub", {in_brackets(of(*a[0]), "[", "]"), sign("+")});
  Json inside = row();
  for (std::size_t i = 0; i < c.arguments.size(); ++i) {
    if (i > 0) inside.push_back(sign(","));
    if (c.arguments[i].name) {
      inside.push_back(name_of(c.arguments[i].name->text));
      inside.push_back(sign("="));
    }
    inside.push_back(of(c.arguments[i].value));
  }
  return node("mrow", {of(*c.callee), in_brackets(inside)});
}

Json member(const ast::Member& m) {
  if (m.member.text == "xi") return node("msub", {name_of("xi"), of(*m.object)});
  return node("msub", {of(*m.object), name_of(m.member.text)});
}

/// A dot over u for u', two for u''.
Json prime(const ast::Prime& p) {
  if (const auto* inner = std::get_if<ast::Prime>(&p.operand->node))
    return node("mover", {of(*inner->operand), sign("¨")});
  return node("mover", {of(*p.operand), sign("˙")});
}

Json binary(const ast::Binary& b) {
  if (b.op == ast::BinaryOp::divide) return node("mfrac", {of(*b.left), of(*b.right)});
  if (b.op == ast::BinaryOp::power)
    return node("msup", {at_least(*b.left, Tightness::atom), of(*b.right)});
  const bool sum = b.op == ast::BinaryOp::add || b.op == ast::BinaryOp::subtract;
  const Tightness left = sum ? Tightness::sum : Tightness::product;
  const Tightness right = b.op == ast::BinaryOp::subtract ? Tightness::product : left;
  const bool numbers =
      b.op == ast::BinaryOp::multiply && std::holds_alternative<ast::Number>(b.right->node);
  return node("mrow", {at_least(*b.left, left), sign(numbers ? "·" : sign_of(b.op)),
                       at_least(*b.right, right)});
}

Json cases(const ast::Cases& c) {
  Json table = Json::array({"mtable"});
  const auto add = [&](Json value, Json when) {
    table.push_back(node("mtr", {node("mtd", {std::move(value)}), node("mtd", {std::move(when)})}));
  };
  for (const ast::Case& one : c.cases)
    add(of(one.value), node("mrow", {node("mtext", {"if\u00a0"}), of(one.condition)}));
  add(of(*c.otherwise), node("mtext", {"otherwise"}));
  return node("mrow", {sign("{"), table});
}

Json list(const ast::List& l) {
  std::vector<const ast::Expr*> items;
  for (const ast::Expr& item : l.items) items.push_back(&item);
  return in_brackets(separated(items));
}

struct OfExpression {
  Json operator()(const ast::Number& n) const { return node("mn", {fmt::format("{:g}", n.value)}); }
  Json operator()(const ast::Quantity& q) const {
    return node("mrow",
                {at_least(*q.value, Tightness::product), node("mtext", {"\u00a0" + q.unit.text})});
  }
  Json operator()(const ast::String& s) const { return node("mtext", {"“" + s.text + "”"}); }
  Json operator()(const ast::Reference& r) const { return name_of(r.name); }
  Json operator()(const ast::List& l) const { return list(l); }
  Json operator()(const ast::Negate& n) const {
    return node("mrow", {sign("−"), at_least(*n.operand, Tightness::product)});
  }
  Json operator()(const ast::Binary& b) const { return binary(b); }
  Json operator()(const ast::Cases& c) const { return cases(c); }
  Json operator()(const ast::Member& m) const { return member(m); }
  Json operator()(const ast::Prime& p) const { return prime(p); }
  Json operator()(const ast::Call& c) const { return call(c); }
  Json operator()(const ast::Clarke& c) const {
    return node("mrow", {node("msup", {of(*c.law), node("mn", {"0"})}), sign("("), of(*c.at),
                         sign(";"), of(*c.direction), sign(")")});
  }
};
Json of(const ast::Expr& e) { return std::visit(OfExpression{}, e.node); }

Json joined(const std::vector<ast::Condition>& operands, const char* word) {
  Json out = row();
  for (std::size_t i = 0; i < operands.size(); ++i) {
    if (i > 0) out.push_back(node("mtext", {word}));
    out.push_back(of(operands[i]));
  }
  return out;
}
struct OfCondition {
  Json operator()(const ast::Compare& c) const {
    return node("mrow", {of(c.left), sign(sign_of(c.op)), of(c.right)});
  }
  Json operator()(const ast::Inside& i) const {
    return node("mrow", {node("mi", {"x"}), sign("∈"), name_of(i.part.text)});
  }
  Json operator()(const ast::Not& n) const { return node("mrow", {sign("¬"), of(*n.operand)}); }
  Json operator()(const ast::And& a) const { return joined(a.operands, " and "); }
  Json operator()(const ast::Or& o) const { return joined(o.operands, " or "); }
};
Json of(const ast::Condition& c) { return std::visit(OfCondition{}, c.node); }

/// One row: the relation, then the term with its sign.
Json term_row(const ast::FormTerm& term, const char* relation, bool first) {
  Json content = row();
  if (term.minus || !first) content.push_back(sign(term.minus ? "−" : "+"));
  for (const ast::Expr& factor : term.factors)
    content.push_back(at_least(factor, Tightness::product));
  if (term.integral) {
    content.push_back(node("msub", {sign("∫"), name_of(term.integral->domain.text)}));
    content.push_back(at_least(term.integral->integrand, Tightness::product));
  } else {
    content.push_back(node("mn", {"0"}));
  }
  return node("mtr", {node("mtd", {sign(relation)}), node("mtd", {std::move(content)})});
}

Json problem(const ast::Find& find) {
  Json head = row(), tests = row();
  for (const ast::Unknown& one : find.unknowns) {
    head.push_back(node("mrow", {node("mtext", {"find\u00a0"}), name_of(one.unknown.text),
                                 sign("∈"), name_of(one.space.text), node("mtext", {"\u2003"})}));
    tests.push_back(
        node("mrow", {node("mtext", {"for all\u00a0"}), name_of(one.test.text), sign("∈"),
                      name_of(one.test_space.text), node("mtext", {"\u2003"})}));
  }
  Json table = Json::array({"mtable"});
  const auto wide = [&](Json content) {
    table.push_back(node("mtr", {node("mtd", {""}), node("mtd", {std::move(content)})}));
  };
  wide(std::move(head));
  wide(std::move(tests));
  for (std::size_t i = 0; i < find.left.terms.size(); ++i)
    table.push_back(term_row(find.left.terms[i], "", i == 0));
  for (std::size_t i = 0; i < find.right.terms.size(); ++i)
    table.push_back(term_row(find.right.terms[i],
                             i > 0             ? ""
                             : find.inequality ? "≥"
                                               : "=",
                             i == 0));
  return table;
}

Json applied(const Json& name, const std::vector<std::string>& arguments) {
  Json inside = row();
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (i > 0) inside.push_back(sign(","));
    inside.push_back(name_of(arguments[i]));
  }
  return node("mrow", {name, in_brackets(std::move(inside))});
}

std::vector<std::string> texts(const std::vector<ast::Name>& names) {
  std::vector<std::string> out;
  for (const ast::Name& one : names) out.push_back(one.text);
  return out;
}

/// name = value; none for a statement that is shown otherwise.
struct OfDeclaration {
  std::optional<std::pair<const char*, Json>> operator()(const ast::Tensor& t) const {
    return std::pair("tensor", equation(name_of(t.name.text), t.value));
  }
  std::optional<std::pair<const char*, Json>> operator()(const ast::Kernel& k) const {
    return std::pair("kernel",
                     equation(applied(name_of(k.name.text), texts(k.parameters)), k.value));
  }
  std::optional<std::pair<const char*, Json>> operator()(const ast::Superpotential& s) const {
    std::vector<std::string> arguments{s.argument.text};
    for (const auto& parameter : s.parameters) arguments.push_back(parameter.name.text);
    const Json name =
        s.by_slope ? node("mrow", {sign("∂"), name_of(s.name.text)}) : name_of(s.name.text);
    return std::pair(s.by_slope ? "law, by its slope" : "law, by its potential",
                     equation(applied(name, arguments), s.value));
  }
  std::optional<std::pair<const char*, Json>> operator()(const ast::Fn& f) const {
    return std::pair("function",
                     equation(applied(name_of(f.name.text), texts(f.parameters)), f.value));
  }
  std::optional<std::pair<const char*, Json>> operator()(const ast::State& s) const {
    return std::pair("state", equation(node("mover", {name_of(s.name.text), sign("˙")}), s.rate));
  }
  template <class Other>
  std::optional<std::pair<const char*, Json>> operator()(const Other&) const {
    return std::nullopt;
  }

private:
  static Json equation(Json left, const ast::Expr& right) {
    return node("mrow", {std::move(left), sign("="), of(right)});
  }
};

} // namespace

Json mathematics_of(const ast::Expr& expression) { return of(expression); }

Json mathematics_of(const ast::Program& program) {
  Json out{{"find", nullptr}, {"declarations", Json::array()}};
  for (const ast::Statement& statement : program.statements) {
    if (const auto* find = std::get_if<ast::Find>(&statement)) out["find"] = problem(*find);
    if (auto shown = std::visit(OfDeclaration{}, statement))
      out["declarations"].push_back({{"what", shown->first}, {"mathematics", shown->second}});
  }
  return out;
}

} // namespace hvi::lang
