// What a law reads of the solution.
#include "lang/check/laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

bool is_read(solver::Slot s) {
  return s >= slot::first_field || (s >= slot::normal(0) && s <= slot::normal(2));
}

/// The expression with the largest parts of it that know the solution, but not what the law acts
/// on or its states, as readings.
class ReadingsTaken {
public:
  explicit ReadingsTaken(std::vector<Symbol>& readings) : readings_(readings) {}

  Symbol operator()(const Symbol& e) {
    const auto slots = e.slots();
    if (std::ranges::none_of(slots, is_read)) return e;
    if (const auto known = taken_.find(e.id()); known != taken_.end()) return known->second;
    const bool acts = e.depends_on_any(slot::argument(0), slot::law_state(slot::most_law_states));
    const Symbol out = acts ? with_readings(e) : reading(e);
    taken_.emplace(e.id(), out);
    return out;
  }

private:
  Symbol with_readings(const Symbol& e) {
    std::vector<Symbol> args;
    for (const Symbol& argument : e.args()) args.push_back((*this)(argument));
    if (e.table()) return Symbol::tabulated(e.table(), args[0], e.op() == solver::Op::table_slope);
    return Symbol::make(e.op(), std::move(args));
  }
  Symbol reading(const Symbol& e) {
    const auto found = std::ranges::find(readings_, e);
    const auto i = static_cast<int>(found - readings_.begin());
    if (found == readings_.end()) readings_.push_back(e);
    return Symbol::variable(slot::reading(std::min(i, slot::most_readings - 1)));
  }

  std::vector<Symbol>& readings_;
  std::map<const void*, Symbol> taken_;
};

} // namespace

bool Laws::take_readings(const std::string& name, const Span& span, const Symbol& body,
                         bool on_pair, solver::LawSpec& spec) {
  const auto is_value = [&](solver::Slot s) { // or, on a pair, a mean
    return !slot::is_field_gradient(s) || (on_pair && slot::may_be_mean(slot::derivative_of(s)));
  };
  spec.expression = ReadingsTaken(spec.readings)(body);
  for (const Symbol& reading : spec.readings)
    for (const solver::Slot s : reading.slots()) {
      if (slot::is_field(s) && slot::field_of(s) == solver::field_of_u(2)) {
        mistakes_.error("E0432", span, fmt::format("`{}` reads `{}''`", name, unknowns_.name_of(0)),
                        "a law reads unknowns, their rates and memories");
        return false;
      }
      if (slot::is_multiplier(s) || (s < slot::first_multiplier && is_value(s))) continue;
      mistakes_.error(
          "E0432", span,
          fmt::format("`{}` reads more of the solution than its values at the point", name),
          fmt::format("values are `{0}.nu`, `norm({0}.tau)`, `{0}.x`, such parts of `{0}'` and "
                      "`history(q, {0})`; gradients are read by loads without a multiplier or a "
                      "state of a boundary",
                      unknowns_.name_of(0)));
      return false;
    }
  if (spec.readings.size() <= slot::most_readings) return true;
  mistakes_.error("E0432", span,
                  fmt::format("`{}` reads {} quantities of the solution, more than {}", name,
                              spec.readings.size(), slot::most_readings),
                  "put what depends on the solution alone into one factor or summand");
  return false;
}

} // namespace hvi::lang
