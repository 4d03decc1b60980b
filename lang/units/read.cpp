// The units that stand in a script, and parameters given with one.
#include "lang/check/builtins.hpp"
#include "lang/units/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace hvi::lang::units {

namespace {

std::optional<Unit> read(const ast::UnitText& written, Diagnostics& diagnostics) {
  auto unit = read_unit(written.text);
  if (const auto* good = std::get_if<Unit>(&unit)) return *good;
  auto& wrong = std::get<UnitMistake>(unit);
  const bool ascii = std::ranges::all_of(written.text, [](unsigned char c) { return c < 0x80; });
  if (!ascii) return std::nullopt; // told by the lexer
  diagnostics.add(
      diagnose("E0330", written.span, std::move(wrong.message)).with_help(std::move(wrong.help)));
  return std::nullopt;
}

std::optional<System> read_system(const ast::Units& statement, Diagnostics& diagnostics) {
  if (statement.units.size() == 1 && statement.units[0].text == "SI") return System{};
  std::vector<Unit> units;
  std::vector<std::string> names;
  for (const ast::UnitText& written : statement.units) {
    const auto unit = read(written, diagnostics);
    if (!unit) return std::nullopt;
    units.push_back(*unit);
    names.push_back(written.text);
  }
  auto system = System::of(units, names);
  if (auto* good = std::get_if<System>(&system)) return std::move(*good);
  const std::size_t at = std::get<std::size_t>(system);
  const bool none = units[at].dimension.is_one();
  diagnostics.add(
      diagnose("E0333", statement.units[at].span,
               none ? fmt::format("`{}` measures nothing: it is a number", names[at])
                    : fmt::format("`{}` follows from the units before it", names[at]))
          .with_help("a system is given by independent units, as `units mm, N, s`: that of "
                     "pressure is MPa then, and that of mass t"));
  return std::nullopt;
}

void find_system(const std::vector<ast::Program>& programs, ScriptUnits& out,
                 Diagnostics& diagnostics) {
  const ast::Units* first = nullptr;
  for (std::size_t p = 0; p < programs.size(); ++p)
    for (const ast::Statement& statement : programs[p].statements) {
      const auto* units = std::get_if<ast::Units>(&statement);
      if (units == nullptr) continue;
      out.used = true;
      if (p > 0 || first != nullptr) {
        Diagnostic twice = diagnose("E0333", units->span,
                                    first != nullptr ? "the system of units is given twice"
                                                     : "the script itself says its system of units")
                               .with_help("a script has one `units` statement; files that it "
                                          "imports are computed in the same units");
        if (first != nullptr) twice.secondary.push_back({first->span, "given here"});
        diagnostics.add(std::move(twice));
        continue;
      }
      first = units;
      if (auto system = read_system(*units, diagnostics)) out.system = std::move(*system);
    }
}

/// Its param statement: the script's own before one of the library.
const ast::Param* find_param(const std::vector<ast::Program>& programs, const std::string& name) {
  const ast::Param* found = nullptr;
  for (const ast::Program& program : programs)
    for (const ast::Statement& statement : program.statements) {
      const auto* param = std::get_if<ast::Param>(&statement);
      if (param == nullptr || param->name.text != name) continue;
      if (!program.library) return param;
      found = found ? found : param;
    }
  return found;
}

const ast::Quantity* declared_quantity(const ast::Param& param) {
  const ast::Expr* value = &param.value;
  if (const auto* minus = std::get_if<ast::Negate>(&value->node)) value = &*minus->operand;
  return std::get_if<ast::Quantity>(&value->node);
}

/// `210[GPa]` or, for a parameter declared in GPa, `210`. False (reported) where that cannot be:
/// the checker then takes what the script says.
bool take_define(const ast::Param& param, std::string& text, ScriptUnits& out,
                 const CheckOptions& options, Diagnostics& diagnostics) {
  const ast::Quantity* declared = declared_quantity(param);
  std::string_view digits = text, unit_text;
  if (const auto open = text.find('['); open != std::string::npos && text.ends_with(']')) {
    unit_text = std::string_view(text).substr(open);
    digits = std::string_view(text).substr(0, open);
    while (digits.ends_with(' ')) digits.remove_suffix(1);
  } else if (declared != nullptr) {
    unit_text = declared->unit.text;
  }
  const auto number = parse_number(digits);
  if (unit_text.empty() || !number) return true; // a word, or what the checker calls no number
  const auto unit = read_unit(unit_text);
  if (const auto* wrong = std::get_if<UnitMistake>(&unit)) {
    if (unit_text.starts_with('['))
      diagnostics.add(diagnose("E0330", param.name.span, wrong->message)
                          .with_label(fmt::format("set by {}{}={}", options.words.define,
                                                  param.name.text, text))
                          .with_help(wrong->help));
    return !unit_text.starts_with('[');
  }
  if (!out.used) {
    diagnostics.add(
        diagnose("E0334", param.name.span,
                 fmt::format("`{}` is set with a unit, and the script has none", param.name.text))
            .with_help(fmt::format("write the number alone: {}{}={}", options.words.define,
                                   param.name.text, digits)));
    return false;
  }
  const Dimension& given = std::get<Unit>(unit).dimension;
  const auto own = declared ? read_unit(declared->unit.text) : unit;
  if (const auto* as = std::get_if<Unit>(&own); as && as->dimension != given) {
    diagnostics.add(diagnose("E0331", declared->unit.span,
                             fmt::format("`{}` is in `[{}]` and set in `{}`", param.name.text,
                                         declared->unit.text, unit_text))
                        .with_label(fmt::format("set by {}{}={}", options.words.define,
                                                param.name.text, text)));
    return false;
  }
  out.of_defines[param.name.text] = given;
  const UnitFactor factor = out.system.factor(std::get<Unit>(unit));
  text = fmt::format("{}", *number * factor.times / factor.over);
  return true;
}

/// Of a number as it is written; zero fits everywhere, and of what is no number the pass behind the
/// checker tells.
std::optional<Dimension> of_literal(const ast::Expr& e, const ScriptUnits& units) {
  if (const auto* minus = std::get_if<ast::Negate>(&e.node))
    return of_literal(*minus->operand, units);
  if (const auto* bare = std::get_if<ast::Number>(&e.node))
    return bare->value == 0 ? std::nullopt : std::optional(Dimension{});
  const auto* quantity = std::get_if<ast::Quantity>(&e.node);
  const auto unit = quantity ? units.read.find(quantity->unit.text) : units.read.end();
  return unit == units.read.end() ? std::nullopt : std::optional(unit->second.dimension);
}

/// Before any value is compared with its range: numbers of two kinds have no order.
void check_range(const ast::Param& param, const ScriptUnits& units, Diagnostics& diagnostics) {
  const auto own = of_literal(param.value, units);
  const auto* range = param.range ? std::get_if<ast::List>(&param.range->node) : nullptr;
  if (!own || range == nullptr) return;
  const auto shown = [&](const Dimension& dimension) {
    const std::string kind = in_words(dimension);
    return fmt::format("`[{}]`{}", units.system.name(dimension),
                       kind.empty() ? "" : fmt::format(" ({})", kind));
  };
  for (const ast::Expr& bound : range->items) {
    const auto of = of_literal(bound, units);
    if (!of || *of == *own) continue;
    diagnostics.add(diagnose(
        of->is_one() ? "E0332" : "E0331", bound.span,
        fmt::format("the range of `{}` is {}, not {}", param.name.text, shown(*own), shown(*of))));
    return;
  }
}

} // namespace

ScriptUnits read_units(const std::vector<ast::Program>& programs, CheckOptions& options,
                       Diagnostics& diagnostics) {
  ScriptUnits out;
  find_system(programs, out, diagnostics);
  for (const ast::Program& program : programs)
    for (const ast::UnitText& written : program.units) {
      out.used = true;
      const auto unit = read(written, diagnostics);
      if (!unit) continue;
      out.read[written.text] = *unit;
      options.units[written.text] = out.system.factor(*unit);
    }
  for (const ast::Program& program : programs)
    for (const ast::Statement& statement : program.statements)
      if (const auto* param = std::get_if<ast::Param>(&statement); param && out.used)
        check_range(*param, out, diagnostics);
  for (auto define = options.defines.begin(); define != options.defines.end();) {
    const ast::Param* param = find_param(programs, define->first);
    const bool taken =
        param == nullptr || take_define(*param, define->second, out, options, diagnostics);
    define = taken ? std::next(define) : options.defines.erase(define);
  }
  return out;
}

} // namespace hvi::lang::units
