// Laws of error and of cost, fitted to a few cheap runs, and the cheapest setting they predict.
//
//   error(level, steps) = c_s (1/level)^p_s + c_t (1/steps)^p_t,   cost = setup + steps per_step
#pragma once

#include "solver/study/settings.hpp"

#include <functional>
#include <optional>
#include <span>

namespace hvi::solver {

/// error(r) = at_one r^-order, r the resolution (level or steps). `seen`: from so many distances.
struct ErrorLaw {
  double at_one = 0.0, order = 1.0;
  int seen = 0;
  double at(double resolution) const;
};

/// How the distance of two runs, resolutions r and `ratio` r, relates to their errors.
enum class Distance {
  additive,  ///< the finer error is a part of the coarser: D = e(r) - e(ratio r)
  orthogonal ///< Galerkin errors in the norm of V: D^2 = e(r)^2 - e(ratio r)^2
};
/// e(ratio r) of an error of that order, from the distance.
double finer_error(double distance, double ratio, double order, Distance kind);
double coarser_error(double distance, double ratio, double order, Distance kind);

/// Distances between neighbours of a ladder: resolution (of the coarser), ratio, distance. The
/// order is what the last two show, at most `nominal` (before the asymptotic range more is luck)
/// and at least 0.4; with one distance three quarters of the nominal order. Distances below `floor`
/// are rounding: no error to be seen.
struct Rung {
  double resolution, ratio, distance;
};
/// A ladder stays sorted; a rung of the same resolution is replaced.
void add_rung(std::vector<Rung>& rungs, const Rung& rung);
ErrorLaw fit_error(std::span<const Rung> rungs, double nominal, Distance kind, double floor);

/// Seconds of a run by its unknowns: setup and one step, each a fixed part and a power.
struct CostPoint {
  double unknowns, setup, step;
};
struct CostLaw {
  CostPoint at{}, overhead{}; ///< a run, and what the smallest run costs whatever its size
  double setup_power = 1.2, step_power = 1.1;
  double seconds(double unknowns, double steps) const;
};
/// From the two largest runs; powers are kept within [1, 1.5] and [1, 1.25] in 2D, [1, 2] and
/// [1, 1.4] in 3D (factor and triangular solves of a nested dissection).
CostLaw fit_cost(std::span<const CostPoint> points, int dim);

/// What is known of one element and one scheme together.
struct Candidate {
  int order = 1;
  Scheme scheme = Scheme::backward_euler;
  double grade = 1.0;
  ErrorLaw space, time;
  CostLaw cost;
  double unknowns_at_one = 0.0; ///< unknowns(level) = this level^dim
  int base = 0;                 ///< of time
};
struct Choice {
  Setting setting;
  double error = 0.0, seconds = 0.0, unknowns = 0.0;
};
/// The cheapest setting with predicted error <= target, its companions of half the resolution
/// included in the cost. None where no setting within `most_unknowns` and `most_steps` has it.
std::optional<Choice> cheapest(std::span<const Candidate> candidates, const SettingFamily& family,
                               double target, double most_unknowns, double most_steps);

} // namespace hvi::solver
