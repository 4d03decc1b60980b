// See bounds.hpp. Used where the bodies of laws are read.
#include "lang/check/bounds.hpp"

#include "lang/check/value.hpp"

#include <string>
#include <variant>
#include <vector>

namespace hvi::lang {

namespace {

/// Where a name stands: as the only argument of `norm`, and elsewhere.
class Places {
public:
  explicit Places(const std::string& name) : name_(name) {}

  void look(const ast::Expr& e) {
    std::visit(Overloaded{
                   [&](const ast::Reference& r) { elsewhere = elsewhere || r.name == name_; },
                   [&](const ast::Quantity& q) { look(*q.value); },
                   [&](const ast::List& list) { look_at_all(list.items); },
                   [&](const ast::Negate& n) { look(*n.operand); },
                   [&](const ast::Binary& b) { look(*b.left), look(*b.right); },
                   [&](const ast::Cases& cases) { look(cases); },
                   [&](const ast::Member& m) { look(*m.object); },
                   [&](const ast::Prime& p) { look(*p.operand); },
                   [&](const ast::Call& call) { look(call); },
                   [&](const ast::Clarke& c) { look(*c.at), look(*c.direction); },
                   [](const auto&) {},
               },
               e.node);
  }

  bool in_norm = false, elsewhere = false;

private:
  template <class Item>
  void look_at_all(const std::vector<Item>& items) {
    for (const Item& item : items) look(item);
  }

  void look(const ast::Cases& cases) {
    for (const ast::Case& one : cases.cases) look(one.condition), look(one.value);
    look(*cases.otherwise);
  }

  void look(const ast::Condition& condition) {
    std::visit(Overloaded{
                   [&](const ast::Compare& c) { look(c.left), look(c.right); },
                   [&](const ast::Not& n) { look(*n.operand); },
                   [&](const ast::And& all) { look_at_all(all.operands); },
                   [&](const ast::Or& any) { look_at_all(any.operands); },
                   [](const ast::Inside&) {},
               },
               condition.node);
  }

  void look(const ast::Call& call) {
    const auto* callee = std::get_if<ast::Reference>(&call.callee->node);
    if (callee && callee->name == "norm" && call.arguments.size() == 1) {
      const auto* of = std::get_if<ast::Reference>(&call.arguments[0].value.node);
      if (of && of->name == name_) {
        in_norm = true;
        return;
      }
    }
    for (const ast::Argument& argument : call.arguments) look(argument.value);
  }

  const std::string& name_;
};

} // namespace

bool is_bound(const ast::Superpotential& law) {
  if (!law.by_slope) return false;
  Places places(law.argument.text);
  places.look(law.value);
  return places.in_norm && !places.elsewhere;
}

} // namespace hvi::lang
