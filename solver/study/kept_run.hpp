// Runs that are kept to be compared: states at some of the steps, columns of the probes, seconds.
#pragma once

#include "solver/discrete/shared_work.hpp"
#include "solver/results/shown.hpp"
#include "solver/study/predict.hpp"
#include "solver/time/run.hpp"

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace hvi::solver {

struct KeptRun {
  Setting setting;
  Plan plan;
  std::shared_ptr<const Discretisation> discretisation;
  Vector first;           ///< at the initial time
  std::vector<int> steps; ///< at which states are kept
  std::vector<Vector> states;
  RunResult result;
  CostPoint cost{}; ///< without the table
  double row = 0.0; ///< seconds of one row of the table
  double cpu = 0.0;
  std::string failure; ///< "": certified
  bool failed_by_rounding = false;
};

/// Relative distance of the coarser to the finer run, largest over the times both have: in V, or of
/// a probe (relative to its largest magnitude, or where that is rounding to what its rounding is
/// relative to; NaN where no row of both has a value).
double distance(const KeptRun& coarse, const KeptRun& fine, const std::string& probe);

/// Makes runs of a family; meshes and spaces are shared between runs of one level and element.
class Runner {
public:
  /// `shown`: of the final run; null: nothing is.
  Runner(const SettingFamily& family, const RunSettings& settings, Shown* shown)
      : family_(family), settings_(settings), shown_(shown) {}

  /// The run at a setting, made once. A setting that cannot be solved has its reason in `failure`.
  const KeptRun& cheap(const Setting& setting);
  /// The same with the caller's own settings (files, progress); a failure is thrown.
  const KeptRun& final_run(const Setting& setting);

  /// What runs took over from earlier ones on their mesh.
  Spared spared() const;

private:
  KeptRun make(const Setting& setting, const RunSettings& settings, bool final);
  std::shared_ptr<const Discretisation> discretisation_of(const Setting& setting, const Plan& plan);

  const SettingFamily& family_;
  const RunSettings& settings_;
  Shown* shown_;
  std::map<Setting, KeptRun> runs_;
  std::map<std::tuple<int, int, double>, std::shared_ptr<const Discretisation>> meshes_;
};

} // namespace hvi::solver
