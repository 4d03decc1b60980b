// See page.hpp.
#include "lang/report/page.hpp"

#include "lang/law_curves.hpp"
#include "lang/report/fields.hpp"
#include "lang/report/mathematics.hpp"
#include "lang/report/page_files.hpp"
#include "solver/results/energy.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <set>
#include <string_view>

namespace hvi::lang {
namespace {

using Json = nlohmann::ordered_json;

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json curve_json(const std::vector<draw::Spot>& curve) {
  Json out = Json::array();
  for (const auto& [x, y] : curve) out.push_back({number(x), number(y)});
  return out;
}

double end_of(const solver::Problem& problem) {
  return problem.time.grid.empty() ? 1.0 : problem.time.grid.back();
}

double begin_of(const solver::Problem& problem) {
  return problem.time.grid.empty() ? 0.0 : problem.time.grid.front();
}

Json laws_json(const solver::Problem& problem, const ModelUnits& units) {
  Json out = Json::array();
  std::set<int> shown;
  for (const solver::LawTerm& term : problem.law_terms) {
    if (!shown.insert(term.law).second) continue;
    const solver::LawSpec& law = problem.laws[static_cast<std::size_t>(term.law)];
    const auto curve = law_curve(law, end_of(problem));
    if (curve.empty()) continue;
    std::string note;
    if (!law.coupled.empty()) note = fmt::format("for the multiplier 1 of {}", law.coupled);
    if (!law.readings.empty()) note += "what it reads of the solution is taken as 0";
    out.push_back({{"name", term.name},
                   {"argument", (law.radial ? "|r|" : "r") + units.of_argument(law.name)},
                   {"multiplier", "ξ" + units.of_multiplier(law.name)},
                   {"unit", units.of_multiplier(law.name)},
                   {"note", note},
                   {"graph", curve_json(curve)}});
  }
  return out;
}

/// -1 where the memory takes from the stiffness: a form has the sign, its kernel of time has none.
double sign_of_memory(const solver::Problem& problem, int memory) {
  for (const solver::FormTerm& form : problem.forms)
    for (const auto& entry : form.entries)
      if (form.field == solver::field_of_memory(memory) && entry.test == entry.trial &&
          entry.coefficient.is_constant() && entry.coefficient.value() != 0.0)
        return entry.coefficient.value() < 0.0 ? -1.0 : 1.0;
  return 1.0;
}

Json kernels_json(const solver::Problem& problem) {
  Json out = Json::array();
  for (std::size_t m = 0; m < problem.histories.size(); ++m) {
    const auto& kernel = problem.histories[m].kernel;
    auto curve = kernel_curve(kernel, begin_of(problem), end_of(problem));
    const double sign = sign_of_memory(problem, static_cast<int>(m));
    for (draw::Spot& spot : curve) spot[1] *= sign;
    out.push_back({{"name", kernel.name},
                   {"note", sign < 0.0 ? "with the sign it has in the inequality" : ""},
                   {"graph", curve_json(curve)}});
  }
  return out;
}

Json model_json(const Script& script) {
  if (script.programs.empty()) return nullptr;
  Json out = mathematics_of(script.programs.front());
  out["laws"] = script.plan ? laws_json(script.plan->problem, script.model->units) : Json::array();
  out["kernels"] = script.plan ? kernels_json(script.plan->problem) : Json::array();
  return out;
}

Json parameters_json(const Script& script) {
  Json out = Json::array();
  if (!script.model) return out;
  for (const ModelParam& one : script.model->params) {
    Json value = std::visit([](const auto& v) { return Json(v); }, one.value);
    if (!one.unit.empty())
      value = fmt::format("{} [{}]", one.as_declared(std::get<double>(one.value)), one.unit);
    out.push_back({{"name", one.name}, {"value", value}, {"doc", one.doc}});
  }
  return out;
}

/// Columns of the monitors, and which of them are of the certificate, which are energies.
Json monitors_json(const solver::RunResult& run) {
  if (!run.monitors) return nullptr;
  Json columns = Json::array(), energies = Json::array();
  for (const auto& column : run.monitors->columns) {
    Json values = Json::array();
    for (const double x : column) values.push_back(number(x));
    columns.push_back(std::move(values));
  }
  for (const std::string& name : run.monitors->names)
    if (solver::is_energy(name)) energies.push_back(name);
  return {{"names", run.monitors->names},
          {"times", run.monitors->times},
          {"columns", columns},
          {"balance_error", number(run.monitors->balance_error)},
          {"certificate", {"inclusion", "equilibrium", "states", "newton", "events", "snap"}},
          {"energies", energies}};
}

/// Behind the names of columns, times, places and energies: " [mm]".
Json units_json(const Script& script) {
  Json out = Json::object();
  if (!script.plan || !script.model->units.used()) return out;
  const solver::ReportSpec& report = script.plan->report;
  for (const solver::Probe& probe : report.probes) // parts of other probes have no name
    if (!probe.name.empty()) out["columns"][probe.name] = ModelUnits::bracketed(probe.unit);
  out["time"] = ModelUnits::bracketed(report.unit_of_time);
  out["length"] = ModelUnits::bracketed(report.unit_of_length);
  out["energy"] = ModelUnits::bracketed(report.unit_of_energy);
  return out;
}

std::string source_of(const Script& script) {
  if (script.sources.n_files() == 0) return {};
  return std::string(script.sources.file(0).text());
}

Json data_of(const ReportParts& parts, Blocks& blocks) {
  const Script& script = parts.script;
  Json out{{"schema", "hvi-report/1"},
           {"title", script.model ? script.model->title : script.path},
           {"script", script.path},
           {"source", source_of(script)},
           {"parameters", parameters_json(script)},
           {"units", units_json(script)},
           {"model", model_json(script)},
           {"hypotheses", parts.hypotheses},
           {"result", parts.result},
           {"study", parts.study},
           {"stability", parts.stability},
           {"monitors", nullptr},
           {"fields", nullptr}};
  if (parts.run == nullptr) return out;
  out["monitors"] = monitors_json(*parts.run);
  out["fields"] = fields_json(parts.frames, blocks);
  if (!out["fields"].is_null()) {
    out["fields"]["axisymmetric"] = script.plan->problem.mesh.axisymmetric;
    out["fields"]["since"] = parts.frames_since;
  }
  return out;
}

/// JSON for the inside of an element: no `<` that could end it or begin a comment.
std::string inside_html(const Json& value) {
  const std::string text = solver::json_text(value);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

void replace(std::string& text, std::string_view mark, const std::string& by) {
  text.replace(text.find(mark), mark.size(), by);
}

} // namespace

std::string report_page(const ReportParts& parts) {
  Blocks blocks;
  const Json data = data_of(parts, blocks);
  std::string out(page_html());
  replace(out, "<!--style-->", std::string(page_style()));
  replace(out, "<!--code-->", std::string(page_code()));
  replace(out, "<!--data-->",
          fmt::format("<script type=\"application/json\" id=\"report-data\">{}</script>\n{}",
                      inside_html(data), blocks.html()));
  return out;
}

} // namespace hvi::lang
