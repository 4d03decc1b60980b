// See among_processes.hpp.
#include "lang/cli/among_processes.hpp"

#include "lang/cli/say.hpp"
#include "lang/diag/failures.hpp"
#include "solver/linear/processes.hpp"
#include "solver/results/helper_of_run.hpp"

namespace hvi::lang {

int among_processes(const std::function<int()>& program) {
  const solver::Processes processes = solver::started_processes();
  if (!processes.several()) return program();
  if (processes.rank > 0) {
    solver::HelperOfRun helper;
    return solver::serve(processes, helper);
  }
  try {
    solver::lead(processes);
  } catch (const solver::Failure& failure) {
    const Ending ending = ending_of(failure.kind);
    tell("error[{}]: {}\n  = help: {}\n", ending.code, failure.what(), failure.help);
    return ending.exit;
  }
  const int code = program();
  if (solver::dismiss(code) == 0 && code == exit_ok)
    tell("note: {} of {} processes had nothing to do: only iterations (`--solver iterative`) use "
         "several\n",
         processes.count - 1, processes.count);
  return code;
}

} // namespace hvi::lang
