// The table of units, and reading products of them.
#include "lang/units/unit.hpp"

#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

namespace hvi::lang::units {

namespace {

//                                  m  kg   s   K  A mol cd
constexpr std::array table = {
    NamedUnit{"m", {1, 0, 0, 0, 0, 0, 0}, {}, true, "length"},
    NamedUnit{"g", {0, 1, 0, 0, 0, 0, 0}, {1, -3}, true, "mass; kg is the unit of the SI"},
    NamedUnit{"s", {0, 0, 1, 0, 0, 0, 0}, {}, true, "time"},
    NamedUnit{"K", {0, 0, 0, 1, 0, 0, 0}, {}, true, "temperature, or a difference of two"},
    NamedUnit{"A", {0, 0, 0, 0, 1, 0, 0}, {}, true, "electric current"},
    NamedUnit{"mol", {0, 0, 0, 0, 0, 1, 0}, {}, true, "amount of substance"},
    NamedUnit{"cd", {0, 0, 0, 0, 0, 0, 1}, {}, true, "luminous intensity"},
    NamedUnit{"N", {1, 1, -2, 0, 0, 0, 0}, {}, true, "newton: force"},
    NamedUnit{"Pa", {-1, 1, -2, 0, 0, 0, 0}, {}, true, "pascal: pressure, stress, modulus"},
    NamedUnit{"J", {2, 1, -2, 0, 0, 0, 0}, {}, true, "joule: energy"},
    NamedUnit{"W", {2, 1, -3, 0, 0, 0, 0}, {}, true, "watt: power"},
    NamedUnit{"Hz", {0, 0, -1, 0, 0, 0, 0}, {}, true, "hertz: 1/s"},
    NamedUnit{"C", {0, 0, 1, 0, 1, 0, 0}, {}, true, "coulomb: charge"},
    NamedUnit{"V", {2, 1, -3, 0, -1, 0, 0}, {}, true, "volt: electric potential"},
    NamedUnit{"F", {-2, -1, 4, 0, 2, 0, 0}, {}, true, "farad: capacity"},
    NamedUnit{"Ohm", {2, 1, -3, 0, -2, 0, 0}, {}, true, "ohm: resistance"},
    NamedUnit{"S", {-2, -1, 3, 0, 2, 0, 0}, {}, true, "siemens: conductance"},
    NamedUnit{"Wb", {2, 1, -2, 0, -1, 0, 0}, {}, true, "weber: magnetic flux"},
    NamedUnit{"T", {0, 1, -2, 0, -1, 0, 0}, {}, true, "tesla: magnetic flux density"},
    NamedUnit{"H", {2, 1, -2, 0, -2, 0, 0}, {}, true, "henry: inductance"},
    NamedUnit{"L", {3, 0, 0, 0, 0, 0, 0}, {1, -3}, true, "litre"},
    NamedUnit{"t", {0, 1, 0, 0, 0, 0, 0}, {1, 3}, false, "tonne: 1000 kg"},
    NamedUnit{"bar", {-1, 1, -2, 0, 0, 0, 0}, {1, 5}, true, "100 kPa"},
    NamedUnit{"atm", {-1, 1, -2, 0, 0, 0, 0}, {101325, 0}, false, "standard atmosphere"},
    NamedUnit{"eV", {2, 1, -2, 0, 0, 0, 0}, {1.602176634, -19}, true, "electronvolt"},
    NamedUnit{"kgf", {1, 1, -2, 0, 0, 0, 0}, {9.80665, 0}, false, "kilogram-force"},
    NamedUnit{"min", {0, 0, 1, 0, 0, 0, 0}, {60, 0}, false, "minute"},
    NamedUnit{"h", {0, 0, 1, 0, 0, 0, 0}, {3600, 0}, false, "hour"},
    NamedUnit{"day", {0, 0, 1, 0, 0, 0, 0}, {86400, 0}, false, "day of 24 h"},
    NamedUnit{"year", {0, 0, 1, 0, 0, 0, 0}, {31557600, 0}, false, "year of 365.25 days"},
    NamedUnit{"rad", {0, 0, 0, 0, 0, 0, 0}, {}, true, "radian: 1"},
    NamedUnit{"deg", {0, 0, 0, 0, 0, 0, 0}, {std::numbers::pi / 180, 0}, false, "degree: pi/180"},
    NamedUnit{"percent", {0, 0, 0, 0, 0, 0, 0}, {1, -2}, false, "1/100"},
    NamedUnit{"inch", {1, 0, 0, 0, 0, 0, 0}, {2.54, -2}, false, "0.0254 m"},
    NamedUnit{"ft", {1, 0, 0, 0, 0, 0, 0}, {3.048, -1}, false, "foot: 0.3048 m"},
    NamedUnit{"lb", {0, 1, 0, 0, 0, 0, 0}, {4.5359237, -1}, false, "pound: 0.45359237 kg"},
    NamedUnit{"lbf", {1, 1, -2, 0, 0, 0, 0}, {4.4482216152605, 0}, false, "pound-force"},
    NamedUnit{"psi", {-1, 1, -2, 0, 0, 0, 0}, {6.894757293168361, 3}, false, "lbf/inch^2"},
    NamedUnit{"ksi", {-1, 1, -2, 0, 0, 0, 0}, {6.894757293168361, 6}, false, "1000 psi"},
};

constexpr std::array prefix_table = {
    Prefix{"f", -15}, Prefix{"p", -12}, Prefix{"n", -9}, Prefix{"u", -6},
    Prefix{"m", -3},  Prefix{"c", -2},  Prefix{"d", -1}, Prefix{"h", 2},
    Prefix{"k", 3},   Prefix{"M", 6},   Prefix{"G", 9},  Prefix{"T", 12},
};

Unit unit_of(const NamedUnit& named, int tens) {
  Powers powers;
  for (std::size_t i = 0; i < n_base; ++i) powers[i] = named.powers[i];
  return {Dimension(powers), {named.scale.mantissa, named.scale.tens + tens}};
}

std::optional<Unit> find_unit(std::string_view name) {
  for (const NamedUnit& named : table)
    if (named.name == name) return unit_of(named, 0);
  for (const Prefix& prefix : prefix_table)
    for (const NamedUnit& named : table)
      if (named.prefixes && name.starts_with(prefix.name) &&
          name.substr(prefix.name.size()) == named.name)
        return unit_of(named, prefix.tens);
  return std::nullopt;
}

UnitMistake unknown_unit(std::string_view name) {
  const std::string text(name);
  if (text == "degC" || text == "degF" || text == "Celsius")
    return {
        fmt::format("`{}` does not begin at zero, so it is no unit to multiply by", text),
        "write temperatures and their differences in `K`: 20 degrees Celsius are 293.15 [K], and "
        "a rise by 20 of them is 20 [K]"};
  if (text == "SI") return {"`SI` is a system, no unit", "it stands alone: `units SI`"};
  Suggestion suggestion(name);
  for (const NamedUnit& named : table) {
    suggestion.consider(named.name);
    if (!named.prefixes) continue;
    for (const Prefix& prefix : prefix_table)
      suggestion.consider(std::string(prefix.name) + std::string(named.name));
  }
  std::string help = suggestion.help();
  for (std::size_t i = 1; i < name.size(); ++i) // `Nm`, `kWh`: both halves are units
    if (find_unit(name.substr(0, i)) && find_unit(name.substr(i))) {
      help = fmt::format("products are written `{}*{}`", name.substr(0, i), name.substr(i));
      break;
    }
  const bool power = name.size() > 1 && name.back() >= '2' && name.back() <= '9' &&
                     find_unit(name.substr(0, name.size() - 1));
  if (power)
    help = fmt::format("powers are written `{}^{}`", name.substr(0, name.size() - 1), name.back());
  return {fmt::format("unknown unit `{}`", text),
          help.empty() ? "units are m, kg, s, K, A, mol, N, Pa, J, W, V, ... with prefixes: see "
                         "docs/language.md"
                       : help};
}

/// Recursive descent over the text; the parser of scripts has seen to the brackets.
class Reader {
public:
  explicit Reader(std::string_view text) : text_(text) {}

