// How deep and how many expressions may be: functions of functions, and chains of declarations, can
// ask for any number, and recursive functions would exhaust the stack. Reported once.
#pragma once

#include "lang/check/mistakes.hpp"
#include "lang/check/value.hpp"

#include <optional>
#include <utility>
#include <vector>

namespace hvi::lang {

class Limits {
public:
  Limits(const std::vector<ast::Program>& programs, Mistakes& mistakes);

  /// Evaluates one more expression by `evaluate`, which is a level deeper; poison beyond the
  /// limits.
  template <class Evaluate>
  Value of_expression(const Span& span, const Evaluate& evaluate);
  /// The same of a declaration; nothing beyond the limits.
  template <class Evaluate>
  std::optional<Value> of_declaration(const Span& span, const Evaluate& evaluate);
  /// Has something been too deep already? From now on it has.
  bool complained() { return std::exchange(too_deep_, true); }

private:
  bool may_go_deeper(const Span& span, int depth);
  bool may_evaluate(const Span& span);
  bool note_depth(const Span& span, int outer, Value& value);

  Mistakes& mistakes_;
  long evaluations_ = 0;      ///< of expressions
  long most_evaluations_ = 0; ///< more for a long script
  int depth_ = 0;             ///< of expressions and declarations that are being evaluated
  int built_ = 0;             ///< the deepest value made inside the expression at hand
  bool too_deep_ = false;     ///< reported
};

template <class Evaluate>
Value Limits::of_expression(const Span& span, const Evaluate& evaluate) {
  if (!may_evaluate(span) || !may_go_deeper(span, depth_)) return Poison{};
  ++depth_;
  const int outer = std::exchange(built_, 0);
  Value value = evaluate();
  --depth_;
  return note_depth(span, outer, value) ? std::move(value) : Value(Poison{});
}

template <class Evaluate>
std::optional<Value> Limits::of_declaration(const Span& span, const Evaluate& evaluate) {
  if (!may_go_deeper(span, depth_)) return std::nullopt;
  ++depth_;
  Value value = evaluate();
  --depth_;
  return value;
}

} // namespace hvi::lang
