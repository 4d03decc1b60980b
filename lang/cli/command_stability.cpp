// hvi-run stability: how far a model can be trusted, as text, JSON and a picture.
#include "lang/cli/commands.hpp"
#include "lang/cli/interrupt.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/cli/say.hpp"
#include "lang/gnuplot.hpp"
#include "lang/stability.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

namespace hvi::lang {

namespace {

using Json = nlohmann::ordered_json;
constexpr double rounding_unit = std::numeric_limits<double>::epsilon();
double worst(const Stability& s, bool of_input) {
  double out = 0;
  for (const auto& v : s.variations)
    if (v.of_input == of_input && v.change) out = std::max(out, *v.change);
  return out;
}

double last(const Stability& s, const char* name) {
  const auto& m = *s.base.result.monitors;
  const auto at = std::find(m.names.begin(), m.names.end(), name) - m.names.begin();
  return m.columns[static_cast<std::size_t>(at)].back();
}

/// The sentence: unique or not, and what the smallest changes do.
std::string verdict(const Stability& s) {
  const auto& r = s.base.result;
  const double moved = worst(s, true), choice = worst(s, false);
  const std::string answer = fmt::format("one unit in the last place of an input moves the answer "
                                         "by at most {:.1e}",
                                         moved);
  if (!r.unique)
    return choice > 1e-6
               ? fmt::format("not guaranteed: several solutions exist, the choice of the branch "
                             "moves the answer by {:.1e}; on this branch {}",
                             choice, answer)
               : "not guaranteed: several solutions may exist, though no other was found; " +
                     answer;
  if (const double rounding = r.forward_error.worst(); rounding > solver::ForwardError::small)
    return fmt::format("sensitive: every step has one solution, but rounding may have changed a "
                       "printed number by {:.1e} of its size; {}",
                       rounding, answer);
  if (moved > 1e-8 || choice > 1e-6)
    return fmt::format(
        "sensitive: every step has one solution, but {}, and the solver's choices by "
        "{:.1e}",
        answer, choice);
  return fmt::format("stable: every step has one solution and is certified; {}", answer);
}

/// What energies and times are in; nothing for scripts without units.
struct Units {
  std::string energy, time;
};
Units units_of(const Script& script) {
  const auto& report = script.model->report;
  return {ModelUnits::bracketed(report.unit_of_energy), ModelUnits::bracketed(report.unit_of_time)};
}

void print_report(const Stability& s, const Units& units) {
  const auto& r = s.base.result;
  const auto& c = r.certificate;
  const auto row = [](const char* name, const std::string& text) { say("{:<14}{}\n", name, text); };
  row("conditioning", s.condition > 0 ? fmt::format("about {:.1e} (the step's matrix)", s.condition)
                                      : std::string("not known (no factor of the whole matrix)"));
  row("rounding",
      fmt::format(
          "changes the solution by about {:.1e}, the printed column most moved by {:.1e} of "
          "its size{}",
          r.forward_error.solution, r.forward_error.worst(),
          r.forward_error.refined ? "; steps refined in extended precision" : ""));
  if (s.theory)
    row("margins", fmt::format("step {:.6g} (ratio {:.6g}), split {:.6g}, against B {:.6g}",
                               s.theory->margins.step, 1 - s.theory->margins.step,
                               s.theory->margins.split, s.theory->margins.against_b));
  else
    row("margins", "not found: " + s.no_theory);
  row("certificate",
      fmt::format(
          "all {} steps; worst inclusion {:.1e} at step {}, worst equilibrium {:.1e} at step "
          "{}, tolerance {:.0e}",
          r.steps, c.inclusion, c.inclusion_step, c.equilibrium, c.equilibrium_step, c.tolerance));
  row("solver", fmt::format("{} Newton iterations, {} steps by the globally convergent method",
                            r.work.newton, r.work.fallback_steps));
  row("energy",
      fmt::format("{:.6g}{} at the end; work {:.6g} = stored {:.6g} + viscous {:.6g} + memory "
                  "{:.6g} + lost {:.6g} + what was stored at the start; balance to {:.1e}",
                  last(s, "energy"), units.energy, last(s, "work"),
                  last(s, "elastic") + last(s, "contact"), last(s, "viscous"), last(s, "memory"),
                  last(s, "lost"), r.monitors->balance_error));
  row("lemma 3.2", fmt::format("max|u| {:.6g}, sum|du|^2 {:.6g}, max|xi| {:.6g}, sum k|du/k|^2 "
                               "{:.6g}",
                               last(s, "lemma_u"), last(s, "lemma_jumps"), last(s, "lemma_xi"),
                               last(s, "lemma_rate")));
  for (const auto& note : r.notes)
    if (note.step > 0)
      row("event",
          fmt::format("step {} (t = {:.6g}{}): {}", note.step, note.t, units.time, note.what));
  for (const auto& v : s.variations)
    row(v.of_input ? "input" : "choice",
        v.change ? fmt::format("{}: the answer moves by {:.1e}", v.what, *v.change)
                 : fmt::format("{}: no answer: {}", v.what, v.failure));
  row("verdict", verdict(s));
}

nlohmann::ordered_json report_json(const Stability& s, const Script& script) {
  const auto number = [](double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); };
  const auto& r = s.base.result;
  Json monitors = {{"t", r.monitors->times}};
  for (std::size_t c = 0; c < r.monitors->names.size(); ++c)
    monitors[r.monitors->names[c]] = r.monitors->columns[c];
  Json variations = Json::array(), events = Json::array();
  for (const auto& v : s.variations)
    variations.push_back({{"what", v.what},
                          {"of", v.of_input ? "input" : "choice"},
                          {"moved", v.moved},
                          {"change", v.change ? number(*v.change) : Json(nullptr)},
                          {"failure", v.failure}});
  for (const auto& note : r.notes)
    if (note.step > 0) events.push_back({{"step", note.step}, {"t", note.t}, {"what", note.what}});
  Json out{{"schema", "hvi-stability/1"},
           {"script", script.path},
           {"verdict", verdict(s)},
           {"unique", r.unique},
           {"condition", s.condition > 0 ? number(s.condition) : Json(nullptr)},
           {"forward_error", number(r.forward_error.worst())},
           {"margins", s.theory ? Json{{"step", number(s.theory->margins.step)},
                                       {"split", number(s.theory->margins.split)},
                                       {"against_B", number(s.theory->margins.against_b)},
                                       {"largest", number(s.theory->margins.largest)},
                                       {"paper", number(s.theory->margins.paper)}}
                                : Json(nullptr)},
           {"certificate",
            {{"inclusion", number(r.certificate.inclusion)},
             {"inclusion_step", r.certificate.inclusion_step},
             {"equilibrium", number(r.certificate.equilibrium)},
             {"equilibrium_step", r.certificate.equilibrium_step},
             {"tolerance", r.certificate.tolerance}}},
           {"balance_error", number(r.monitors->balance_error)},
           {"events", events},
           {"variations", variations},
           {"monitors", monitors}};
  if (script.model->units.used())
    out["units"] = {{"t", script.model->report.unit_of_time},
                    {"energy", script.model->report.unit_of_energy}};
  return out;
}

std::string picture_name(const Script& script) { return script.model->title + "_stability.png"; }

/// Certificate and energies over time, events as upright lines.
void draw(const Stability& s, const Script& script, const Options& options) {
  const auto& m = *s.base.result.monitors;
  const auto column = [&](const char* name) -> const std::vector<double>& {
    return m.columns[static_cast<std::size_t>(std::find(m.names.begin(), m.names.end(), name) -
                                              m.names.begin())];
  };
  std::string data, lines;
  for (std::size_t i = 0; i < m.times.size(); ++i) {
    data += fmt::format("{:.9g} {:.3g} {:.3g} {:.9g} {:.9g} {:.9g} {:.9g}\n", m.times[i],
                        std::max(column("inclusion")[i], rounding_unit / 16),
                        std::max(column("equilibrium")[i], rounding_unit / 16), column("energy")[i],
                        column("elastic")[i], column("contact")[i], column("lost")[i]);
    if (column("events")[i] > 0 || column("snap")[i] > 0)
      lines += fmt::format("set arrow from {0:.9g}, graph 0 to {0:.9g}, graph 1 nohead lc rgb "
                           "'#bb5566' dt 2\n",
                           m.times[i]);
  }
  const auto folder = std::filesystem::path(output_folder(script, options));
  plot(fmt::format(
           "$d << HVI_END\n{}HVI_END\n"
           "set multiplot layout 2,1 title {} noenhanced\nset grid lc rgb '#dddddd'\n{}"
           "set logscale y\nset format y '%.0e'\nset title 'certificate (tolerance {:.0e})'\n"
           "plot $d using 1:2 with linespoints pt 7 ps 0.4 lc rgb '#004488' title 'inclusion', $d "
           "using "
           "1:3 with linespoints pt 7 ps 0.4 lc rgb '#ddaa33' title 'equilibrium'\n"
           "unset logscale y\nset format y '%g'\nset title {}\nset xlabel {}\n"
           "plot $d using 1:4 with lines lw 2 lc rgb '#004488' title 'energy', $d using 1:5 with "
           "lines "
           "lc "
           "rgb '#228833' title 'elastic', $d using 1:6 with lines lc rgb '#ddaa33' title "
           "'contact', $d "
           "using 1:7 with lines lc rgb '#bb5566' title 'lost'\nunset multiplot\n",
           data,
           quoted(script.model->title + ": " +
                  (s.base.result.unique ? "every step has one solution"
                                        : "uniqueness is not guaranteed")),
           lines, s.base.result.certificate.tolerance, quoted("energy" + units_of(script).energy),
           quoted("t" + units_of(script).time)),
       folder / picture_name(script), {.height = 800});
}

void write_pictures(Session& session, const Stability& found, const Options& options) {
  const Script& script = session.script;
  try {
    draw(found, script, options);
    if (!options.quiet && !json_only(options))
      say("{:<14}{}/{}\n", "picture", output_folder(script, options), picture_name(script));
  } catch (const solver::Failure& failure) { // nobody asked for it by name
    session.warn("W0601", failure, {});
  }
}

Exit report_on(Session& session, const Options& options, HeldOutputs& outputs) {
  if (const Exit code = session.compile(); code != exit_ok) return code;
  const Script& script = session.script;
  std::vector<std::string> names;
  if (!script.plan->problem.time.is_static)
    names.push_back(picture_name(script)); // one point is no picture
  std::vector<std::string> written = names;
  if (options.report) written.push_back(script.model->title + report_ending);
  const Outputs wanted = outputs_in(output_folder(script, options), written, options);
  if (const Exit code = outputs.take(wanted, options, session); code != exit_ok) return code;
  if (const Exit code = session.discretise(); code != exit_ok) return code;
  const InterruptGuard guard;
  std::optional<Stability> found;
  Exit code =
      session.attempt([&] { found = examine(session, compile_settings(options), &stop_flag()); });
  if (!found) return code;
  if (!options.json.empty())
    code = session.attempt([&] { write_json(options, report_json(*found, script)); });
  if (options.report)
    code = session.attempt([&] {
      ReportParts parts{script};
      parts.stability = report_json(*found, script);
      write_page(output_folder(script, options), script.model->title, parts);
    });
  if (!json_only(options) && !options.quiet) print_report(*found, units_of(script));
  if (!names.empty()) write_pictures(session, *found, options);
  return code;
}

} // namespace

int stability_command(const std::string& path, const Options& options) {
  HeldOutputs outputs;
  Session session(path, compile_settings(options));
  const Exit code = report_on(session, options, outputs);
  show_diagnostics(session.script, options);
  return code;
}

} // namespace hvi::lang
