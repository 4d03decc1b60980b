// A study as CSV: a row for each setting, and what its columns are (study.hpp).
#include "lang/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
#include <string>

namespace hvi::lang {

namespace {

std::vector<std::string> probes_of(const Study& study) {
  if (study.sweep) return study.columns;
  std::vector<std::string> out;
  if (study.finest)
    for (const auto& [name, value] : study.rows[*study.finest].probes) out.push_back(name);
  return out;
}

bool is_number(const std::string& value) {
  char* end = nullptr;
  std::strtod(value.c_str(), &end);
  return !value.empty() && *end == '\0';
}

/// What every study has, in its order.
std::vector<solver::CsvColumn> columns_of_every_row(const Study& study) {
  std::vector<solver::CsvColumn> out;
  for (const char* name :
       {"unknowns", "steps", "v_max", "v_final", "l2_max", "l2_final", "relative", "order"})
    out.push_back({name, ""});
  for (const char* name : {"cpu", "wall"}) out.push_back({name, study.units.empty() ? "" : "s"});
  for (const char* name :
       {"peak_bytes", "newton", "front", "cea_interpolation", "cea_interpolation_rate", "cea_trace",
        "cea_residual", "cea_rate", "cea_start", "cea_step", "cea_constant"})
    out.push_back({name, ""});
  for (const std::string& u : study.unknowns)
    for (const char* norm : {"v_max_", "l2_max_"}) out.push_back({norm + u, ""});
  return out;
}

} // namespace

std::vector<solver::CsvColumn> study_columns(const Study& study) {
  const auto always = columns_of_every_row(study);
  const solver::CsvColumn failure{"failure", "", false};
  std::set<std::string> taken{failure.name};
  for (const auto& column : always) taken.insert(column.name);
  std::vector<solver::CsvColumn> out;
  for (const std::string& name : varied(study)) {
    const bool numbers = std::ranges::all_of(
        study.rows, [&](const StudyRow& row) { return is_number(row.values.at(name)); });
    // A parameter `order`, a column `tip` beside a parameter of that name: by their kinds.
    out.push_back({taken.insert(name).second ? name : "params." + name,
                   unit_in(study, "params", name), numbers});
  }
  out.insert(out.end(), always.begin(), always.end());
  for (const std::string& probe : probes_of(study)) {
    const bool alone = !taken.contains(probe) && !taken.contains(probe + "_error");
    for (const char* what : {"", "_error"}) {
      const std::string name = (alone ? "" : "columns.") + probe + what;
      taken.insert(name);
      out.push_back({name, unit_in(study, "columns", probe)});
    }
  }
  out.push_back(failure);
  return out;
}

std::string study_csv(const Study& study) {
  std::string out;
  const auto probes = probes_of(study);
  for (const auto& column : study_columns(study)) out += (out.empty() ? "" : ",") + column.name;
  out += "\n";
  const auto number = [](std::optional<double> v) {
    return v && std::isfinite(*v) ? fmt::format("{:.17g}", *v) : std::string();
  };
  for (const StudyRow& row : study.rows) {
    for (const std::string& name : varied(study)) out += row.values.at(name) + ",";
    const auto& e = row.error;
    const auto of = [&](double v) { return e ? number(v) : std::string(); };
    const solver::StudyError none, &error = e ? *e : none;
    std::string failure = row.failure;
    std::replace(failure.begin(), failure.end(), '"', '\'');
    std::string terms = ",,,,,,,";
    if (const auto& c = row.cea; c && e)
      terms = fmt::format("{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                          c->interpolation, c->interpolation_rate, c->trace, c->residual, c->rate,
                          c->start, c->step, error.v_max * error.v_max / c->bound());
    std::string columns;
    for (std::size_t u = 0; u < study.unknowns.size(); ++u)
      columns += u < row.errors.size()
                     ? "," + number(row.errors[u].v_max) + "," + number(row.errors[u].l2_max)
                     : std::string(",,");
    for (const std::string& probe : probes) {
      const auto value = row.probes.find(probe), off = row.probe_errors.find(probe);
      columns += "," + (value == row.probes.end() ? "" : number(value->second));
      columns += "," + (off == row.probe_errors.end() ? "" : number(off->second));
    }
    out +=
        fmt::format("{},{},{},{},{},{},{},{},{:.6g},{:.6g},{:.0f},{},{},{}{},\"{}\"\n",
                    row.unknowns, row.steps, of(error.v_max), of(error.v_final), of(error.l2_max),
                    of(error.l2_final), of(error.relative()), number(row.order), row.cpu, row.wall,
                    row.peak_bytes, row.newton, row.front ? 1 : 0, terms, columns, failure);
  }
  return out;
}

} // namespace hvi::lang
