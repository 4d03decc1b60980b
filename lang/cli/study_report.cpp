// A study as table and pictures (study.hpp).
#include "lang/gnuplot.hpp"
#include "lang/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <set>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;

std::string cell(std::optional<double> v, const char* format) {
  return v && std::isfinite(*v) ? fmt::format(fmt::runtime(format), *v) : std::string("-");
}

std::vector<std::string> headings(const Study& study) {
  std::vector<std::string> out;
  for (const std::string& name : varied(study)) out.push_back(with_parameter_unit(study, name));
  for (const char* name : {"unknowns", "V error", "at the end", "relative", "order", "L2 error",
                           "CPU s", "wall s", "peak MB", "Newton", "front"})
    out.emplace_back(name);
  return out;
}

std::vector<std::string> cells(const Study& study, const StudyRow& row) {
  std::vector<std::string> out;
  for (const std::string& name : varied(study)) out.push_back(row.values.at(name));
  const auto of = [&](double solver::StudyError::*member) {
    return row.error ? std::optional((*row.error).*member) : std::nullopt;
  };
  out.push_back(fmt::format("{}", row.unknowns));
  out.push_back(cell(of(&solver::StudyError::v_max), "{:.3e}"));
  out.push_back(cell(of(&solver::StudyError::v_final), "{:.3e}"));
  out.push_back(row.error ? cell(row.error->relative(), "{:.2e}") : "-");
  out.push_back(cell(row.order, "{:.2f}"));
  out.push_back(cell(of(&solver::StudyError::l2_max), "{:.3e}"));
  out.push_back(cell(row.cpu, "{:.3g}"));
  out.push_back(cell(row.wall, "{:.3g}"));
  out.push_back(cell(row.peak_bytes / 1e6, "{:.3g}"));
  out.push_back(fmt::format("{}", row.newton));
  out.push_back(row.front ? "*" : "");
  return out;
}

constexpr std::array kinds = {"svg", "png"};

