// Lines on the memory and the solver for run and plan.
#include "lang/cli/memory_lines.hpp"

#include "lang/cli/say.hpp"
#include "solver/linear/blas_kernels.hpp"

#include <fmt/format.h>

namespace hvi::lang {

namespace {

std::string figures(const solver::HistoryReport& h) {
  std::string text = h.fields > 0 ? fmt::format("{} fields", h.fields) : "fields as it goes";
  if (h.route == "direct") return text;
  if (h.error > 0 || h.audits > 0)
    text += fmt::format(", error {:.1e}{}", h.error, h.verified ? "" : " by samples");
  if (h.bound > 0) text += fmt::format(", at most {:.1e} in its values", h.bound);
  if (h.audits > 0)
    text +=
        fmt::format(", audit {:.1e} in {} sums up to step {}", h.audit, h.audits, h.audited_until);
  return text;
}

} // namespace

void print_memory(const solver::Problem& problem,
                  const std::vector<solver::HistoryReport>& reports) {
  for (const solver::EffectNote& effect : problem.effects)
    if (effect.name.starts_with("Prony sum")) say("{}: {}\n", effect.name, effect.why);
  for (std::size_t m = 0; m < reports.size(); ++m)
    say("memory `{}`: {} ({}): {}\n", problem.histories[m].kernel.name, reports[m].route,
        figures(reports[m]), reports[m].why);
}

void print_solver(const solver::ChosenSolver& chosen) {
  if (chosen.why.empty()) return;
  const bool iterative = chosen.solver == solver::LinearSolver::iterative;
  say("linear systems: {}: {}\n", iterative ? "iterations" : "a factor", chosen.why);
}

std::string advice_on_kernels() {
  const solver::BlasKernels kernels = solver::blas_kernels();
  if (!kernels.outgrown) return {};
  return fmt::format(
      "note: OpenBLAS takes its kernels for {} here and has some for AVX-512, which this processor "
      "knows: with OPENBLAS_CORETYPE=SkylakeX in the environment large factors take less time\n",
      kernels.name);
}

} // namespace hvi::lang
