// The result of a run as JSON; see result_json.hpp. After the run, before the disk.
#include "solver/results/result_json.hpp"

#include "solver/results/report.hpp"
#include "solver/step/work.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

using Json = nlohmann::ordered_json;

namespace {

/// JSON knows neither NaN nor infinity.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json numbers(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double value : values) out.push_back(number(value));
  return out;
}

Json table(const RunResult& result) {
  Json out{{"t", numbers(result.times)}};
  for (const auto& name : result.column_order) out[name] = numbers(result.columns.at(name));
  if (shows_events(result)) out[event_column] = result.events;
  return out;
}

Json monitors(const MonitorTable& table) {
  Json out{{"t", numbers(table.times)}};
  for (std::size_t c = 0; c < table.names.size(); ++c)
    out[table.names[c]] = numbers(table.columns[c]);
  out["balance_error"] = number(table.balance_error);
  return out;
}

Json certificate(const Certificate& c) {
  Json out = {{"certified", c.certified},
              {"inclusion", number(c.inclusion)},
              {"equilibrium", number(c.equilibrium)},
              {"tolerance", c.tolerance},
              {"mode", c.mode},
              {"worst_step", c.worst_step},
              {"inclusion_step", c.inclusion_step},
              {"equilibrium_step", c.equilibrium_step}};
  if (c.states) out["states"] = number(*c.states);
  return out;
}

/// What rounding may have done to the columns; null: infinite.
Json forward_error(const ForwardError& error) {
  Json columns = Json::object();
  for (const auto& column : error.columns)
    columns[column.name] = {{"absolute", number(column.absolute)},
                            {"relative", number(column.relative)}};
  return {{"solution", number(error.solution)},
          {"columns", columns},
          {"amplification", number(error.amplification)},
          {"condition", error.condition > 0.0 ? number(error.condition) : Json(nullptr)},
          {"refined", error.refined}};
}

/// Phases, what a step takes of them, and a lower limit for triangular solves: reading the factors.
Json timing(const RunResult& result, double bandwidth) {
  const Timing& t = result.timing;
  const double steps = std::max(1, result.steps);
  const auto each = [&](double seconds) { return seconds / steps; };
  const auto least = [&](double bytes) {
    return bandwidth > 0.0 ? Json(bytes / bandwidth) : Json(nullptr);
  };
  return {{"per_step",
           {{"history", each(t.history)},
            {"sweeps", each(t.triangular_solves)},
            {"inequality", each(t.inequality)},
            {"steps", each(t.steps)},
            {"output", each(t.output)}}},
          {"limit",
           {{"swept_bytes", t.factor_bytes_read},
            {"bandwidth", bandwidth > 0.0 ? Json(bandwidth) : Json(nullptr)},
            {"sweeps", least(t.factor_bytes_read)},
            {"sweeps_per_step", least(each(t.factor_bytes_read))}}},
          {"mesh", t.mesh},
          {"assembly", t.assembly},
          {"ordering", t.ordering},
          {"factor", t.factor},
          {"history", t.history},
          {"sweeps", t.triangular_solves},
          {"inequality", t.inequality},
          {"steps", t.steps},
          {"output", t.output},
          {"total", t.total}};
}

const char* state_name(EffectNote::State state) {
  switch (state) {
  case EffectNote::State::on:
    return "on";
  case EffectNote::State::off:
    return "off";
  case EffectNote::State::dropped:
    return "dropped";
  case EffectNote::State::asleep:
    return "asleep";
  }
  return "";
}

Json histories(const RunResult& result, const Problem& problem) {
  Json out = Json::array();
  for (std::size_t m = 0; m < result.histories.size(); ++m) {
    const auto& h = result.histories[m];
    out.push_back({{"kernel", m < problem.histories.size() ? problem.histories[m].kernel.name : ""},
                   {"route", h.route},
                   {"why", h.why},
                   {"fields", h.fields},
                   {"bytes", h.bytes},
                   {"error", number(h.error)},
                   {"verified", h.verified},
                   {"norm", number(h.norm)},
                   {"bound", number(h.bound)},
                   {"audits", h.audits},
                   {"audited_until", h.audited_until},
                   {"audit", number(h.audit)}});
  }
  return out;
}

/// Nothing where a factor solved.
Json of_iterations(const IterationWork& work) {
  Json out = Json::object();
  if (work.iterations > 0) out["iterations"] = work.iterations;
  for (const MultigridLevel& level : work.levels)
    out["multigrid"].push_back({{"rows", level.rows}, {"entries", level.entries}});
  if (work.assembling > 1) out["assembled_by"] = work.assembling;
  if (work.bytes_of_others > 0) out["bytes_of_others"] = work.bytes_of_others;
  if (work.messages > 0)
    out["communication"] = {
        {"messages", work.messages}, {"bytes", work.bytes_sent}, {"reductions", work.reductions}};
  return out;
}

