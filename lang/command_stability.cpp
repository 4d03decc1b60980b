// hvi-run stability: how far a model can be trusted. One run with monitors, the margins of the
// theory, and runs that differ from it by one unit in the last place or by a choice of the solver.
#include "lang/driver.hpp"
#include "lang/gnuplot.hpp"
#include "lang/interrupt.hpp"
#include "lang/nudge.hpp"
#include "lang/outputs.hpp"
#include "lang/say.hpp"
#include "solver/hypotheses/hypotheses.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>

namespace hvi::lang {

namespace {

constexpr double unit = std::numeric_limits<double>::epsilon();
constexpr int samples = 3;      ///< of the script's and the mesh's numbers
constexpr int most_states = 16; ///< at which two runs are compared

/// What a run left: its result and u at a sample of steps.
struct Trace {
  solver::RunResult result;
  std::vector<solver::Vector> states;
};

/// One run that differs from the first in one thing.
struct Variation {
  std::string what;
  bool of_input = true; ///< an input moved by one unit in the last place; else a solver's choice
  double moved = 0;     ///< relative change of the input
  std::optional<double> change; ///< max |u - u'| / max |u| over the sampled steps; none: it failed
  std::string failure;
};

struct Stability {
  Trace base;
  std::optional<solver::HypothesisReport> theory;
  std::string no_theory; ///< why there is no report of the hypotheses
  std::vector<Variation> variations;
  double condition = 0; ///< estimate for the step's matrix; 0: not known
};

Trace traced(const solver::Plan& plan, const solver::Discretisation& d, bool monitors) {
  Trace out;
  solver::RunSettings settings;
  settings.monitors = settings.condition = monitors;
  settings.stop = &stop_flag();
  const int steps = plan.time.is_static ? 1 : static_cast<int>(plan.time.grid.size()) - 1;
  const int stride = std::max(1, steps / most_states);
  settings.on_step = [&](int n, double, const solver::Vector& u, const solver::Vector&) {
    if (n % stride == 0 || n == steps) out.states.push_back(u);
  };
  out.result = solver::run(plan, d, settings);
  return out;
}

/// max_n |u_n - v_n| / max_n |u_n|
std::optional<double> distance(const Trace& a, const Trace& b) {
  if (a.states.size() != b.states.size()) return std::nullopt;
  double off = 0, size = 0;
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    if (a.states[i].size() != b.states[i].size()) return std::nullopt;
    off = std::max(off, (a.states[i] - b.states[i]).lpNorm<Eigen::Infinity>());
    size = std::max(size, a.states[i].lpNorm<Eigen::Infinity>());
  }
  return size > 0 ? off / size : off;
}

/// A run with other numbers has failed: says why, or throws where the numbers are not the reason.
void take_failure(const solver::Failure& failure, Variation& out) {
  using K = solver::FailureKind;
  if (failure.kind == K::interrupted || failure.kind == K::missing_file) throw failure;
  out.failure = failure.what();
}

/// The text of the script's own file, read once: the file may change or be refused later.
std::string text_of(const Script& script) { return std::string(script.sources.file(0).text()); }

/// The script with a parameter moved by one unit in the last place; nothing where it must be whole.
std::optional<Variation> moved_parameter(const Script& given, const Options& options,
                                         const ModelParam& param, const Trace& base) {
  const auto* value = std::get_if<double>(&param.value);
  if (value == nullptr || *value == 0.0 || !std::isfinite(*value)) return std::nullopt;
  Variation out;
  for (const double towards : {HUGE_VAL, -HUGE_VAL}) { // the other way at the end of its range
    const double next = std::nextafter(*value, towards);
    Options other = options;
    other.defines[param.name] = fmt::format("{:.17g}", next);
    Script script;
    script.path = given.path;
    script.text = text_of(given);
    if (!compile_variation(script, other)) continue;
    solver::Discretisation d;
    if (const auto failures = solver::discretise(*script.plan, d); !failures.empty()) {
      take_failure(failures.front(), out);
      continue;
    }
    out.what = fmt::format("`{}` by one unit in the last place", param.name);
    out.moved = std::abs((next - *value) / *value);
    try {
      out.change = distance(base, traced(*script.plan, d, false));
    } catch (const solver::Failure& failure) {
      take_failure(failure, out);
    }
    return out;
  }
  return std::nullopt;
}

/// A run of a script or a mesh with other numbers, against the first.
Variation compared(const std::string& what, const Trace& base,
                   const std::function<Trace()>& other) {
  Variation out{what, true, unit, {}, {}};
  try {
    out.change = distance(base, other());
  } catch (const solver::Failure& failure) {
    take_failure(failure, out);
  }
  return out;
}

solver::Failure refusal(const std::vector<solver::Failure>& failures) {
  return failures.empty() ? solver::Failure(solver::FailureKind::bad_value, {},
                                            "the moved numbers give no script")
                          : failures.front();
}

/// All numbers of the script at once, each by one unit in the last place, up or down at random.
std::vector<Variation> moved_numbers(const Script& given, const Options& options,
                                     const Trace& base) {
  std::vector<Variation> out;
  const std::string text = text_of(given);
  const auto literals = movable_literals(given.path, text, options);
  if (literals.empty()) return out;
  for (int sample = 1; sample <= samples; ++sample)
    out.push_back(compared(
        fmt::format("the {} numbers of the script by one unit in the last place, sample {}",
                    literals.size(), sample),
        base, [&] {
          Script script;
          script.path = given.path;
          script.text = moved_text(text, literals, static_cast<std::uint64_t>(sample));
          if (!compile_variation(script, options)) throw refusal({});
          solver::Discretisation d;
          if (const auto failures = solver::discretise(*script.plan, d); !failures.empty())
            throw refusal(failures);
          return traced(*script.plan, d, false);
        }));
  return out;
}

/// All coordinates of the mesh in the same way.
std::vector<Variation> moved_meshes(const solver::Plan& plan, const solver::Discretisation& d,
                                    const Trace& base) {
  std::vector<Variation> out;
  for (int sample = 1; sample <= samples; ++sample)
    out.push_back(compared(
        fmt::format("the coordinates of the nodes by one unit in the last place, sample {}",
                    sample),
        base, [&] {
          solver::Mesh mesh = d.mesh;
          move_nodes(mesh, static_cast<std::uint64_t>(sample));
          solver::Discretisation other;
          if (const auto failures = solver::discretise_on(plan, std::move(mesh), other);
              !failures.empty())
            throw refusal(failures);
          return traced(plan, other, false);
        }));
  return out;
}

/// Choices that must not matter where the solution is unique.
std::vector<std::pair<std::string, std::function<void(solver::Plan&)>>>
choices(const solver::Plan& plan) {
  std::vector<std::pair<std::string, std::function<void(solver::Plan&)>>> out;
  out.emplace_back("the certificate's tolerance times 1/100",
                   [](solver::Plan& p) { p.options.tolerance *= 0.01; });
  if (!plan.histories.empty() && plan.options.route != solver::HistoryRoute::direct)
    out.emplace_back("memory by the direct sum",
                     [](solver::Plan& p) { p.options.route = solver::HistoryRoute::direct; });
  if (plan.law_terms.empty()) return out;
  if (plan.options.branch != solver::Branch::release)
    out.emplace_back("the released branch",
                     [](solver::Plan& p) { p.options.branch = solver::Branch::release; });
  if (plan.options.branch != solver::Branch::least_energy)
    out.emplace_back("the branch of least energy",
                     [](solver::Plan& p) { p.options.branch = solver::Branch::least_energy; });
  return out;
}

Variation chosen(const std::string& what, const solver::Plan& plan, const solver::Discretisation& d,
                 const Trace& base) {
  Variation out{what, false, 0, {}, {}};
  try {
    out.change = distance(base, traced(plan, d, false));
  } catch (const solver::Failure& failure) {
    take_failure(failure, out);
  }
  return out;
}

Stability examine(Script& script, const solver::Discretisation& d, const Options& options) {
  Stability out;
  out.base = traced(*script.plan, d, true);
  out.condition = out.base.result.forward_error.condition;
  try {
    out.theory = solver::check_hypotheses(*script.plan, d, false);
  } catch (const solver::Failure& failure) {
    out.no_theory = failure.what();
  }
  for (const ModelParam& param : script.model->params)
    if (auto moved = moved_parameter(script, options, param, out.base))
      out.variations.push_back(std::move(*moved));
  for (auto& moved : moved_numbers(script, options, out.base))
    out.variations.push_back(std::move(moved));
  for (auto& moved : moved_meshes(*script.plan, d, out.base))
    out.variations.push_back(std::move(moved));
  for (const auto& [what, change] : choices(*script.plan)) {
    solver::Plan other = *script.plan;
    change(other);
    out.variations.push_back(chosen(what, other, d, out.base));
  }
  return out;
}

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

void print_report(const Stability& s) {
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
      fmt::format("{:.6g} at the end; work {:.6g} = stored {:.6g} + viscous {:.6g} + memory "
                  "{:.6g} + lost {:.6g} + what was stored at the start; balance to {:.1e}",
                  last(s, "energy"), last(s, "work"), last(s, "elastic") + last(s, "contact"),
                  last(s, "viscous"), last(s, "memory"), last(s, "lost"),
                  r.monitors->balance_error));
  row("lemma 3.2", fmt::format("max|u| {:.6g}, sum|du|^2 {:.6g}, max|xi| {:.6g}, sum k|du/k|^2 "
                               "{:.6g}",
                               last(s, "lemma_u"), last(s, "lemma_jumps"), last(s, "lemma_xi"),
                               last(s, "lemma_rate")));
  for (const auto& note : r.notes)
    if (note.step > 0)
      row("event", fmt::format("step {} (t = {:.6g}): {}", note.step, note.t, note.what));
  for (const auto& v : s.variations)
    row(v.of_input ? "input" : "choice",
        v.change ? fmt::format("{}: the answer moves by {:.1e}", v.what, *v.change)
                 : fmt::format("{}: no answer: {}", v.what, v.failure));
  row("verdict", verdict(s));
}

