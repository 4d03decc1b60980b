// How far a model can be trusted: one run with monitors, the margins of the theory, and runs that
// differ from it by one unit in the last place or by a choice of the solver.
#pragma once

#include "lang/session.hpp"
#include "solver/hypotheses/hypotheses.hpp"

#include <atomic>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

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

/// Runs the session's plan, and its script and mesh with moved numbers; `settings` are those it was
/// compiled with. Throws where the first run fails, Failure(interrupted) on `stop`, and
/// Failure(missing_file) where a file cannot be read again.
Stability examine(const Session& session, const CompileSettings& settings,
                  const std::atomic<bool>* stop);

} // namespace hvi::lang
