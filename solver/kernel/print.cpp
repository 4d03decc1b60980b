// Expressions in the language's notation. Written with an explicit stack of things still to print,
// so that long sums do not recurse; text beyond a bound is cut, since a shared graph can be
// exponentially long when written out.
#include "solver/kernel/node.hpp"
#include "solver/kernel/table.hpp"

#include <fmt/format.h>

#include <string_view>

namespace hvi::solver {

namespace {

constexpr std::size_t longest_text = 1U << 20U;

/// Strength of binding; an operand weaker than its place asks for gets parentheses.
enum Level {
  cases,
  disjunction,
  conjunction,
  negated,
  compared,
  sum,
  product,
  unary,
  power,
  primary
};

struct Item {
  std::string text;           ///< printed as it is when `expr` is null
  const Expr* expr = nullptr; ///< else this, at least as strong as `level`
  Level level = cases;
  bool condition = false; ///< where the grammar wants a condition, not a value
  bool negative = false;  ///< print -expr
};

std::string derivative_name(const std::string& base, int derivative) {
  if (const int b = slot::unknown_of(derivative); b > 0)
    return derivative_name(fmt::format("{}.unknown[{}]", base, b),
                           derivative % slot::own_derivatives);
  if (slot::is_value(derivative)) return fmt::format("{}[{}]", base, derivative);
  return fmt::format("grad({})[{}, {}]", base, (derivative - 3) / 3, (derivative - 3) % 3);
}

std::string slot_name(Slot s) {
  if (s == slot::gap) return "gap";
  if (s < 0) return fmt::format("slot[{}]", s);
  if (s < 3) return std::string(1, "xyz"[s]);
  if (s == slot::t) return "t";
  if (s == slot::lag) return "lag";
  if (s < slot::argument(0)) return fmt::format("nu[{}]", s - slot::normal(0));
  if (s == slot::argument(0)) return "r";
  if (s < slot::argument(3)) return fmt::format("arg[{}]", s - slot::argument(0));
  if (s == slot::coupled) return fmt::format("slot[{}]", s);
  if (s < slot::test(0)) return fmt::format("state[{}]", s - slot::law_state(0));
  if (s >= slot::reading(0) && s < slot::reading(slot::most_readings))
    return fmt::format("read[{}]", s - slot::reading(0));
  if (s < slot::first_field) return derivative_name("v", s - slot::test(0));
  if (slot::is_state(s)) return fmt::format("state[{}]", s - slot::first_state);
  if (s >= slot::first_probe) return fmt::format("probe[{}]", s - slot::first_probe);
  if (s >= slot::first_multiplier)
    return fmt::format("xi[{}][{}]", slot::term_of(s), slot::row_of(s));
  return derivative_name(fmt::format("field[{}]", slot::field_of(s)), slot::derivative_of(s));
}

/// Does the text of e begin with a minus sign that a sum may absorb?
bool is_negative(const Expr& e) {
  if (e.is_constant()) return e.value() < 0.0;
  if (e.op() == Op::neg) return true;
  return (e.op() == Op::mul || e.op() == Op::div) && e.args()[0].is_constant() &&
         e.args()[0].value() < 0.0;
}

Level level_of(const Expr& e) {
  switch (e.op()) {
  case Op::constant:
    return e.value() < 0.0 ? unary : primary;
  case Op::add:
    return sum;
  case Op::mul:
  case Op::div:
    return product;
  case Op::neg:
    return e.args()[0].op() == Op::mul || e.args()[0].op() == Op::div ? product : unary;
  case Op::pow:
    return power;
  case Op::less:
  case Op::less_equal:
  case Op::equal:
    return compared;
  case Op::logic_not:
    return e.args()[0].op() == Op::equal ? compared : negated;
  case Op::logic_and:
    return conjunction;
  case Op::logic_or:
    return disjunction;
  case Op::select:
    return cases;
  default:
    return primary;
  }
}

class Printer {
public:
  std::string print(const Expr& root) {
    todo_.push_back({.text = {}, .expr = &root, .condition = is_condition(root)});
    while (!todo_.empty() && text_.size() < longest_text) {
      const Item item = std::move(todo_.back());
      todo_.pop_back();
      if (item.expr) {
        write(item);
        flush();
      } else {
        text_ += item.text;
      }
    }
    if (!todo_.empty()) text_ += " ...";
    return std::move(text_);
  }

private:
  static bool is_condition(const Expr& e) { return is_boolean(e) && !e.is_constant(); }

