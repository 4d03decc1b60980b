// What does not fit, with both places and both dimensions.
#include "lang/units/dimension_checker.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace hvi::lang::units {

namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 31> words = {{
    {"1", "a number without a unit"},
    {"m", "a length"},
    {"m^2", "an area"},
    {"m^3", "a volume"},
    {"1/m", "one over a length"},
    {"s", "a time"},
    {"1/s", "one over a time"},
    {"m/s", "a speed"},
    {"m/s^2", "an acceleration"},
    {"kg", "a mass"},
    {"kg/m^3", "a mass per volume"},
    {"N", "a force"},
    {"N/m", "a force per length"},
    {"Pa", "a pressure or stress"},
    {"Pa*m", "a force per length"},
    {"N/m^3", "a force per volume, or a pressure per length"},
    {"J", "an energy or moment"},
    {"W", "a power"},
    {"W/m^2", "a power per area"},
    {"Pa*s", "a viscosity"},
    {"Pa/s", "a stress per time"},
    {"K", "a temperature"},
    {"1/K", "one over a temperature"},
    {"K/m", "a gradient of temperature"},
    {"W/(m*K)", "a conductivity of heat"},
    {"J/(kg*K)", "a capacity of heat per mass"},
    {"A", "an electric current"},
    {"C", "a charge"},
    {"V", "an electric potential"},
    {"V/m", "an electric field"},
    {"mol", "an amount of substance"},
}};

} // namespace

std::string in_words(const Dimension& dimension) {
  for (const auto& [unit, word] : words)
    if (const auto read = read_unit(unit);
        std::holds_alternative<Unit>(read) && std::get<Unit>(read).dimension == dimension)
      return std::string(word);
  return {};
}

std::string DimensionChecker::shown(const Dimension& dimension) const {
  const Dimension known = resolved(dimension);
  if (!known.is_known()) {
    // Linear in a test function, whose own dimension cancels.
    for (std::size_t b = 0; b < of_test_.size(); ++b)
      if (const Dimension rest = resolved(known / of_test_[b]); rest.is_known())
        return fmt::format("`[{}]` times `{}`", units_.system.name(rest),
                           find_->unknowns[b].test.text);
    return "a unit not known yet";
  }
  return fmt::format("`[{}]`", units_.system.name(known));
}

std::string DimensionChecker::shown_with_words(const Dimension& dimension) const {
  const Dimension known = resolved(dimension);
  const std::string word = known.is_known() ? in_words(known) : "";
  return word.empty() ? shown(dimension) : fmt::format("{} ({})", shown(dimension), word);
}

/// At the call in the script where the place is in the standard library, which is right.
void DimensionChecker::report_mistake(Diagnostic diagnostic) {
  if (library_.contains(diagnostic.primary.file)) {
    for (std::size_t i = calls_.size(); i-- > 0;) {
      if (library_.contains(calls_[i].file)) continue;
      diagnostic.secondary = {{diagnostic.primary, "here in the standard library"}};
      diagnostic.primary = calls_[i];
      diagnostic.label.clear();
      break;
    }
  } else if (!calls_.empty()) {
    diagnostic.secondary.push_back({calls_.back(), "called here"});
  }
  diagnostics_.add(std::move(diagnostic));
}

/// A number as it is written, without a unit and without a name.
bool DimensionChecker::is_bare(Side given) const {
  const ast::Expr* e = given.place;
  if (const auto* minus = std::get_if<ast::Negate>(&e->node)) e = &*minus->operand;
  return std::holds_alternative<ast::Number>(e->node);
}

std::string DimensionChecker::help_for_bare(Side given, const Dimension& wanted) const {
  const Dimension known = resolved(wanted);
  if (!known.is_known() || known.is_one() || !resolved(*given.value->dimension).is_one()) return {};
  const std::string unit = units_.system.name(known);
  if (is_bare(given) && given.value->number)
    return fmt::format("write `{} [{}]`, or another unit of that kind; a bare number has no unit",
                       *given.value->number, unit);
  return fmt::format("numbers without a unit are no quantities: `1 [{}]` times it is one", unit);
}

bool DimensionChecker::same(Side left, Side right, const std::string& what) {
  if (inference_.unify(*left.value->dimension, *right.value->dimension)) return true;
  const bool bare =
      resolved(*left.value->dimension).is_one() || resolved(*right.value->dimension).is_one();
  std::string help = help_for_bare(right, *left.value->dimension);
  if (help.empty()) help = help_for_bare(left, *right.value->dimension);
  report_mistake(
      diagnose(bare ? "E0332" : "E0331", right.place->span,
               fmt::format("{}: {} against {}", what, shown_with_words(*left.value->dimension),
                           shown_with_words(*right.value->dimension)))
          .with_label(fmt::format("this is {}", shown(*right.value->dimension)))
          .with_secondary(left.place->span,
                          fmt::format("this is {}", shown(*left.value->dimension)))
          .with_help(std::move(help)));
  return false;
}

bool DimensionChecker::wants(Side given, const Dimension& dimension, const std::string& what) {
  if (!given.value->dimension || inference_.unify(*given.value->dimension, dimension)) return true;
  const bool bare = resolved(*given.value->dimension).is_one();
  report_mistake(diagnose(bare ? "E0332" : "E0331", given.place->span,
                          fmt::format("{} is {}, not {}", what, shown_with_words(dimension),
                                      shown_with_words(*given.value->dimension)))
                     .with_help(help_for_bare(given, dimension)));
  return false;
}

/// A value, or each of a list of them.
bool DimensionChecker::wants_each(const ast::Expr& e, const Dimension& dimension,
                                  const std::string& what) {
  const auto* list = std::get_if<ast::List>(&e.node);
  if (list == nullptr) {
    const Measured given = value(e, {});
    return wants({&given, &e}, dimension, what);
  }
  for (const ast::Expr& item : list->items)
    if (!wants_each(item, dimension, what)) return false;
  return true;
}

bool DimensionChecker::wants_number(const ast::Expr& e, const Measured& given,
                                    const std::string& what) {
  if (!given.dimension) return false;
  if (inference_.unify(*given.dimension, Dimension{})) return true;
  report_mistake(
      diagnose("E0331", e.span,
               fmt::format("{} is a number, not {}", what, shown_with_words(*given.dimension)))
          .with_help("divide it by a quantity of the same kind"));
  return false;
}

} // namespace hvi::lang::units