Json what_was_done(const RunResult& result, const Problem& problem, const ResultContext& context) {
  const auto line_of = [&](Origin origin) {
    return context.line_of && origin.id >= 0 ? context.line_of(origin) : 0;
  };
  Json effects = Json::array();
  for (const auto& effect : result.effects)
    effects.push_back({{"name", effect.name},
                       {"state", state_name(effect.state)},
                       {"line", line_of(effect.origin)},
                       {"why", effect.why}});
  const auto& work = result.work;
  Json out{{"effects", effects},
           {"evolution", result.path.empty() ? "contact unknowns" : "all unknowns"},
           {"evolution_why",
            result.path.empty() ? "all tensors are multiples of one tensor" : result.path},
           {"matrices", work.matrices},
           {"analyses", work.analyses},
           {"factorisations", work.factorisations},
           {"sweeps", work.triangular_solves},
           {"products", work.products},
           {"newton", work.newton},
           {"fallback_steps", work.fallback_steps},
           {"followed_steps", work.followed_steps},
           {"inner_steps", work.inner_steps},
           {"unfollowed_steps", work.unfollowed_steps},
           {"fields", work.history_fields},
           {"field_reads", work.field_reads},
           {"history", histories(result, problem)},
           {"bytes", work.bytes},
           {"seconds", result.timing.total}};
  if (work.singles) out["factor"] = "single";
  out.update(of_iterations(work.iterative));
  if (!result.solver.why.empty()) {
    out["solver"] = result.solver.solver == LinearSolver::iterative ? "iterative" : "direct";
    out["solver_why"] = result.solver.why;
  }
  return out;
}

} // namespace

Json result_json(const RunResult& result, const Problem& problem, const ResultContext& context) {
  Json final = Json::object(), notes = Json::array();
  for (const auto& [name, value] : result.final) final[name] = number(value);
  for (const auto& note : result.notes)
    notes.push_back({{"step", note.step}, {"t", note.t}, {"what", note.what}});
  Json out{{"schema", "hvi-result/1"},
           {"script", result.script},
           {"params", Json(context.params)},
           {"unknowns", result.unknowns},
           {"contact_unknowns", result.contact_unknowns},
           {"steps", result.steps},
           {"final", final},
           {"table", table(result)},
           {"certificate", certificate(result.certificate)},
           {"forward_error", forward_error(result.forward_error)},
           {"timing", timing(result, context.bandwidth)},
           {"plan", what_was_done(result, problem, context)},
           {"uniqueness", result.unique ? "guaranteed" : "not guaranteed"},
           {"energy", result.energy ? number(*result.energy) : Json(nullptr)},
           {"notes", notes},
           {"files", result.files}};
  if (!context.units.empty()) out["units"] = context.units;
  if (!context.units_by_kind.empty()) out["units_by_kind"] = context.units_by_kind;
  if (result.monitors) out["monitors"] = monitors(*result.monitors);
  return out;
}

Json plan_json(const RunResult& first_steps, const Problem& problem, const ResultContext& context,
               const PredictedWork& predicted) {
  Json work = what_was_done(first_steps, problem, context);
  const auto of_all_steps = [&](Json& counted) {
    counted =
        std::llround(counted.get<double>() * predicted.steps / std::max(1, predicted.first_steps));
  };
  for (const char* counted : {"sweeps", "products", "newton", "iterations"})
    if (work.contains(counted)) of_all_steps(work[counted]);
  if (work.contains("communication"))
    for (Json& counted : work["communication"]) of_all_steps(counted);
  for (const char* of_a_run :
       {"fallback_steps", "followed_steps", "inner_steps", "unfollowed_steps", "field_reads"})
    work.erase(of_a_run);
  for (Json& history : work["history"])
    for (const char* measured : {"bytes", "norm", "bound", "audits", "audited_until", "audit"})
      history.erase(measured);
  std::int64_t fields = 0;
  for (const auto& history : first_steps.histories) fields += history.fields;
  work["fields"] = fields;
  work["seconds"] = predicted.seconds, work["bytes"] = predicted.bytes;
  Json out{{"schema", "hvi-plan/1"},
           {"script", first_steps.script},
           {"params", Json(context.params)},
           {"unknowns", first_steps.unknowns},
           {"contact_unknowns", first_steps.contact_unknowns},
           {"steps", predicted.steps},
           {"first_steps", predicted.first_steps},
           {"plan", work}};
  if (!context.units.empty()) out["units"] = context.units;
  if (!context.units_by_kind.empty()) out["units_by_kind"] = context.units_by_kind;
  return out;
}

std::string json_text(const Json& value) {
  return value.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace hvi::solver
