#include "lang/check/limits.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang {

Limits::Limits(const std::vector<ast::Program>& programs, Mistakes& mistakes)
    : mistakes_(mistakes) {
  // A script evaluates about one expression for three of its characters; a hundred times that is
  // enough for any use of functions, and soon reached by functions that double at each call.
  std::size_t size = 0;
  for (const ast::Program& program : programs) size += program.size;
  most_evaluations_ = static_cast<long>(std::min<std::size_t>(20'000 + 30 * size, 1'000'000));
}

bool Limits::may_evaluate(const Span& span) {
  if (evaluations_ >= most_evaluations_) return false;
  if (++evaluations_ != most_evaluations_ || too_deep_) return true;
  mistakes_.error("E0607", span,
                  fmt::format("more than {} expressions are evaluated", most_evaluations_),
                  "functions that call each other several times multiply: give results a name");
  return false;
}

/// The depth of the value, which was made inside an expression with values as deep as `outer`.
bool Limits::note_depth(const Span& span, int outer, Value& value) {
  auto* f = std::get_if<Field>(&value);
  if (f == nullptr) {
    built_ = outer;
    return true;
  }
  f->depth = std::max(f->depth, built_ + 1);
  if (f->depth > 1000 && is_constant(*f)) f->depth = 0; // folded: nothing is left of it
  built_ = std::max(outer, f->depth);
  return may_go_deeper(span, f->depth);
}

/// False (reported once) for what is so deep that recursive functions would exhaust the stack:
/// chains of declarations, and functions of functions, which build deep expressions from shallow
/// ones.
bool Limits::may_go_deeper(const Span& span, int depth) {
  constexpr int deepest = 2000;
  if (depth < deepest) return true;
  if (!complained())
    mistakes_.error(
        "E0216", span,
        fmt::format("more than {} names and operations lead from one to the next", deepest),
        "shorten the chain of names or functions that leads here");
  return false;
}

} // namespace hvi::lang
