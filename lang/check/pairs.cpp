// Pairs: `part seam = pair(upper.bottom, lower.top)`, and what is known on one: jump(u), mean(u),
// gap(seam).
//
// A jump is kept as the value of a field of its own until it is known where it stands: on a pair it
// becomes the value of the field itself, which there is its jump (solver/plan/problem.hpp). A mean
// is kept as the slot slot::mean of that field.

#include "lang/check/pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::RegionSpec;

using slot::field_of, slot::is_field, slot::is_test;

namespace {

constexpr int first_jump = 128; ///< the jump of field k is field first_jump + k
constexpr int jump_of_test = 252;

solver::Slot without_jump(solver::Slot s) {
  if (field_of(s) == jump_of_test) return slot::test(s - slot::field(jump_of_test, 0));
  return s - first_jump * slot::field_stride;
}

struct Reads {
  bool jumps = false, values = false, gap = false;
};

Reads reads_of(const std::vector<Symbol>& components) {
  Reads out;
  for (const Symbol& component : components)
    for (const solver::Slot s : solver::slots_of(component)) {
      out.gap = out.gap || s == slot::gap;
      if (!is_field(s) && !is_test(s)) continue;
      (is_jump(s) ? out.jumps : out.values) = true;
    }
  return out;
}

void remove_jumps(std::vector<Symbol>& components) {
  for (Symbol& component : components) {
    std::vector<std::pair<solver::Slot, Symbol>> rename;
    for (const solver::Slot s : solver::slots_of(component))
      if (is_jump(s)) rename.emplace_back(s, Symbol::variable(without_jump(s)));
    if (!rename.empty()) component = substitute(component, rename);
  }
}

} // namespace

bool is_jump(solver::Slot s) { return is_field(s) && field_of(s) >= first_jump; }

solver::Slot jump_of(solver::Slot s) {
  if (is_test(s)) return slot::field(jump_of_test, s - slot::test(0));
  return s + first_jump * slot::field_stride;
}

solver::Slot mean_of(solver::Slot s) {
  const int own = is_test(s) ? s - slot::test(0) : slot::derivative_of(s);
  const int component = slot::component_of(own);
  return jump_of(s) + slot::mean(component) - slot::value(component);
}

bool has_jumps(const Symbol& symbol) { return reads_of({symbol}).jumps; }
bool has_jumps_and_values(const Symbol& symbol) {
  const Reads reads = reads_of({symbol});
  return reads.jumps && reads.values;
}
bool has_means(const std::vector<Symbol>& on_pair) {
  return std::ranges::any_of(on_pair, [](const Symbol& component) {
    return std::ranges::any_of(solver::slots_of(component), [](solver::Slot s) {
      return slot::is_field_gradient(s) || (is_test(s) && !slot::is_value(s - slot::test(0)));
    });
  });
}

Symbol without_jumps(const Symbol& symbol) {
  std::vector<Symbol> one{symbol};
  remove_jumps(one);
  return one.front();
}

bool Pairs::is_pair(int part) const {
  return part >= 0 &&
         model_.parts[static_cast<std::size_t>(part)].region.kind == RegionSpec::Kind::pair;
}

bool Pairs::refuse(int part, const Span& span, const std::string& what) {
  if (!is_pair(part)) return false;
  mistakes_.error(
      "E0441", span,
      fmt::format("{} on the pair `{}`", what, model_.parts[static_cast<std::size_t>(part)].name),
      "laws act on a pair; everything else on one of its sides");
  return true;
}

/// However many laws, jumps and gaps stand on it: a part that is no pair is one mistake.
void Pairs::refuse_no_pair(const Span& span, const std::string& what, int part) const {
  const std::string& name = model_.parts[static_cast<std::size_t>(part)].name;
  mistakes_.error_once("no pair: " + name, "E0441", span,
                       fmt::format("{} on `{}`, which is no pair", what, name),
                       "jumps, means of both sides and gaps are known on a pair: `part seam = "
                       "pair(upper.bottom, lower.top)`");
}

bool Pairs::take_jumps(const Span& span, std::vector<Symbol>& components, int part) {
  const Reads reads = reads_of(components);
  const std::string& u = unknowns_.name_of(0);
  if (!is_pair(part)) {
    if (!reads.jumps && !reads.gap) return true;
    if (part >= 0) refuse_no_pair(span, reads.jumps ? "a jump or a mean" : "a gap", part);
    return false;
  }
  const std::string& pair = model_.parts[static_cast<std::size_t>(part)].name;
  if (reads.values) {
    mistakes_.error("E0441", span,
                    fmt::format("on the pair `{}` each side has its own `{}`", pair, u),
                    fmt::format("write `jump({0})`, the first side's minus the second one's, or "
                                "`mean({0})`; a law on one side alone acts on that side",
                                u));
    return false;
  }
  if (reads.gap && at_hand_.gap != part) {
    mistakes_.error("E0441", span, fmt::format("the gap of another pair on `{}`", pair),
                    fmt::format("write `gap({})`", pair));
    return false;
  }
  remove_jumps(components);
  return true;
}

bool Pairs::take_jumps_at_point(const Span& span, Symbol& expression, solver::Probe& probe) {
  const Reads reads = reads_of({expression});
  if (!reads.jumps && !reads.gap) return true;
  if (reads.values) {
    mistakes_.error("E0441", span, "a jump or a mean and a value of one side in one place",
                    "ask for each by itself, and combine the columns");
    return false;
  }
  if (probe.part >= 0) {
    mistakes_.error("E0441", span, "a jump, a mean or a gap is of both sides: `on` names one",
                    "leave out `on` and the name behind it");
    return false;
  }
  probe.on_pair = true;
  probe.part = reads.gap ? at_hand_.gap : -1;
  expression = without_jumps(expression);
  return true;
}

} // namespace hvi::lang
