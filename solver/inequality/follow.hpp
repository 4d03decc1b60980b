// The branch that continues the last state, where a step may have several solutions (follow.cpp).
#pragma once

#include "solver/inequality/least_state.hpp"

namespace hvi::solver {

/// Has the reduced problem one solution for every load? (convexity.cpp)
bool is_convex(const ContactPoints& points, const StiffnessPattern& pattern, LastFactor& factor);

class BranchFollower {
public:
  BranchFollower(const ContactPoints& points, const StiffnessPattern& pattern, LastFactor& factor,
                 ActiveSetNewton& newton, ComponentSearch& components,
                 const InequalityOptions& options);
  /// Is the problem known to be convex? Not before `follow` had to look.
  bool known_convex();
  /// What is known of the laws as they are now; to look costs the factor, so a saved solver tells.
  std::optional<bool> convexity() const;
  void restore(std::optional<bool> convexity);
  /// The answer of a step that was solved at once becomes the one that continues the last state;
  /// with Branch::least_energy the best of what is found.
  void follow(StepAnswer& step);

private:
  bool convex();
  void continue_branch(StepAnswer& step, const Vector& free, const Vector& b1);
  bool settle_on(const CurveSolution& found, StepAnswer& step);

  const ContactPoints& points_;
  const StiffnessPattern& pattern_;
  LastFactor& factor_;
  ActiveSetNewton& newton_;
  ComponentSearch& components_;
  const InequalityOptions& options_;
  PointCurve curve_;
  std::optional<bool> convex_; ///< for the laws of `revision_`
  int revision_ = 0;
};

} // namespace hvi::solver
