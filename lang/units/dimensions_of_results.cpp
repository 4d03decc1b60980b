// The units of what a script computes, for whoever shows it.
#include "lang/units/dimension_checker.hpp"

#include <fmt/format.h>

#include <charconv>

namespace hvi::lang::units {

/// Empty where the script does not tell: a scalar that nothing but itself is compared with.
std::string DimensionChecker::unit_of(const Dimension& dimension) const {
  const Dimension known = resolved(dimension);
  return known.is_known() ? units_.system.name(known) : "";
}

/// Of a column, or of a component of it: `held_y` of the vector `held`.
std::optional<Dimension> DimensionChecker::of_column(const std::string& name) const {
  auto found = of_column_.find(name);
  const bool component =
      name.size() > 2 && name[name.size() - 2] == '_' && name.back() >= 'x' && name.back() <= 'z';
  if (found == of_column_.end() && component)
    found = of_column_.find(name.substr(0, name.size() - 2));
  return found == of_column_.end() ? std::nullopt : std::optional(found->second);
}

/// Half of u's own form, whichever unknown it is of; where unknowns differ nothing is their sum.
std::optional<Dimension> DimensionChecker::of_energy() const {
  std::optional<Dimension> out;
  for (std::size_t b = 0; b < of_unknown_.size(); ++b) {
    const Dimension own = resolved(force(b) * of_unknown_[b]);
    if (out && *out != own) return std::nullopt;
    out = own;
  }
  return out;
}

/// What stands beside the numbers in files and pictures.
void DimensionChecker::tell_report() {
  solver::ReportSpec& out = model_.report;
  out.unit_of_time = unit_of(duration());
  out.unit_of_length = unit_of(length());
  if (const auto energy = of_energy()) out.unit_of_energy = unit_of(*energy);
  for (solver::Probe& probe : out.probes)
    if (const auto dimension = of_column(probe.name)) probe.unit = unit_of(*dimension);
  const auto tell = [&](solver::FieldSpec& field) {
    const Span& place = model_.origins[static_cast<std::size_t>(field.origin.id)];
    const auto found = of_field_.find({place.file, place.begin});
    if (found != of_field_.end()) field.unit = unit_of(found->second);
  };
  for (auto& item : out.fields)
    for (auto& field : item.fields) tell(field);
  for (auto& line : out.lines)
    for (auto& field : line.fields) tell(field);
  for (auto& picture : out.pictures) tell(picture.field);
}

void DimensionChecker::tell_model() {
  ModelUnits& out = model_.units;
  out.system = units_.system.text();
  const auto tell = [&](std::map<std::string, std::string>& in, const std::string& name,
                        const Dimension& dimension) {
    if (const std::string unit = unit_of(dimension); !unit.empty()) in[name] = unit;
  };
  tell(out.of, "t", duration());
  for (std::size_t b = 0; b < of_unknown_.size(); ++b)
    tell(out.of, find_->unknowns[b].unknown.text, of_unknown_[b]);
  for (const auto& [name, dimension] : of_state_) tell(out.of, name, dimension);
  tell_report();
  for (const auto& probe : model_.report.probes)
    if (!probe.unit.empty()) out.of[probe.name] = probe.unit;
  for (const auto& [name, named] : named_)
    if (std::holds_alternative<ast::Tensor>(*named.statement) && named.value &&
        named.value->dimension)
      tell(out.of_tensors, name, *named.value->dimension);
  for (const auto& [name, dimension] : of_multiplier_) tell(out.of_laws, name, dimension);
  for (const auto& [name, dimension] : of_argument_) tell(out.of_arguments, name, dimension);
  for (const auto& [name, dimension] : of_kernel_) tell(out.of_kernels, name, dimension);
  for (std::size_t b = 0; b < of_test_.size(); ++b)
    tell(out.of_tests, find_->unknowns[b].test.text, of_test_[b]);
  if (const Measured sigma = built_in_name("sigma"); sigma.dimension)
    tell(out.of, "sigma", *sigma.dimension);
  tell_params();
  tell_ladders();
}

/// A parameter is shown in the unit in which it is declared; another value is given in it, too.
void DimensionChecker::tell_params() {
  for (ModelParam& p : model_.params) {
    const auto found = named_.find(p.name);
    if (found == named_.end() || !found->second.value || !found->second.value->dimension) continue;
    const std::string own = unit_of(*found->second.value->dimension);
    p.unit = own == "1" ? "" : own;
    const auto* declared = std::get_if<ast::Param>(found->second.statement);
    const ast::Expr* value = declared ? &declared->value : nullptr;
    if (value != nullptr)
      if (const auto* minus = std::get_if<ast::Negate>(&value->node)) value = &*minus->operand;
    const auto* quantity = value ? std::get_if<ast::Quantity>(&value->node) : nullptr;
    if (quantity == nullptr) continue;
    const UnitFactor factor = units_.system.factor(units_.read.at(quantity->unit.text));
    p.unit = quantity->unit.text;
    p.times = factor.times;
    p.over = factor.over;
    if (declared->range) {
      const auto& bounds = std::get<ast::List>(declared->range->node).items;
      if (bounds.size() != 2) continue;
      const Measured least = this->value(bounds[0], {}), most = this->value(bounds[1], {});
      if (least.number && most.number)
        p.range =
            fmt::format("[{}, {}]", p.as_declared(*least.number), p.as_declared(*most.number));
    }
  }
}

/// Rungs are given to a run as to any other: in the unit of the parameter.
void DimensionChecker::tell_ladders() {
  if (!model_.study) return;
  const auto declare = [&](const std::string& name, std::vector<std::string>& values) {
    for (const ModelParam& p : model_.params) {
      if (p.name != name) continue;
      for (std::string& text : values) {
        double number = 0;
        const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (status == std::errc{} && end == text.data() + text.size())
          text = fmt::format("{}", p.as_declared(number));
      }
    }
  };
  for (StudyLadder& ladder : model_.study->ladders) {
    declare(ladder.parameter, ladder.values);
    for (auto& [name, values] : ladder.more) declare(name, values);
  }
}

void check_units(const std::vector<ast::Program>& programs, const ScriptUnits& units, Model& model,
                 Diagnostics& diagnostics) {
  if (units.used && !programs.empty()) DimensionChecker(programs, units, model, diagnostics).run();
}

} // namespace hvi::lang::units
