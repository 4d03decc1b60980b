// What is shown of a run, besides numbers: a frame for each picture of the plan, and frames at many
// steps for a viewer. Of no cost where nobody asks.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/frames.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/run_settings.hpp"

#include <algorithm>
#include <iosfwd>
#include <optional>
#include <vector>

namespace hvi::solver {

struct Shown {
  // What is wanted
  std::vector<FieldSpec> fields; ///< kept with the points of all laws
  int most_frames = 40;          ///< of them, at even distances and at the end
  // What came of it
  /// For each of the plan's pictures its frame, or those of a moving picture; empty: the run did
  /// not end.
  std::vector<std::vector<FieldFrame>> pictures;
  std::vector<FieldFrame> frames; ///< of a run that is gone on from a checkpoint: from there on
  int since = 0;                  ///< the step of that checkpoint; 0: `frames` are of the whole run
};

/// A picture whose file is `NAME.apng` moves: so many frames of it at even distances, and the end.
inline constexpr int most_moving_frames = 60;
bool moves(const PictureSpec& picture);

/// `run` (run.hpp), and what is shown of it.
RunResult run_shown(const Plan& plan, const Discretisation& discretisation,
                    const RunSettings& settings, Shown& shown, RunResult* partial = nullptr);

/// Makes the frames of one run; used by the reporter.
class ShownFrames {
public:
  /// `out` loses what it holds.
  ShownFrames(const Plan& plan, const Discretisation& discretisation, const Contact& contact,
              Shown& out);

  std::vector<Expr> expressions() const;
  /// Is anything kept of this step?
  bool keeps(int step, bool last) const;
  /// `now` is that step.
  void keep(const Snapshot& now, const RunState& run, bool last);
  /// `now` is the last step, of a run that is restored there: what moves has it already.
  void keep_end(const Snapshot& now, const RunState& run);
  /// Picture i at its own time.
  void take(std::size_t i, const Snapshot& then) { taken_[i] = {pictures_[i].at(then, nullptr)}; }
  void finish(const Snapshot& end);

  void save(std::ostream& out) const;
  /// `now`: any snapshot of the run.
  void restore(std::istream& in, const Snapshot& now);

private:
  static bool due(int every, int step, bool last) {
    return every > 0 && (last || step % every == 0);
  }

  Shown& out_;
  std::vector<FrameMaker> pictures_;
  std::vector<int> moving_; ///< by picture: every so many steps; 0: it does not move
  std::vector<std::vector<FieldFrame>> taken_; ///< by picture that has a time or moves
  std::optional<FrameMaker> kept_;
  int every_ = 0; ///< frames are kept; 0: none
};

} // namespace hvi::solver