  std::variant<Unit, UnitMistake> read() {
    const Unit out = product();
    skip_blanks();
    if (!mistake_ && at_ < text_.size())
      mistake_ = UnitMistake{fmt::format("`{}` is no unit", text_),
                             "units are written like `MPa`, `kg/m^3`, `1/s`, `N*m`"};
    if (mistake_) return *mistake_;
    return out;
  }

private:
  void skip_blanks() {
    while (at_ < text_.size() &&
           (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
      ++at_;
  }
  bool accept(char c) {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  std::string_view word() {
    skip_blanks();
    const std::size_t begin = at_;
    const auto belongs = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             c == '_' || c == '.';
    };
    while (at_ < text_.size() && belongs(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  Rational whole() {
    const bool minus = accept('-');
    const std::string_view digits = word();
    int value = 0;
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (status != std::errc{} || end != digits.data() + digits.size() || value > 12)
      mistake_ = UnitMistake{fmt::format("`{}` is no power of a unit", digits),
                             "powers are whole numbers, `m^2`, or fractions of them, `m^(1/2)`"};
    return minus ? -value : value;
  }
  Rational exponent() {
    const bool grouped = accept('(');
    Rational out = whole();
    if (grouped && accept('/')) {
      const Rational below = whole();
      if (below.is_zero())
        mistake_ = UnitMistake{"a power of a unit divides by zero", ""};
      else
        out = out / below;
    }
    if (grouped) accept(')');
    return out;
  }
  Unit power() {
    Unit out;
    if (accept('(')) {
      out = product();
      accept(')');
    } else if (const std::string_view name = word(); name != "1") {
      const bool number = !name.empty() && name.front() >= '0' && name.front() <= '9';
      if (number)
        mistake_ = UnitMistake{fmt::format("`{}` is no unit: units have no numbers but 1", name),
                               "numbers stand before the bracket: `100 [mm]`"};
      else if (const auto found = find_unit(name))
        out = *found;
      else
        mistake_ = unknown_unit(name);
    }
    if (!mistake_ && accept('^')) {
      const Rational p = exponent();
      out = {out.dimension.to(p), out.scale.to(p)};
    }
    return out;
  }
  Unit product() {
    Unit out = power();
    while (!mistake_) {
      const bool times = accept('*');
      if (!times && !accept('/')) break;
      Unit next = power();
      if (!times) next = {next.dimension.to(-1), next.scale.to(-1)};
      out = {out.dimension * next.dimension, out.scale * next.scale};
    }
    return out;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::optional<UnitMistake> mistake_;
};

} // namespace

Scale Scale::to(const Rational& power) const {
  const Rational shifted = Rational(tens) * power;
  const double by_hand = mantissa == 1 ? 1 : std::pow(mantissa, power.value());
  if (shifted.below() == 1) return {by_hand, static_cast<int>(shifted.above())};
  return {by_hand * std::pow(10.0, shifted.value()), 0};
}

double Scale::value() const {
  return tens < 0 ? mantissa / std::pow(10.0, -tens) : mantissa * std::pow(10.0, tens);
}

std::span<const NamedUnit> named_units() { return table; }

std::span<const Prefix> prefixes() { return prefix_table; }

std::variant<Unit, UnitMistake> read_unit(std::string_view text) {
  if (text.starts_with('[') && text.ends_with(']')) text = text.substr(1, text.size() - 2);
  return Reader(text).read();
}

} // namespace hvi::lang::units
