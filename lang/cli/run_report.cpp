// See run_report.hpp.
#include "lang/cli/run_report.hpp"

#include "lang/cli/accuracy_report.hpp"
#include "lang/cli/memory_lines.hpp"
#include "lang/cli/say.hpp"
#include "solver/linear/blas_kernels.hpp"
#include "solver/output/table.hpp"
#include "solver/results/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace hvi::lang {

namespace {

solver::ReportTable table_of(const solver::RunResult& result, const ModelUnits& units) {
  solver::ReportTable table;
  table.names.push_back("t" + units.behind("t"));
  table.columns.push_back(result.times);
  const bool with_events = solver::shows_events(result);
  for (const std::string& name : result.column_order) {
    table.names.push_back(name + units.behind(name));
    table.columns.push_back(result.columns.at(name));
  }
  if (with_events) {
    table.names.emplace_back(solver::event_column);
    table.columns.emplace_back(result.events.begin(), result.events.end());
  }
  return table;
}

/// The last values of the energies, with their unit if there is one, and the quantities of Lemma
/// 3.2.
void print_monitors(const solver::MonitorTable& m, const std::string& unit) {
  if (m.times.empty()) return;
  const auto last = [&](const char* name) {
    const auto at = std::find(m.names.begin(), m.names.end(), name) - m.names.begin();
    return m.columns[static_cast<std::size_t>(at)].back();
  };
  const bool moves = std::ranges::find(m.names, "kinetic") != m.names.end();
  say("energy{}: {:.9g} = {}elastic {:.9g} + contact {:.9g} - load\n", unit, last("energy"),
      moves ? fmt::format("kinetic {:.9g} + ", last("kinetic")) : std::string(), last("elastic"),
      last("contact"));
  std::string of_laws;
  for (const auto& name : m.names)
    if (name.starts_with("friction_"))
      of_laws +=
          fmt::format(", of it `{}` {:.6g}", name.substr(name.find('_') + 1), last(name.c_str()));
  say("work{}: {:.9g}; viscous {:.6g}, memory {:.6g}, lost {:.6g}{} (balance to {:.1e})\n", unit,
      last("work"), last("viscous"), last("memory"), last("lost"), of_laws, m.balance_error);
  say("lemma 3.2: max|u| {:.6g}, sum|du|^2 {:.6g}, max|xi| {:.6g}, sum k|du/k|^2 {:.6g}\n",
      last("lemma_u"), last("lemma_jumps"), last("lemma_xi"), last("lemma_rate"));
}

/// One line, where rounding shows in the digits that are printed.
void print_forward_error(const solver::ForwardError& error) {
  const double worst = error.worst();
  if (worst <= solver::ForwardError::small && !error.refined) return;
  std::string of = "the solution";
  for (const auto& column : error.columns)
    if (column.relative >= worst) of = "`" + column.name + "`";
  const std::string condition =
      error.condition > 0.0 ? fmt::format(", condition number about {:.1e}", error.condition) : "";
  say("rounding: changes {} by about {:.1e} of its size{}{}\n", of, worst, condition,
      error.refined ? ", steps refined in extended precision" : "");
}

void print_certificate(const solver::RunResult& r, const Script& script) {
  const solver::Certificate& c = r.certificate;
  if (c.certified)
    say("certified: {}, worst inclusion {:.1e} at step {}, worst equilibrium {:.1e} at step "
        "{}, {}tolerance {:.0e}\n",
        r.steps == 1 ? "1 step" : fmt::format("all {} steps", r.steps), c.inclusion,
        c.inclusion_step, c.equilibrium, c.equilibrium_step,
        c.states ? fmt::format("worst state {:.1e}, ", *c.states) : "", c.tolerance);
  print_forward_error(r.forward_error);
  if (r.work.followed_steps > 0)
    say("{} by {} inner steps\n",
        r.work.followed_steps == 1
            ? "1 step followed its branch"
            : fmt::format("{} steps followed their branch", r.work.followed_steps),
        r.work.inner_steps);
  if (r.work.unfollowed_steps > 0)
    say("note: {} steps may have left their branch: it was not followed (a vector law, more "
        "than 1200 points, forms without symmetry, bounds found together with their laws, or a "
        "curve without a further stable state); their answers may depend on the number of steps\n",
        r.work.unfollowed_steps);
  if (r.work.fallback_steps > 0)
    say("steps that only the globally convergent method solved: {}\n", r.work.fallback_steps);
  const auto& report = script.model->report;
  const std::string unit = ModelUnits::bracketed(report.unit_of_energy);
  if (r.monitors) print_monitors(*r.monitors, unit);
  print_memory(script.plan->problem, r.histories);
  print_solver(r.solver);
  for (const solver::StepNote& note : r.notes) {
    const int line = line_of(script, note.origin);
    const std::string when = note.step > 0
                                 ? fmt::format("step {} (t = {:.6g}{}): ", note.step, note.t,
                                               ModelUnits::bracketed(report.unit_of_time))
                                 : std::string();
    say("note: {}{}{}\n", when, note.what, line > 0 ? fmt::format(" (line {})", line) : "");
  }
  if (r.energy) say("energy of this branch at the end: {:.9g}{}\n", *r.energy, unit);
}

/// Phases, counted work, and the lower limit of the triangular solves: one read of the factor each.
void print_profile(const solver::RunResult& r, double bandwidth) {
  const auto& t = r.timing;
  const double steps = std::max(1, r.steps);
  const double rest = t.total - t.mesh - t.assembly - t.ordering - t.factor - t.steps - t.output;
  tell("{:<24}{:>12}{:>14}{:>20}\n", "profile", "CPU seconds", "ms per step", "ms, the limit");
  const auto line = [&](const char* name, double seconds, bool each, double limit = 0.0) {
    tell("{:<24}{:>12.4f}{:>14}{:>20}\n", name, seconds,
         each ? fmt::format("{:.4f}", 1e3 * seconds / steps) : "",
         limit > 0.0 ? fmt::format("{:.4f}", 1e3 * limit / steps) : "");
  };
  line("mesh", t.mesh, false), line("assembly", t.assembly, false);
  line("ordering", t.ordering, false), line("factorisation", t.factor, false);
  line("steps", t.steps, true), line("  history (wall)", t.history, true);
  line("  solves (wall)", t.triangular_solves, true, t.factor_bytes_read / bandwidth),
      line("  inequality (wall)", t.inequality, true);
  line("output", t.output, true), line("set-up besides", std::max(0.0, rest), false);
  line("total", t.total, false);
  const auto& w = r.work;
  tell("counted: {} unknowns, {} steps, {} matrices, {} analyses, {} factorisations, {} "
       "triangular solves, {} products, {} Newton, {} fields read {} times\n",
       r.unknowns, r.steps, w.matrices, w.analyses, w.factorisations, w.triangular_solves,
       w.products, w.newton, w.history_fields, w.field_reads);
  if (w.iterative.iterations > 0)
    tell("counted: {} iterations of the iterative solver, {:.3g} a step\n", w.iterative.iterations,
         w.iterative.iterations / steps);
  tell("the limit: every triangular solve reads its factor once, {:.3g} MB in all, at the {:.3g} "
       "GB/s "
       "measured on this machine\nheld: {:.3g} MB (factors, matrices, memory)\n",
       t.factor_bytes_read / 1e6, bandwidth / 1e9, w.bytes / 1e6);
  tell("BLAS: OpenBLAS with its kernels for {}\n{}", solver::blas_kernels().name,
       advice_on_kernels());
}

} // namespace

void print_result(const Session& session, const Options& options, double bandwidth) {
  if (!options.quiet || options.json.empty())
    std::fputs(solver::aligned_text(table_of(session.result, session.script.model->units)).c_str(),
               stdout);
  if (options.quiet) return;
  print_certificate(session.result, session.script);
  if (session.accuracy) std::fputs(accuracy_text(*session.accuracy).c_str(), stdout);
  if (options.profile) print_profile(session.result, bandwidth);
}

} // namespace hvi::lang
