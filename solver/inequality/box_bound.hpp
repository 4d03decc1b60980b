// Lower bounds of the split energy (split_energy.hpp) on boxes of arguments.
#pragma once

#include "solver/inequality/split_energy.hpp"

namespace hvi::solver {

struct EnergyBox {
  double bound; ///< no state in the box has less energy
  Vector low, high, multiplier;
  bool operator<(const EnergyBox& other) const { return bound > other.bound; }
};

/// The lowest energy known, and the size of the energies that it is a sum of.
struct LowestEnergy {
  double value = 0.0, scale = 0.0;
};

/// The box that holds every state of less energy than the lowest known; nothing where there is
/// none.
std::optional<EnergyBox> first_box(const SplitEnergy& energy, const LowestEnergy& lowest);

/// Where to halve a box.
struct EnergyCut {
  int point;
  double at;
};

/// The convex problem on a box, by its dual: with multipliers lambda,
///
///     shift + lambda^T b~ - lambda^T (C^-1 - D)^-1 lambda / 2 - sum_p phi*_p(lambda_p)
///
/// is a lower bound of the energy, phi* the conjugate of phi made convex on the box.
class BoxBound {
public:
  /// With the box's multipliers. `cells`: of each point, over the first box.
  BoxBound(const SplitEnergy& energy, const std::vector<std::vector<EnergyCell>>& cells,
           const EnergyBox& box);
  /// Brings the bound and the multipliers of the box closer to the best ones, coordinate by
  /// coordinate, as long as the bound gets closer to the lowest energy by that.
  void raise(EnergyBox& box, const LowestEnergy& lowest);
  /// The point at whose argument the bound is worst; nothing where rounding is all that is left.
  std::optional<EnergyCut> worst(const EnergyBox& box);
  /// Forces on the body that belong to the multipliers.
  Vector forces() const;
  double work() const { return work_; } ///< segments looked at, and entries of products

private:
  double conjugate_at(int p, double& at);
  void improve(int p, double low, double high);
  double value();
  void take(const Vector& multiplier);

  const SplitEnergy& energy_;
  std::vector<std::vector<EnergySegment>> segments_;
  Vector lambda_, c_lambda_; ///< multipliers, and (C^-1 - D)^-1 times them
  double work_ = 0.0;
};

} // namespace hvi::solver