/// The number of a rung that a logarithmic axis can show.
std::optional<double> on_axis(const std::string& rung) {
  char* end = nullptr;
  const double value = std::strtod(rung.c_str(), &end);
  if (rung.empty() || *end != '\0' || !(value > 0.0) || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Is there a curve to draw: at least two different places on the axis?
bool has_order_picture(const Study& study, std::size_t along) {
  std::set<double> places;
  for (const std::string& rung : study.ladders[along].values)
    if (const auto value = on_axis(rung)) places.insert(*value);
  return places.size() > 1;
}

std::vector<std::string> names_of_pictures(const Study& study) {
  if (study.sweep) {
    std::vector<std::string> out;
    for (const std::string& column : study.columns) out.push_back("sweep_" + column);
    return out;
  }
  std::vector<std::string> out = {"cost"};
  for (std::size_t l = 0; l < study.ladders.size(); ++l)
    if (has_order_picture(study, l)) out.push_back("order_" + study.ladders[l].parameter);
  return out;
}

/// Points of one curve.
std::string data_block(const std::string& name, const std::vector<const StudyRow*>& rows,
                       const std::function<double(const StudyRow&)>& x) {
  std::string out = fmt::format("${} << HVI_END\n", name);
  for (const StudyRow* row : rows)
    out += fmt::format("{:.8g} {:.8g}\n", x(*row), row->error->v_max);
  return out + "HVI_END\n";
}

/// The rows with an error, in groups that differ in one ladder and make one curve each, with the
/// curve's name.
std::vector<std::pair<std::string, std::vector<const StudyRow*>>> curves(const Study& study,
                                                                         std::size_t along) {
  std::map<std::vector<int>, std::vector<const StudyRow*>> groups;
  for (const StudyRow& row : study.rows) {
    if (!row.error || !(row.error->v_max > 0.0)) continue;
    std::vector<int> others = row.rungs;
    others[along] = 0;
    groups[others].push_back(&row);
  }
  std::vector<std::pair<std::string, std::vector<const StudyRow*>>> out;
  for (auto& [rungs, rows] : groups) {
    std::string name;
    for (std::size_t l = 0; l < rungs.size(); ++l)
      if (l != along)
        name += fmt::format("{}{} = {}", name.empty() ? "" : ", ", study.ladders[l].parameter,
                            study.ladders[l].values[rungs[l]]);
    out.emplace_back(name.empty() ? "error" : name, std::move(rows));
  }
  return out;
}

std::string heading(const Study& study, const std::string& what) {
  return fmt::format(
      "set title {}\nset key outside right top\nset bmargin 5\nset grid\nset logscale xy\n"
      "set format y '10^{{%T}}'\nset ylabel 'error in V, largest over time'\n"
      "set label 1 {} at screen 0.01, 0.015 font ',8' noenhanced\n",
      quoted(fs::path(study.script).filename().string() + ": " + what) + " noenhanced",
      quoted("CPU seconds, medians of repeated runs; " + study.machine));
}

/// Error against CPU time; the settings worth their time are joined.
std::string cost_picture(const Study& study) {
  std::string text = heading(study, "what accuracy costs") + "set xlabel 'CPU seconds'\n", plots;
  int k = 0;
  for (const auto& [name, rows] : curves(study, 0)) {
    text +=
        data_block(fmt::format("curve{}", k), rows, [](const StudyRow& row) { return row.cpu; });
    plots += fmt::format("{}$curve{} with linespoints pt 7 ps 0.6 title {} noenhanced",
                         k ? ", " : "", k, quoted(name));
    ++k;
  }
  std::vector<const StudyRow*> front;
  for (const StudyRow& row : study.rows)
    if (row.front && row.error && row.error->v_max > 0.0) front.push_back(&row);
  std::sort(front.begin(), front.end(),
            [](const StudyRow* a, const StudyRow* b) { return a->cpu < b->cpu; });
  text += data_block("front", front, [](const StudyRow& row) { return row.cpu; });
  return text + "plot " + plots + ", $front with linespoints lw 3 lc rgb '#c00000' title 'front'\n";
}

/// Triangles of slopes one and two with a common corner, below the curves on the left.
std::string triangles(double left, double right, double top) {
  std::string out;
  for (int order = 1; order <= 2; ++order) {
    const double low = top * std::pow(left / right, order);
    out += fmt::format(
        "$slope{0} << HVI_END\n{1:.8g} {3:.8g}\n{2:.8g} {4:.8g}\n{1:.8g} {4:.8g}\n{1:.8g} "
        "{3:.8g}\nHVI_END\nset label {5} '{0}' at {6:.8g},{4:.8g} offset 0,0.6 tc rgb "
        "'gray30'\n",
        order, left, right, top, low, order + 1, std::sqrt(left * right));
  }
  return out;
}

/// Error against a ladder's numbers, with triangles beside it.
std::string order_picture(const Study& study, std::size_t along) {
  const std::string& parameter = study.ladders[along].parameter;
  std::string text = heading(study, "order in " + parameter) +
                     fmt::format("set xlabel {} noenhanced\n",
                                 quoted(with_parameter_unit(study, parameter))),
              plots;
  const auto place = [&](const StudyRow& row) { return on_axis(row.values.at(parameter)); };
  const auto value = [&](const StudyRow& row) { return place(row).value_or(0.0); };
  int k = 0;
  double low = 1e300, high = 0.0, least = 1e300;
  for (auto& [name, rows] : curves(study, along)) {
    std::erase_if(rows, [&](const StudyRow* row) { return !place(*row); });
    if (rows.empty()) continue;
    text += data_block(fmt::format("curve{}", k), rows, value);
    plots +=
        fmt::format("$curve{} with linespoints pt 7 ps 0.6 title {} noenhanced, ", k, quoted(name));
    ++k;
    for (const StudyRow* row : rows)
      low = std::min(low, value(*row)), high = std::max(high, value(*row));
  }
  for (const StudyRow& row : study.rows)
    if (row.error && row.error->v_max > 0.0 && value(row) == low)
      least = std::min(least, row.error->v_max);
  return text + triangles(low, low * std::cbrt(high / low), 0.6 * least) +
         fmt::format("plot {}$slope1 with lines lc rgb 'gray40' notitle, $slope2 with lines lc rgb "
                     "'gray40' notitle\n",
                     plots);
}

/// How the errors of a study were made from distances.
std::string extrapolation_text(const Study& study) {
  std::string seen, none;
  for (const auto& [of, law] : study.extrapolated) {
    std::string& list = law ? seen : none;
    list += (list.empty() ? "" : ", ") + of;
    if (law) list += fmt::format(" (order {:.2f})", law->order);
  }
  std::string out;
  if (!seen.empty()) out += "extrapolated from distances: " + seen + "\n";
  if (!none.empty())
    out += "no order is seen, distances to the finest run as they are: " + none + "\n";
  return out;
}

/// Of several unknowns: the errors of each in its own norm.
std::string unknowns_table(const Study& study) {
  std::string out;
  for (std::size_t u = 0; u < study.unknowns.size(); ++u) {
    out += fmt::format("`{}` in its own norm:\n", study.unknowns[u]);
    for (const StudyRow& row : study.rows) {
      if (u >= row.errors.size()) continue;
      for (const std::string& name : varied(study))
        out += fmt::format("  {} = {}", name, row.values.at(name));
      const auto& e = row.errors[u];
      const auto order = u < row.orders.size() ? row.orders[u] : std::nullopt;
      out += fmt::format(": V error {}, at the end {}, relative {}, order {}, L2 error {}\n",
                         cell(e.v_max, "{:.3e}"), cell(e.v_final, "{:.3e}"),
                         cell(e.relative(), "{:.2e}"), cell(order, "{:.2f}"),
                         cell(e.l2_max, "{:.3e}"));
    }
  }
  return out;
}

/// Probes at the end, their distances to the finest run and the orders.
std::string probe_table(const Study& study) {
  std::string out;
  if (!study.finest) return out;
  for (const auto& [probe, finest] : study.rows[*study.finest].probes) {
    out += fmt::format("`{}` at the end{}:\n", probe,
                       with_column_unit(study, probe).substr(probe.size()));
    for (const StudyRow& row : study.rows) {
      const auto value = row.probes.find(probe);
      if (value == row.probes.end()) continue;
      for (const std::string& name : varied(study))
        out += fmt::format("  {} = {}", name, row.values.at(name));
      const auto of = [&](const std::map<std::string, double>& map) {
        const auto at = map.find(value->first);
        return at == map.end() ? std::nullopt : std::optional(at->second);
      };
      out +=
          fmt::format(": {:.9g}, off by {}, order {}\n", value->second,
                      cell(of(row.probe_errors), "{:.2e}"), cell(of(row.probe_orders), "{:.2f}"));
    }
  }
  return out;
}

/// What settings took over from one another.
std::string shared_line(const Study& study) {
  const auto& s = study.shared;
  if (s.meshes == 0) return {};
  return fmt::format("shared between settings: {} meshes, {} assembled matrices, {} orders of "
                     "elimination, {} factors; {:.3g} CPU s (without meshes) not spent again\n",
                     s.meshes, s.matrices, s.orders, s.factors, s.seconds);
}

/// The terms of the Cea type inequality, a row for each run that has them.
std::string cea_table(const Study& study) {
  std::string out;
  for (const StudyRow& row : study.rows) {
    if (!row.cea || !row.error) continue;
    if (out.empty()) {
      out = "Cea inequality: max|e|^2 <= C (max|u-v|^2 + k sum|d(u-v)|^2 + k sum|M(u-v)| + k "
            "sum|S| + "
            "k sum|du-u'|^2 + |e_0|^2 + k^2), v the interpolant of u\n";
      for (const std::string& name : varied(study)) out += fmt::format("{:>6}  ", name);
      out +=
          fmt::format("{:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}\n", "|e|^2",
                      "|u-v|^2", "|d(u-v)|", "|M(u-v)|", "|S|", "|du-u'|^2", "|e_0|^2", "k^2", "C");
    }
    for (const std::string& name : varied(study))
      out += fmt::format("{:>6}  ", row.values.at(name));
    const auto& c = *row.cea;
    const double square = row.error->v_max * row.error->v_max;
    out += fmt::format(
        "{:9.2e}  {:9.2e}  {:9.2e}  {:9.2e}  {:9.2e}  {:9.2e}  {:9.2e}  {:9.2e}  {:9.2e}\n", square,
        c.interpolation, c.interpolation_rate, c.trace, c.residual, c.rate, c.start, c.step,
        square / c.bound());
  }
  return out;
}

} // namespace

std::vector<std::string> varied(const Study& study) {
  std::vector<std::string> out;
  for (const StudyLadder& ladder : study.ladders) {
    out.push_back(ladder.parameter);
    for (const auto& [name, values] : ladder.more) out.push_back(name);
  }
  return out;
}

std::string unit_in(const Study& study, const char* kind, const std::string& name) {
  const auto of_kind = study.units_by_kind.find(kind);
  if (of_kind == study.units_by_kind.end()) return {};
  const auto unit = of_kind->second.find(name);
  return unit == of_kind->second.end() ? std::string() : unit->second;
}

std::string with_parameter_unit(const Study& study, const std::string& name) {
  return name + ModelUnits::bracketed(unit_in(study, "params", name));
}

std::string with_column_unit(const Study& study, const std::string& name) {
  return name + ModelUnits::bracketed(unit_in(study, "columns", name));
}

std::string study_table(const Study& study) {
  if (study.sweep) return sweep_table(study);
  std::vector<std::vector<std::string>> grid = {headings(study)};
  for (const StudyRow& row : study.rows) grid.push_back(cells(study, row));
  std::vector<std::size_t> widths(grid[0].size(), 0);
  for (const auto& line : grid)
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  std::string out = fmt::format("{}: errors against {}{}\n", study.script, study.reference,
                                study.unknowns.empty() ? std::string()
                                : study.in ? fmt::format(", of `{}`", study.unknowns[*study.in])
                                           : std::string(", relative, of all unknowns together"));
  for (const auto& line : grid) {
    for (std::size_t c = 0; c < line.size(); ++c)
      out += fmt::format("{}{:>{}}", c ? "  " : "", line[c], widths[c]);
    out += "\n";
  }
  for (const StudyRow& row : study.rows)
    if (!row.failure.empty()) {
      out += "failed:";
      for (const auto& [name, value] : row.values) out += fmt::format(" {} = {}", name, value);
      out += ": " + row.failure + "\n";
    }
  out += extrapolation_text(study) + unknowns_table(study) + probe_table(study) + cea_table(study) +
         shared_line(study);
  return out + fmt::format("{}; * = no other setting is both cheaper and closer\n", study.machine);
}

std::vector<std::string> files_of_study(const Study& study) {
  std::vector<std::string> out = {"study.csv"};
  if (!study.units.empty()) out.push_back(solver::metadata_file("study.csv"));
  for (const std::string& name : names_of_pictures(study))
    for (const char* kind : kinds) out.push_back(fmt::format("{}.{}", name, kind));
  return out;
}

std::vector<Drawn> draw_study(const Study& study, const std::string& folder) {
  std::vector<Drawn> out;
  if (!study.sweep && curves(study, 0).empty()) return out;
  const auto draw = [&](const std::string& name, const std::string& commands) {
    for (const char* kind : kinds) {
      out.push_back({{}, fmt::format("{}.{}", name, kind), {}, false});
      try {
        plot(commands, fs::path(folder) / out.back().file, {.white = true});
      } catch (const solver::Failure& failure) {
        out.back().failure = failure;
      }
    }
  };
  if (study.sweep) {
    for (const std::string& column : study.columns)
      if (const std::string commands = sweep_picture(study, column); !commands.empty())
        draw("sweep_" + column, commands);
    return out;
  }
  draw("cost", cost_picture(study));
  for (std::size_t l = 0; l < study.ladders.size(); ++l)
    if (has_order_picture(study, l))
      draw("order_" + study.ladders[l].parameter, order_picture(study, l));
  return out;
}

} // namespace hvi::lang
