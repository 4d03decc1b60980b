// Coherent systems of units, and names for dimensions in them.
#include "lang/units/system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace hvi::lang::units {

namespace {

constexpr std::array<std::string_view, n_base> base_names = {"m", "kg", "s", "K", "A", "mol", "cd"};

/// Rows of a matrix with that of the identity beside it, reduced as they come.
class Basis {
public:
  /// False where `powers` depends on those before.
  bool add(Powers powers) {
    Powers made_of{};
    made_of[rows_.size()] = 1;
    for (const Row& row : rows_) {
      const Rational times = powers[row.pivot];
      subtract(powers, row.powers, times);
      subtract(made_of, row.made_of, times);
    }
    const auto pivot = std::ranges::find_if(powers, [](const Rational& p) { return !p.is_zero(); });
    if (pivot == powers.end()) return false;
    const auto at = static_cast<std::size_t>(pivot - powers.begin());
    const Rational over = Rational(1) / *pivot;
    for (Rational& p : powers) p = p * over;
    for (Rational& p : made_of) p = p * over;
    for (Row& row : rows_) {
      const Rational times = row.powers[at];
      subtract(row.powers, powers, times);
      subtract(row.made_of, made_of, times);
    }
    rows_.push_back({powers, made_of, at});
    return true;
  }
  /// The base quantities by the rows given, when there are seven.
  std::array<Powers, n_base> inverse() const {
    std::array<Powers, n_base> out{};
    for (const Row& row : rows_) out[row.pivot] = row.made_of;
    return out;
  }

private:
  struct Row {
    Powers powers, made_of;
    std::size_t pivot = 0;
  };
  static void subtract(Powers& from, const Powers& what, const Rational& times) {
    for (std::size_t i = 0; i < n_base; ++i) from[i] = from[i] - what[i] * times;
  }
  std::vector<Row> rows_;
};

bool same(const Scale& a, const Scale& b) {
  const double ratio = a.mantissa / b.mantissa * std::pow(10.0, a.tens - b.tens);
  return std::abs(ratio - 1) < 1e-12;
}

std::string power_text(const std::string& name, const Rational& p) {
  if (p == Rational(1)) return name;
  if (p.below() == 1) return fmt::format("{}^{}", name, p.above());
  return fmt::format("{}^({}/{})", name, p.above(), p.below());
}

} // namespace

std::string product_text(const Product& factors) {
  std::string above, below;
  int n_below = 0;
  for (const auto& [name, power] : factors) {
    if (power.is_zero()) continue;
    const bool down = power.value() < 0;
    std::string& side = down ? below : above;
    side += (side.empty() ? "" : "*") + power_text(name, down ? -power : power);
    n_below += down;
  }
  if (below.empty()) return above.empty() ? "1" : above;
  if (n_below > 1) below = "(" + below + ")";
  return (above.empty() ? "1" : above) + "/" + below;
}

namespace {

double cost(const Product& factors) {
  double out = 0;
  for (const auto& [name, power] : factors) out += std::abs(power.value());
  return out;
}

/// Units beside lengths, times, temperatures and currents, in the order of preference; the second
/// is said where no length is left beside it only: viscosity is Pa*s, a load N/m^3 and not Pa/m.
constexpr std::array<std::pair<std::string_view, bool>, 10> leads = {{{"", false},
                                                                      {"g", false},
                                                                      {"W", false},
                                                                      {"N", false},
                                                                      {"V", false},
                                                                      {"C", false},
                                                                      {"F", false},
                                                                      {"mol", false},
                                                                      {"J", true},
                                                                      {"Pa", true}}};

Powers powers_of(std::string_view name) {
  Powers out{};
  for (const NamedUnit& named : named_units())
    if (named.name == name)
      for (std::size_t i = 0; i < n_base; ++i) out[i] = named.powers[i];
  return out;
}

} // namespace

System::System() : text_("SI") {
  for (std::size_t i = 0; i < n_base; ++i) {
    in_own_[i][i] = 1;
    own_[i] = base_names[i];
  }
}

