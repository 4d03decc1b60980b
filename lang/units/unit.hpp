// The units that a script may write, `[kg/m^3]`, and what they measure.
#pragma once

#include "lang/units/dimension.hpp"

#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace hvi::lang::units {

/// mantissa 10^tens. The ten is kept apart, so that a conversion between decimal units is exact but
/// for one rounding.
struct Scale {
  double mantissa = 1;
  int tens = 0;

  friend Scale operator*(const Scale& a, const Scale& b) {
    return {a.mantissa * b.mantissa, a.tens + b.tens};
  }
  [[nodiscard]] Scale to(const Rational& power) const;
  [[nodiscard]] double value() const;
};

/// What one unit is: a dimension, and how many coherent units of the SI.
struct Unit {
  Dimension dimension;
  Scale scale;
};

/// A unit with a name of its own.
struct NamedUnit {
  std::string_view name;
  std::array<int, n_base> powers; ///< of m, kg, s, K, A, mol, cd
  Scale scale;                    ///< in the SI
  bool prefixes = false;          ///< k, M, m, ... may stand before it
  std::string_view doc;
};

std::span<const NamedUnit> named_units();

struct Prefix {
  std::string_view name;
  int tens = 0;
};
std::span<const Prefix> prefixes();

/// Why a text is no unit.
struct UnitMistake {
  std::string message, help;
};

/// A product of powers as it stands between brackets.
std::variant<Unit, UnitMistake> read_unit(std::string_view text);

} // namespace hvi::lang::units
