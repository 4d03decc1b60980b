#include "lang/check/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Probe;

namespace {

bool is_reference_to(const ast::Expr& e, const std::string& name) {
  const auto* r = std::get_if<ast::Reference>(&e.node);
  return r && r->name == name;
}

} // namespace

/// norm(u) as written: of which unknown; -1: it is something else.
int Tables::norm_of_unknown(const ast::Expr& e) const {
  const auto* call = std::get_if<ast::Call>(&e.node);
  const bool norm = call && is_reference_to(*call->callee, "norm") && call->arguments.size() == 1 &&
                    !call->arguments[0].name;
  if (!norm) return -1;
  const auto* r = std::get_if<ast::Reference>(&call->arguments[0].value.node);
  return r ? unknowns_.named(r->name) : -1;
}

/// A column of a table; false: reported. A vector has a column for each component: `force` gives
/// `force_x`, `force_y`.
bool Tables::binding(const ast::Binding& b, solver::TableSpec& table) {
  Probe p;
  p.name = b.name.text;
  p.origin = model_.origin(b.value.span);
  bool good = true;
  if (b.time) {
    p.time = results_.report_time(*b.time);
    good = p.time.has_value();
  }
  const std::size_t first = model_.report.probes.size();
  if (const int normed = b.point ? -1 : norm_of_unknown(b.value); normed >= 0) {
    p.kind = Probe::Kind::norm_v;
    p.unknown = normed;
    return good && column(b, std::move(p), table);
  }
  at_hand_.gap = -1;
  auto value = column_value(b);
  if (b.point) {
    auto at = evaluator_.constant_list(*b.point, "a point");
    if (!at || !value || !good) return false;
    if (static_cast<int>(at->size()) != model_.dim) {
      mistakes_.error("E0307", b.point->span,
                      fmt::format("a point in {0}D has {0} coordinates", model_.dim));
      return false;
    }
    p.kind = Probe::Kind::at_point;
    p.origin = model_.origin(b.point->span);
    for (int i = 0; i < model_.dim; ++i) p.point[i] = (*at)[i];
    if (!take_side(b, *value, p)) return false;
  } else {
    if (!value || !good) return false;
    if (!has_one_value(b, *value)) return false;
    p.kind = Probe::Kind::combination;
  }
  for (std::size_t i = 0; i < value->components.size(); ++i) {
    Probe of = p;
    of.expression = value->components[i];
    if (b.point && !pairs_.take_jumps_at_point(b.value.span, of.expression, of)) return false;
    if (value->rank == 1) of.name += fmt::format("_{}", "xyz"[i]);
    if (of.kind == Probe::Kind::combination && of.time) take_at_its_time(first, of);
    if (!column(b, std::move(of), table)) return false;
  }
  return true;
}

/// A number, or a vector; at a point, what has a value there.
std::optional<Field> Tables::column_value(const ast::Binding& b) {
  auto value = evaluator_.field(b.value, report_scope());
  if (!value) return value;
  const bool column = value->rank <= 1 && !value->law_vector;
  if (column && !(b.point && std::ranges::any_of(value->components, has_probes))) return value;
  if (column)
    mistakes_.error("E0306", b.value.span,
                    "an integral, an extreme and a reaction are one number, which is at no point",
                    "leave out `at`");
  else
    mistakes_.error("E0306", b.value.span,
                    fmt::format("a column is a scalar or a vector, not {}", describe(*value)));
  return std::nullopt;
}

/// `at [..] on part`: of these cells.
bool Tables::take_side(const ast::Binding& b, const Field& value, Probe& p) {
  if (!b.side) return true;
  const auto part = parts_.index_of(*b.side);
  if (!part) return false;
  const auto kind = model_.parts[static_cast<std::size_t>(*part)].kind;
  if (kind && *kind != solver::Group::Kind::cells) {
    mistakes_.error("E0306", b.side->span, fmt::format("`{}` is no part of cells", b.side->text),
                    "name a piece of the mesh, or a part of its cells: `on upper`");
    return false;
  }
  const auto of_points = [](const Symbol& component) {
    return component.depends_on_any(slot::first_multiplier, slot::first_inside) ||
           component.depends_on_any(slot::first_state, slot::first_probe);
  };
  if (std::ranges::any_of(value.components, of_points)) {
    mistakes_.error("E0306", b.side->span,
                    "a multiplier or a state has its own points, of which `on` does not choose",
                    fmt::format("leave out `on {}`", b.side->text));
    return false;
  }
  p.part = *part;
  return true;
}

/// Is it made of numbers of the report and of t only?
bool Tables::has_one_value(const ast::Binding& b, const Field& value) {
  for (const Symbol& component : value.components)
    for (solver::Slot s : solver::slots_of(component)) {
      if (s >= slot::first_probe || s == slot::t) continue;
      mistakes_.error(
          "E0306", b.value.span, fmt::format("`{}` has a value at every point", b.name.text),
          fmt::format("say where: `{} = ... at [{}]`, or take its integral", b.name.text,
                      model_.dim == 1   ? "0.5"
                      : model_.dim == 2 ? "1, 0"
                                        : "1, 0, 0"));
      return false;
    }
  return true;
}

bool Tables::column(const ast::Binding& b, Probe p, solver::TableSpec& table) {
  if (p.name == "t") {
    mistakes_.error("E0302", b.name.span, "the first column of every table is `t`, the time",
                    "give this one another name");
    return false;
  }
  for (const Probe& known : model_.report.probes)
    if (known.name == p.name) {
      mistakes_.error("E0302", b.name.span, fmt::format("the column `{}` is there twice", p.name));
      return false;
    }
  table.probes.push_back(probes_.add(std::move(p)));
  return true;
}

/// A combination of integrals at a time of its own: its integrals, the probes from `first` on, are
/// taken then, and t is that time.
void Tables::take_at_its_time(std::size_t first, Probe& p) {
  for (std::size_t i = first; i < model_.report.probes.size(); ++i)
    model_.report.probes[i].time = p.time;
  const std::pair<solver::Slot, Symbol> then[] = {{slot::t, Symbol(*p.time)}};
  p.expression = substitute(p.expression, then);
}

void Tables::read(const ast::TableItem& item) {
  solver::TableSpec spec;
  spec.origin = model_.origin(item.span);
  if (item.every)
    if (auto n = evaluator_.positive_integer(*item.every, "`every`")) spec.every = *n;
  spec.from_start = results_.from_start(item.from_start);
  auto file = results_.columns_name(item.to);
  for (const ast::Binding& b : item.columns)
    if (!binding(b, spec) || !file) model_.lost_columns.push_back(b.name.text);
  if (!file) return;
  spec.file = *file;
  model_.report.tables.push_back(std::move(spec));
}

} // namespace hvi::lang