std::variant<System, std::size_t> System::of(const std::vector<Unit>& units,
                                             const std::vector<std::string>& names) {
  System out;
  out.text_.clear();
  Basis basis;
  std::array<Scale, n_base> scales{};
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (!basis.add(units[i].dimension.powers())) return i;
    scales[i] = units[i].scale;
    out.own_[i] = names[i];
    out.text_ += (i == 0 ? "" : ", ") + names[i];
  }
  std::size_t n = units.size();
  // Masses last: `mm, N, s` and `mm, s` both leave m and s for the units given.
  for (const std::size_t base : {3, 4, 5, 6, 0, 2, 1}) {
    Powers one{};
    one[base] = 1;
    if (n < n_base && basis.add(one)) out.own_[n++] = base_names[base];
  }
  out.in_own_ = basis.inverse();
  for (std::size_t b = 0; b < n_base; ++b)
    for (std::size_t i = 0; i < n_base; ++i)
      out.base_[b] = out.base_[b] * scales[i].to(out.in_own_[b][i]);
  return out;
}

Scale System::scale(const Powers& powers) const {
  Scale out;
  for (std::size_t b = 0; b < n_base; ++b) out = out * base_[b].to(powers[b]);
  return out;
}

UnitFactor System::factor(const Unit& unit) const {
  const Scale own = scale(unit.dimension.powers());
  const int tens = unit.scale.tens - own.tens;
  const double mantissa = unit.scale.mantissa / own.mantissa;
  return {mantissa * (tens > 0 ? std::pow(10.0, tens) : 1.0),
          tens < 0 ? std::pow(10.0, -tens) : 1.0};
}

std::string System::named(const Powers& powers) const {
  const Scale wanted = scale(powers);
  const auto measures = [&](const NamedUnit& unit) {
    return powers_of(unit.name) == powers && unit.name != "Hz" && unit.name != "L";
  };
  for (const NamedUnit& unit : named_units())
    if (measures(unit) && same(unit.scale, wanted)) return std::string(unit.name);
  for (const NamedUnit& unit : named_units()) {
    if (!measures(unit)) continue;
    for (const Prefix& prefix : prefixes()) {
      // Nobody writes hbar for kN/cm^2; cm is the one that people do write.
      const bool usual = unit.name == "m" || (prefix.tens % 3 == 0 && unit.name != "bar");
      const Scale scaled{unit.scale.mantissa, unit.scale.tens + prefix.tens};
      if (unit.prefixes && usual && same(scaled, wanted))
        return std::string(prefix.name) + std::string(unit.name);
    }
  }
  return {};
}

std::string System::name(const Dimension& dimension) const {
  return product_text(product(dimension));
}

Product System::product(const Dimension& dimension) const {
  const Powers& powers = dimension.powers();
  if (dimension.is_one()) return {};
  if (std::string one = named(powers); !one.empty()) return {{std::move(one), 1}};
  Product best;
  for (const auto& [lead, alone] : leads) {
    const Powers of_lead = powers_of(lead);
    // So many of it that no mass is left, or, where it has none, no current or amount.
    std::size_t decides = of_lead[1].is_zero() ? (lead == "mol" ? 5 : 4) : 1;
    if (lead == "V") decides = 4;
    if (lead == "F") decides = 1;
    Product product;
    Powers rest = powers;
    if (!lead.empty()) {
      if (powers[decides].is_zero()) continue;
      const Rational times = powers[decides] / of_lead[decides];
      const std::string text = named(of_lead);
      if (text.empty()) continue;
      product.emplace_back(text, times);
      for (std::size_t i = 0; i < n_base; ++i) rest[i] = rest[i] - of_lead[i] * times;
    }
    if (alone && !rest[0].is_zero()) continue;
    bool all = true;
    for (const std::size_t base : {0, 2, 3, 4, 1, 5, 6}) {
      if (rest[base].is_zero()) continue;
      Powers one{};
      one[base] = 1;
      const std::string text = named(one);
      all = all && !text.empty();
      product.emplace_back(text, rest[base]);
    }
    if (all && (best.empty() || cost(product) < cost(best))) best = std::move(product);
  }
  if (!best.empty()) return best;
  Product by_own; // units that nothing named is coherent with, `units inch, lbf, s`
  for (std::size_t i = 0; i < n_base; ++i) {
    Rational power;
    for (std::size_t b = 0; b < n_base; ++b) power = power + powers[b] * in_own_[b][i];
    by_own.emplace_back(own_[i], power);
  }
  return by_own;
}

} // namespace hvi::lang::units
