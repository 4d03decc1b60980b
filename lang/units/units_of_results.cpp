#include "lang/units/units_of_results.hpp"

#include <fmt/format.h>

#include <charconv>

namespace hvi::lang::units {

/// Empty where the script does not tell: a scalar that nothing but itself is compared with.
std::string UnitsOfResults::unit_of(const Dimension& dimension) const {
  const Dimension known = inference_.resolved(dimension);
  return known.is_known() ? units_.system.name(known) : "";
}

/// Half of u's own form, whichever unknown it is of; where unknowns differ nothing is their sum.
std::optional<Dimension> UnitsOfResults::energy_of_form() const {
  std::optional<Dimension> out;
  for (std::size_t b = 0; b < names_.of_unknown.size(); ++b) {
    const Dimension own = inference_.resolved(names_.force(b) * names_.of_unknown[b]);
    if (out && *out != own) return std::nullopt;
    out = own;
  }
  return out;
}

/// What stands beside the numbers in files and pictures.
void UnitsOfResults::tell_report() {
  solver::ReportSpec& out = model_.report;
  out.unit_of_time = unit_of(duration());
  out.unit_of_length = unit_of(length());
  if (const auto energy = energy_of_form()) out.unit_of_energy = unit_of(*energy);
  for (solver::Probe& probe : out.probes)
    if (const auto dimension = names_.column(probe.name)) probe.unit = unit_of(*dimension);
  const auto tell = [&](solver::FieldSpec& field) {
    const Span& place = model_.origins[static_cast<std::size_t>(field.origin.id)];
    const auto found = names_.of_field.find({place.file, place.begin});
    if (found != names_.of_field.end()) field.unit = unit_of(found->second);
  };
  for (auto& item : out.fields)
    for (auto& field : item.fields) tell(field);
  for (auto& line : out.lines)
    for (auto& field : line.fields) tell(field);
  for (auto& picture : out.pictures) tell(picture.field);
}

void UnitsOfResults::tell_model() {
  ModelUnits& out = model_.units;
  out.system = units_.system.text();
  const auto tell = [&](std::map<std::string, std::string>& in, const std::string& name,
                        const Dimension& dimension) {
    if (const std::string unit = unit_of(dimension); !unit.empty()) in[name] = unit;
  };
  tell(out.of, "t", duration());
  tell(out.of_columns, "t", duration());
  for (std::size_t b = 0; b < names_.of_unknown.size(); ++b)
    tell(out.of, names_.find->unknowns[b].unknown.text, names_.of_unknown[b]);
  for (const auto& [name, dimension] : names_.of_state) tell(out.of, name, dimension);
  tell_report();
  for (const auto& probe : model_.report.probes)
    if (!probe.unit.empty()) out.of_columns[probe.name] = probe.unit;
  for (const auto& [name, named] : names_.declarations)
    if (std::holds_alternative<ast::Tensor>(*named.statement) && named.value &&
        named.value->dimension)
      tell(out.of_tensors, name, *named.value->dimension);
  for (const auto& [name, dimension] : names_.of_multiplier) tell(out.of_laws, name, dimension);
  for (const auto& [name, dimension] : names_.of_argument) tell(out.of_arguments, name, dimension);
  for (const auto& [name, dimension] : names_.of_kernel) tell(out.of_kernels, name, dimension);
  for (std::size_t b = 0; b < names_.of_test.size(); ++b)
    tell(out.of_tests, names_.find->unknowns[b].test.text, names_.of_test[b]);
  if (const auto stress = names_.stress()) tell(out.of, "sigma", *stress);
  tell_params();
  tell_ladders();
}

/// A parameter is shown in the unit in which it is declared; another value is given in it, too.
void UnitsOfResults::tell_params() {
  for (ModelParam& p : model_.params) {
    const MeasuredDeclaration* found = names_.declaration(p.name);
    if (found == nullptr || !found->value || !found->value->dimension) continue;
    const std::string own = unit_of(*found->value->dimension);
    p.unit = own == "1" ? "" : own;
    const auto* declared = std::get_if<ast::Param>(found->statement);
    const ast::Expr* value = declared ? &declared->value : nullptr;
    if (value != nullptr)
      if (const auto* minus = std::get_if<ast::Negate>(&value->node)) value = &*minus->operand;
    const auto* quantity = value ? std::get_if<ast::Quantity>(&value->node) : nullptr;
    if (quantity == nullptr) continue;
    const UnitFactor factor = units_.system.factor(units_.read.at(quantity->unit.text));
    p.unit = quantity->unit.text;
    p.times = factor.times;
    p.over = factor.over;
    if (declared->range) tell_range(p, *declared->range);
  }
}

void UnitsOfResults::tell_range(ModelParam& p, const ast::Expr& range) {
  const auto& bounds = std::get<ast::List>(range.node).items;
  if (bounds.size() != 2) return;
  const Measured least = values_.value(bounds[0], {}), most = values_.value(bounds[1], {});
  if (least.number && most.number)
    p.range = fmt::format("[{}, {}]", p.as_declared(*least.number), p.as_declared(*most.number));
}

/// Rungs are given to a run as to any other: in the unit of the parameter.
void UnitsOfResults::tell_ladders() {
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

} // namespace hvi::lang::units
