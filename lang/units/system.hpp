// The units that a script is computed in: coherent, so that no factor stands in any formula.
#pragma once

#include "lang/check/check.hpp"
#include "lang/units/unit.hpp"

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace hvi::lang::units {

using Product = std::vector<std::pair<std::string, Rational>>;
/// "N*s/m^2"
std::string product_text(const Product& factors);

class System {
public:
  System(); ///< the SI
  /// By independent units, `mm, N, s`; what they do not measure is in that of the SI. Or the index
  /// of the first unit that those before it give already.
  static std::variant<System, std::size_t> of(const std::vector<Unit>& units,
                                              const std::vector<std::string>& names);

  /// One unit in coherent ones of its dimension.
  [[nodiscard]] UnitFactor factor(const Unit& unit) const;
  /// The coherent unit of a dimension, as short as names allow: "MPa", "N/m^3", "1".
  [[nodiscard]] std::string name(const Dimension& dimension) const;
  /// Its factors; none of a number.
  [[nodiscard]] Product product(const Dimension& dimension) const;
  /// "SI"; "mm, N, s".
  [[nodiscard]] const std::string& text() const { return text_; }

private:
  [[nodiscard]] Scale scale(const Powers& powers) const;
  /// A unit with a name that is coherent here, with a prefix or without.
  [[nodiscard]] std::string named(const Powers& powers) const;

  std::array<Scale, n_base> base_{};    ///< of the coherent units of m, kg, s, ..., in the SI
  std::array<Powers, n_base> in_own_{}; ///< m, kg, s, ... by the units that the system is given by
  std::array<std::string, n_base> own_;
  std::string text_;
};

} // namespace hvi::lang::units
