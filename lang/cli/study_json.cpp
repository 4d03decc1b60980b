// A study as JSON, docs/schema.
#include "lang/study.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

namespace hvi::lang {

namespace {

nlohmann::ordered_json number_or_null(double v) {
  return std::isfinite(v) ? nlohmann::ordered_json(v) : nlohmann::ordered_json(nullptr);
}

template <class Norms>
nlohmann::ordered_json norms_json(const Norms& e) {
  return {{"V_max", number_or_null(e.v_max)},
          {"V_final", number_or_null(e.v_final)},
          {"L2", number_or_null(e.l2_max)},
          {"L2_final", number_or_null(e.l2_final)},
          {"relative", number_or_null(e.relative())}};
}

nlohmann::ordered_json row_json(const Study& study, const StudyRow& row) {
  nlohmann::ordered_json out = {{"params", row.values}};
  if (row.error) out["error"] = norms_json(*row.error);
  for (std::size_t u = 0; u < row.errors.size(); ++u)
    out["unknown_errors"][study.unknowns[u]] = norms_json(row.errors[u]);
  if (row.error)
    for (const auto& [name, value] : row.probe_errors) out["error"][name] = number_or_null(value);
  out["probes"] = row.probes;
  out["cpu"] = row.cpu, out["wall"] = row.wall, out["peak_bytes"] = row.peak_bytes;
  out["unknowns"] = row.unknowns, out["steps"] = row.steps, out["newton"] = row.newton;
  out["order"] = row.order ? number_or_null(*row.order) : nlohmann::ordered_json(nullptr);
  out["front"] = row.front;
  if (const auto& c = row.cea; c && row.error)
    out["cea"] = {{"interpolation", c->interpolation},
                  {"interpolation_rate", c->interpolation_rate},
                  {"trace", c->trace},
                  {"residual", c->residual},
                  {"largest_residual", c->largest_residual},
                  {"rate", c->rate},
                  {"start", c->start},
                  {"step", c->step},
                  {"constant", row.error->v_max * row.error->v_max / c->bound()}};
  if (!row.failure.empty()) out["failure"] = row.failure;
  return out;
}

nlohmann::ordered_json extrapolation_json(const std::string& of,
                                          const std::optional<solver::Richardson>& law) {
  nlohmann::ordered_json out{{"of", of}, {"order", nullptr}};
  if (!law) return out;
  out["order"] = law->order, out["finest"] = law->finest;
  out["along"] = law->along;
  return out;
}

} // namespace

nlohmann::ordered_json study_json(const Study& study) {
  auto rows = nlohmann::ordered_json::array();
  nlohmann::ordered_json best = nullptr; ///< the row with the least error
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    rows.push_back(row_json(study, study.rows[i]));
    if (!study.rows[i].error) continue;
    if (best.is_null() ||
        study.rows[i].error->v_max < study.rows[best.get<std::size_t>()].error->v_max)
      best = i;
  }
  nlohmann::ordered_json out{{"schema", "hvi-study/1"},
                             {"script", study.script},
                             {"reference", study.reference},
                             {"machine", study.machine},
                             {"shared",
                              {{"meshes", study.shared.meshes},
                               {"matrices", study.shared.matrices},
                               {"orders", study.shared.orders},
                               {"factors", study.shared.factors},
                               {"seconds", study.shared.seconds}}},
                             {"rows", rows},
                             {"best", best}};
  for (const auto& [of, law] : study.extrapolated)
    out["extrapolated"].push_back(extrapolation_json(of, law));
  if (!study.units.empty()) out["units"] = study.units;
  if (!study.units_by_kind.empty()) out["units_by_kind"] = study.units_by_kind;
  return out;
}

} // namespace hvi::lang
