// The search for a wanted accuracy: cheap ladders -> laws of error and cost -> the cheapest setting
// -> its run -> a check of it against runs of half the resolution; again where that says no.
#pragma once

#include "solver/discrete/shared_work.hpp"
#include "solver/results/shown.hpp"
#include "solver/study/predict.hpp"
#include "solver/time/run.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

struct AccuracyRequest {
  double wanted = 1e-2;       ///< relative error, largest over the steps
  std::string probe;          ///< of this column; "": of u in the norm of V
  bool as_written = false;    ///< element, scheme and grading stay the plan's: only h and k vary
  double most_seconds = 3600; ///< CPU time a setting may be predicted to cost
  double most_unknowns = 3e6, most_steps = 1e6;
};

/// One run the search made, and its distance (relative) to the one it is compared with.
struct AccuracyRun {
  Setting setting;
  std::string text, purpose, failure;
  int unknowns = 0;
  double cpu = 0.0;
  std::optional<double> distance;
  std::string against;
};

/// A setting that was chosen, what was predicted of it and what came.
struct AccuracyTry {
  Setting setting;
  std::string text;
  int unknowns = 0, steps = 0;
  double predicted_error = 0.0, predicted_cpu = 0.0, cpu = 0.0;
  double space_distance = 0.0, time_distance = 0.0; ///< to half the level, to half the steps
  double space_order = 0.0, time_order = 0.0;
  double space_error = 0.0, time_error = 0.0, estimate = 0.0;
};

struct AccuracyResult {
  AccuracyRequest request;
  bool reached = false;
  std::vector<AccuracyRun> runs;
  std::vector<AccuracyTry> tries; ///< the last one is the result
  double cpu = 0.0;               ///< of everything
  double memory_tolerance = 0.0;
  Spared spared; ///< what runs took over from earlier ones on the same mesh
  RunResult run;
  Plan plan; ///< at the last setting
  std::shared_ptr<const Discretisation> discretisation;
};

/// No setting within the limits reaches it, or the evidence never said so: `so_far` has the runs.
struct AccuracyFailure : Failure {
  AccuracyFailure(const std::string& message, AccuracyResult result)
      : Failure(FailureKind::out_of_reach, {}, message), so_far(std::move(result)) {}
  AccuracyResult so_far;
};

/// Factor between the estimated error and what is compared with the wanted one.
inline constexpr double accuracy_safety = 1.2;

/// Runs until the estimate (with safety) is below the wanted error. `settings` are those of the run
/// whose result is kept, and so is `shown` (null: nothing is); `tell` is shown what is going on, a
/// line at a time.
/// Throws AccuracyFailure, Failure(interrupted), and what a plan's own mistakes throw.
AccuracyResult reach_accuracy(const Plan& plan, const AccuracyRequest& request,
                              const RunSettings& settings,
                              const std::function<void(const std::string&)>& tell,
                              Shown* shown = nullptr);

} // namespace hvi::solver