  void say(std::string text) { next_.push_back({.text = std::move(text)}); }
  void say(const Expr& e, Level level, bool condition = false, bool negative = false) {
    next_.push_back({{}, &e, level, condition, negative});
  }
  /// What was said is printed before what was already waiting.
  void flush() {
    for (; !next_.empty(); next_.pop_back()) todo_.push_back(std::move(next_.back()));
  }

  void write(const Item& item) {
    const Expr& e = *item.expr;
    if (item.negative) return write_opposite(e, item.level);
    if (item.condition && !is_condition(e)) { // a number as a condition
      say(e, sum);
      return say(" != 0");
    }
    if (!item.condition && is_condition(e)) { // a condition as a number
      say(item.level > cases ? "(| " : "| ");
      say(e, disjunction, true);
      return say(item.level > cases ? " -> 1 | otherwise -> 0)" : " -> 1 | otherwise -> 0");
    }
    const bool parentheses = level_of(e) < item.level;
    if (parentheses) say("(");
    write_bare(e);
    if (parentheses) say(")");
  }

  /// -e for an e that is_negative.
  void write_opposite(const Expr& e, Level level) {
    if (e.is_constant()) return say(fmt::format("{}", -e.value()));
    if (e.op() == Op::neg) return say(e.args()[0], level);
    if (!e.args()[0].is(-1.0) || e.op() == Op::div) {
      say(e.args()[0], product, false, true);
      say(e.op() == Op::mul ? " * " : " / ");
    }
    say(e.args()[1], e.op() == Op::mul ? product : unary);
  }

  void write_bare(const Expr& e) {
    const auto& a = e.args();
    switch (e.op()) {
    case Op::constant:
      return say(fmt::format("{}", e.value()));
    case Op::slot:
      return say(slot_name(e.slot()));
    case Op::add:
      return write_sum(a[0], a[1]);
    case Op::mul: // c * (x * y) needs no parentheses
      return infix(a[0], product, " * ", a[1], a[0].is_constant() ? product : unary);
    case Op::div:
      return infix(a[0], product, " / ", a[1], unary);
    case Op::neg:
      say("-");
      return say(a[0], level_of(a[0]) == product ? product : power);
    case Op::pow:
      return infix(a[0], primary, "^", a[1], unary);
    case Op::less:
      return infix(a[0], sum, " < ", a[1], sum);
    case Op::less_equal:
      return infix(a[0], sum, " <= ", a[1], sum);
    case Op::equal:
      return infix(a[0], sum, " == ", a[1], sum);
    case Op::logic_and:
      return infix(a[0], conjunction, " and ", a[1], negated, true);
    case Op::logic_or:
      return infix(a[0], disjunction, " or ", a[1], conjunction, true);
    case Op::logic_not:
      return write_not(a[0]);
    case Op::select:
      return write_cases(e);
    default:
      return write_call(e);
    }
  }

  void infix(const Expr& a, Level left, const char* sign, const Expr& b, Level right,
             bool conditions = false) {
    say(a, left, conditions);
    say(sign);
    say(b, right, conditions);
  }

  void write_sum(const Expr& a, const Expr& b) {
    if (is_negative(a) && !is_negative(b)) { // -a + b reads better as b - a
      say(b, sum);
      say(" - ");
      return say(a, product, false, true);
    }
    say(a, sum);
    if (!is_negative(b)) {
      say(" + ");
      return say(b, product);
    }
    say(" - ");
    say(b, product, false, true);
  }

  void write_not(const Expr& a) {
    if (a.op() == Op::equal) return infix(a.args()[0], sum, " != ", a.args()[1], sum);
    say("not ");
    say(a, negated, true);
  }

  /// `| c -> a | otherwise -> b`; cases in the last branch continue the list.
  void write_cases(const Expr& e) {
    const Expr* at = &e;
    for (; at->op() == Op::select; at = &at->args()[2]) {
      say(at == &e ? "| " : " | ");
      say(at->args()[0], disjunction, true);
      say(" -> ");
      say(at->args()[1], sum);
    }
    say(" | otherwise -> ");
    say(*at, sum);
  }

  void write_call(const Expr& e) {
    if (e.op() == Op::table)
      say(e.table()->name());
    else if (e.op() == Op::table_slope)
      say(e.table()->name() + "'");
    else
      say(std::string(op_name(e.op())));
    const char* before = "(";
    const bool scaled_error = e.op() == Op::erfcx && e.args()[0].is(0.0); // as scripts write it
    for (const Expr& arg : e.args().subspan(scaled_error ? 1 : 0)) {
      say(before);
      say(arg, sum);
      before = ", ";
    }
    say(")");
  }

  std::string text_;
  std::vector<Item> todo_, next_;
};

} // namespace

std::string to_string(const Expr& expr) { return Printer().print(expr); }

} // namespace hvi::solver
