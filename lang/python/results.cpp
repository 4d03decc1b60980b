// See results.hpp.
#include "lang/python/results.hpp"

#include "lang/diag/render.hpp"
#include "lang/python/fields.hpp"
#include "solver/results/report.hpp"
#include "solver/results/result_json.hpp"

#include <algorithm>
#include <variant>

namespace hvi::python {

namespace {

using Json = nlohmann::ordered_json;

Array column(const std::string& name, const std::vector<double>& values) {
  return {name, {static_cast<std::int64_t>(values.size())}, values};
}

void add_table(const solver::RunResult& result, Answer& answer) {
  answer.table.push_back(column("t", result.times));
  for (const std::string& name : result.column_order)
    answer.table.push_back(column(name, result.columns.at(name)));
  if (solver::shows_events(result))
    answer.table.push_back(
        column(solver::event_column, {result.events.begin(), result.events.end()}));
}

} // namespace

Json description_of(const lang::Script& script) {
  const lang::Model& model = *script.model;
  Json params = Json::array();
  for (const lang::ModelParam& p : model.params) {
    Json one = {{"name", p.name}, {"range", p.range}, {"doc", p.doc}};
    if (const auto* number = std::get_if<double>(&p.value))
      one["value"] = p.as_declared(*number);
    else
      one["value"] = std::get<std::string>(p.value);
    if (!p.unit.empty()) one["unit"] = p.unit;
    params.push_back(std::move(one));
  }
  Json columns = Json::array();
  for (const auto& table : model.report.tables)
    for (const int probe : table.probes)
      columns.push_back(model.report.probes[static_cast<std::size_t>(probe)].name);
  Json study = Json::array();
  if (model.study)
    for (const lang::StudyLadder& ladder : model.study->ladders)
      study.push_back({{"parameter", ladder.parameter}, {"values", ladder.values}});
  return {{"title", model.title},
          {"dim", model.dim},
          {"params", params},
          {"unknowns", model.unknowns},
          {"columns", columns},
          {"study", study},
          {"units", lang::units_told(script)}};
}

void keep(const solver::Space& space, double t, const solver::Vector& u, Answer& answer) {
  answer.kept_times.push_back(t);
  auto now = unknowns_of(space, u);
  if (answer.kept.empty())
    for (const Array& one : now) {
      answer.kept.push_back({one.name, {0}, {}});
      answer.kept.back().shape.insert(answer.kept.back().shape.end(), one.shape.begin(),
                                      one.shape.end());
    }
  for (std::size_t i = 0; i < now.size(); ++i) {
    auto& values = answer.kept[i].values;
    values.insert(values.end(), now[i].values.begin(), now[i].values.end());
    ++answer.kept[i].shape.front();
  }
}

void add_results(const lang::Session& session, const solver::Discretisation& discretisation,
                 std::size_t own_pictures, Answer& answer) {
  const solver::RunResult& result = session.result;
  if (result.steps == 0) return; // it failed before the first step
  answer.data =
      solver::result_json(result, session.script.plan->problem, lang::json_context(session.script));
  add_table(result, answer);
  if (result.monitors) {
    answer.monitors.push_back(column("t", result.monitors->times));
    for (std::size_t c = 0; c < result.monitors->names.size(); ++c)
      answer.monitors.push_back(column(result.monitors->names[c], result.monitors->columns[c]));
  }
  answer.grid = grid_of(discretisation.space);
  answer.fields = unknowns_of(discretisation.space, result.u);
  for (Array& field : shown_fields(*session.script.plan, own_pictures, result)) {
    const auto same = [&](const Array& other) { return other.name == field.name; };
    if (std::ranges::none_of(answer.fields, same)) answer.fields.push_back(std::move(field));
  }
}

void add_diagnostics(const lang::Session& session, Answer& answer) {
  const lang::Script& script = session.script;
  answer.diagnostics = lang::render_json(script.diagnostics, script.sources);
  answer.text = lang::render(script.diagnostics, script.sources);
}

} // namespace hvi::python
