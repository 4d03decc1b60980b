#include "lang/units/dimension_mistakes.hpp"

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

/// A number as it is written, without a unit and without a name.
bool is_bare(Side given) {
  const ast::Expr* e = given.place;
  if (const auto* minus = std::get_if<ast::Negate>(&e->node)) e = &*minus->operand;
  return std::holds_alternative<ast::Number>(e->node);
}

} // namespace

DimensionMistakes::DimensionMistakes(const std::vector<ast::Program>& programs,
                                     const System& system, const NamedDimensions& names,
                                     Inference& inference, Diagnostics& diagnostics)
    : system_(system), names_(names), inference_(inference), diagnostics_(diagnostics) {
  for (const ast::Program& program : programs)
    if (program.library) library_.insert(program.file);
}

std::string in_words(const Dimension& dimension) {
  for (const auto& [unit, word] : words)
    if (const auto read = read_unit(unit);
        std::holds_alternative<Unit>(read) && std::get<Unit>(read).dimension == dimension)
      return std::string(word);
  return {};
}

std::string DimensionMistakes::shown(const Dimension& dimension) const {
  const Dimension known = inference_.resolved(dimension);
  if (!known.is_known()) {
    // Linear in a test function, whose own dimension cancels.
    for (std::size_t b = 0; b < names_.of_test.size(); ++b)
      if (const Dimension rest = inference_.resolved(known / names_.of_test[b]); rest.is_known())
        return fmt::format("`[{}]` times `{}`", system_.name(rest),
                           names_.find->unknowns[b].test.text);
    return "a unit not known yet";
  }
  return fmt::format("`[{}]`", system_.name(known));
}

std::string DimensionMistakes::shown_with_words(const Dimension& dimension) const {
  const Dimension known = inference_.resolved(dimension);
  const std::string word = known.is_known() ? in_words(known) : "";
  return word.empty() ? shown(dimension) : fmt::format("{} ({})", shown(dimension), word);
}

/// At the call in the script where the place is in the standard library, which is right.
void DimensionMistakes::report(Diagnostic diagnostic) {
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

std::string DimensionMistakes::help_for_bare(Side given, const Dimension& wanted) const {
  const Dimension known = inference_.resolved(wanted);
  if (!known.is_known() || known.is_one() || !inference_.resolved(*given.value->dimension).is_one())
    return {};
  const std::string unit = system_.name(known);
  if (is_bare(given) && given.value->number)
    return fmt::format("write `{} [{}]`, or another unit of that kind; a bare number has no unit",
                       *given.value->number, unit);
  return fmt::format("numbers without a unit are no quantities: `1 [{}]` times it is one", unit);
}

bool DimensionMistakes::same(Side left, Side right, const std::string& what) {
  if (inference_.unify(*left.value->dimension, *right.value->dimension)) return true;
  const bool bare = inference_.resolved(*left.value->dimension).is_one() ||
                    inference_.resolved(*right.value->dimension).is_one();
  std::string help = help_for_bare(right, *left.value->dimension);
  if (help.empty()) help = help_for_bare(left, *right.value->dimension);
  report(diagnose(bare ? "E0332" : "E0331", right.place->span,
                  fmt::format("{}: {} against {}", what, shown_with_words(*left.value->dimension),
                              shown_with_words(*right.value->dimension)))
             .with_label(fmt::format("this is {}", shown(*right.value->dimension)))
             .with_secondary(left.place->span,
                             fmt::format("this is {}", shown(*left.value->dimension)))
             .with_help(std::move(help)));
  return false;
}

bool DimensionMistakes::wants(Side given, const Dimension& dimension, const std::string& what) {
  if (!given.value->dimension || inference_.unify(*given.value->dimension, dimension)) return true;
  const bool bare = inference_.resolved(*given.value->dimension).is_one();
  report(diagnose(bare ? "E0332" : "E0331", given.place->span,
                  fmt::format("{} is {}, not {}", what, shown_with_words(dimension),
                              shown_with_words(*given.value->dimension)))
             .with_help(help_for_bare(given, dimension)));
  return false;
}

bool DimensionMistakes::wants_number(const ast::Expr& e, const Measured& given,
                                     const std::string& what) {
  if (!given.dimension) return false;
  if (inference_.unify(*given.dimension, Dimension{})) return true;
  report(diagnose("E0331", e.span,
                  fmt::format("{} is a number, not {}", what, shown_with_words(*given.dimension)))
             .with_help(std::holds_alternative<ast::Quantity>(e.node)
                            ? "leave its unit out, or divide it by a quantity of the same kind"
                            : "divide it by a quantity of the same kind"));
  return false;
}

} // namespace hvi::lang::units
