// What is said of a search for an accuracy; see accuracy_report.hpp.
#include "lang/cli/accuracy_report.hpp"

#include "lang/cli/say.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace hvi::lang {

namespace {

using Json = nlohmann::ordered_json;
using solver::AccuracyResult;

Json number(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

std::string of(const AccuracyResult& result) {
  if (!result.request.probe.empty()) return "of `" + result.request.probe + "`";
  return result.plan.problem.space.more.empty() ? "of u in V" : "of all unknowns together";
}

Json tries(const AccuracyResult& result) {
  Json out = Json::array();
  for (const auto& t : result.tries)
    out.push_back({{"setting", t.text},
                   {"order", t.setting.order},
                   {"scheme", solver::name_of(t.setting.scheme)},
                   {"level", t.setting.level},
                   {"steps", t.steps},
                   {"unknowns", t.unknowns},
                   {"predicted", {{"error", number(t.predicted_error)}, {"cpu", t.predicted_cpu}}},
                   {"cpu", t.cpu},
                   {"distance", {{"space", t.space_distance}, {"time", t.time_distance}}},
                   {"observed_order", {{"space", t.space_order}, {"time", t.time_order}}},
                   {"error", {{"space", t.space_error}, {"time", t.time_error}}},
                   {"estimate", number(t.estimate)}});
  return out;
}

Json runs(const AccuracyResult& result) {
  Json out = Json::array();
  for (const auto& r : result.runs) {
    Json run = {
        {"setting", r.text}, {"purpose", r.purpose}, {"unknowns", r.unknowns}, {"cpu", r.cpu}};
    if (r.distance) run["distance"] = number(*r.distance), run["against"] = r.against;
    if (!r.failure.empty()) run["failure"] = r.failure;
    out.push_back(run);
  }
  return out;
}

} // namespace

std::function<void(const std::string&)> accuracy_teller(const Options& options) {
  if (options.quiet) return [](const std::string&) {};
  return [](const std::string& line) { tell("accuracy: {}\n", line); };
}

std::string accuracy_text(const AccuracyResult& result) {
  std::size_t width = 8;
  for (const auto& r : result.runs) width = std::max(width, r.text.size());
  for (const auto& t : result.tries) width = std::max(width, t.text.size());
  std::string out = fmt::format("evidence: relative distances {}\n  {:<{}}  unknowns     CPU s  "
                                "distance  to\n",
                                of(result), "setting", width);
  for (const auto& r : result.runs)
    out += fmt::format("  {:<{}}  {:>8}  {:>8.3g}  {:>8}  {}\n", r.text, width, r.unknowns, r.cpu,
                       r.distance ? fmt::format("{:.2e}", *r.distance) : "-",
                       r.failure.empty() ? r.against : "failed: " + r.failure);
  for (const auto& t : result.tries)
    out += fmt::format(
        "chosen: {}: {} unknowns, {:.3g} CPU s (predicted {:.3g}); error predicted "
        "{:.2e}, estimated {:.2e}\n  = space {:.2e} (order {:.2f}) + time {:.2e} (order "
        "{:.2f})\n",
        t.text, t.unknowns, t.cpu, t.predicted_cpu, t.predicted_error, t.estimate, t.space_error,
        t.space_order, t.time_error, t.time_order);
  if (result.reached)
    out += fmt::format(
        "accuracy: estimated relative error {} {:.2e}, times {} within the wanted {:.1e}; "
        "{:.3g} CPU s in all\n",
        of(result), result.tries.back().estimate, solver::accuracy_safety, result.request.wanted,
        result.cpu);
  if (const auto& s = result.spared; s.matrices > 0)
    out += fmt::format("shared between runs: {} assembled matrices, {} orders of elimination, {} "
                       "factors; {:.2g} CPU s not spent again\n",
                       s.matrices, s.orders, s.factors, s.seconds());
  return out;
}

Json accuracy_json(const AccuracyResult& result) {
  return {{"wanted", result.request.wanted},
          {"of", result.request.probe.empty() ? "V" : result.request.probe},
          {"reached", result.reached},
          {"estimate", number(result.tries.empty() ? NAN : result.tries.back().estimate)},
          {"safety", solver::accuracy_safety},
          {"memory_tolerance", result.memory_tolerance},
          {"cpu", result.cpu},
          {"tries", tries(result)},
          {"runs", runs(result)}};
}

} // namespace hvi::lang