std::string report_json(const Stability& s, const Script& script) {
  using Json = nlohmann::ordered_json;
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
  const Json out = {{"schema", "hvi-stability/1"},
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
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
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
                        std::max(column("inclusion")[i], unit / 16),
                        std::max(column("equilibrium")[i], unit / 16), column("energy")[i],
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
           "unset logscale y\nset format y '%g'\nset title 'energy'\nset xlabel 't'\n"
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
           lines, s.base.result.certificate.tolerance),
       folder / picture_name(script), {.height = 800});
}

int report_on(Script& script, const Options& options) {
  if (!compile_script(script, options)) return exit_script;
  HeldOutputs outputs;
  std::vector<std::string> names;
  if (!script.plan->time.is_static)
    names.push_back(picture_name(script)); // one point is no picture
  int refused = exit_ok;
  if (!outputs.take(outputs_in(output_folder(script, options), names, options), options, script,
                    refused))
    return refused;
  solver::Discretisation d;
  for (const solver::Failure& failure : solver::discretise(*script.plan, d))
    add_failure(script, failure);
  if (script.diagnostics.has_errors()) return exit_script;
  const InterruptGuard guard;
  const Stability found = examine(script, d, options);
  int code = exit_ok;
  try {
    if (!options.json.empty()) write_json_text(options, report_json(found, script));
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
    code = exit_code(failure);
  }
  if (!json_only(options) && !options.quiet) print_report(found);
  if (names.empty()) return code;
  try {
    draw(found, script, options);
    if (!options.quiet && !json_only(options))
      say("{:<14}{}/{}\n", "picture", output_folder(script, options), names.front());
  } catch (const solver::Failure& failure) { // nobody asked for it by name
    script.diagnostics.add(diagnose("W0601", Span{}, failure.what()).with_help(failure.help));
  }
  return code;
}

} // namespace

int stability_command(const std::string& path, const Options& options) {
  Script script;
  script.path = path;
  int code = exit_ok;
  try {
    code = report_on(script, options);
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
    code = exit_code(failure);
  }
  show_diagnostics(script, options);
  return code;
}

} // namespace hvi::lang
