// What only the matrices, the loads and the run itself can say about the effects of a plan.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/step/run_state.hpp"

#include <iosfwd>

namespace hvi::solver {

/// How far the points of each law term went along their graphs.
class LawRange {
public:
  explicit LawRange(std::size_t law_terms) : reached_(law_terms, 0), slopes_(law_terms, 0.0) {}
  /// After an accepted step.
  void note(const RunState& run);
  /// Its multiplier was zero at every point and step.
  bool asleep(std::size_t law_term) const { return reached_[law_term] != acted; }
  /// s where the multiplier was s times the argument at every point and step; NaN elsewhere.
  double slope(std::size_t law_term) const { return slopes_[law_term]; }

  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  static constexpr char moved = 1, acted = 2; ///< an argument, a multiplier was not zero
  std::vector<char> reached_;
  std::vector<double> slopes_; ///< 0: no multiplier yet
};

/// Each space dimension, periodic parts, the symmetry of the matrices, and how often each load is
/// assembled.
std::vector<EffectNote> found_effects(const Problem& problem, const Discretisation& discretisation,
                                      const RunState& run);

/// The plan's effects with what a run found: asleep, or linear on the range reached.
std::vector<EffectNote> effects_of_run(const Problem& problem, const LawRange& range);

} // namespace hvi::solver
