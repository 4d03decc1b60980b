// What a run's pictures and lines show, taken when their time has come.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/line_values.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/shown.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

class WrittenFiles;

/// The state at a time inside the last step.
using StateAt = std::function<const Snapshot&(double)>;

class RunPictures {
public:
  /// All of them outlive it. `shown`: null where no frames are.
  RunPictures(const Plan& plan, const Discretisation& d, const Contact& contact, Shown* shown);

  /// What they read.
  std::vector<Expr> expressions() const;
  /// Has one a time of its own?
  bool timed() const;
  /// Are frames of the step kept?
  bool keeps(int step, bool last) const { return shown_ && shown_->keeps(step, last); }
  void keep(const Snapshot& now, const RunState& run, bool last) { shown_->keep(now, run, last); }
  /// The frame of the end alone, of a run that is restored there.
  void keep_end(const Snapshot& end, const RunState& run) {
    if (shown_) shown_->keep_end(end, run);
  }
  /// Those whose time lies in the step from `from` to `to`, which is the first one or is not.
  void take_between(double from, double to, bool first, const StateAt& at);
  /// Those without a time.
  void take_at_end(const Snapshot& now);
  /// `end`: the state at the last step, null where the run did not come so far.
  void finish(const Snapshot* end, RunResult& result);
  /// The files of the lines, in the folder.
  void write_lines(const std::filesystem::path& folder, const std::string& name,
                   WrittenFiles& files) const;

  void save(std::ostream& out) const;
  /// `now`: any snapshot of the run.
  void restore(std::istream& in, const Snapshot& now);

private:
  void show(std::size_t picture, const Snapshot& snapshot);

  const Plan& plan_;
  const Discretisation& discretisation_;
  const Contact& contact_;
  std::vector<PictureValues> pictures_; ///< by picture, when its time has come
  std::vector<LineValues> lines_;
  std::optional<ShownFrames> shown_;
};

} // namespace hvi::solver
