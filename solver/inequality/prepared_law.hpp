// A law's graph prepared for the solvers: components between downward jumps, each extended beyond
// its ends and made monotone by a shift, and the resolvent (prox) of a component.
#pragma once

#include "solver/law/law.hpp"

#include <vector>

namespace hvi::solver {

/// Where a resolvent lands on the graph: state as in InequalityState, argument, slope, curvature.
struct GraphPoint {
  int state = 0;
  double z = 0.0, s = 0.0, d = 0.0;
};

/// Pieces first..last with no downward jump between them. Outside, the component goes on along its
/// tangent, so that its potential there lies above the law's: leaving it lowers the energy.
struct LawComponent {
  int first = 0, last = 0;
  double low = 0.0, high = 0.0; ///< where the next component begins; infinite where there is none
  double m = 0.0;               ///< slope + m r is nondecreasing (radial: (slope + m r)/r too >= 0)
  bool proved = true;           ///< no steeper descent exists; else none was seen
  double low_s = 0.0, low_d = 0.0, high_s = 0.0, high_d = 0.0; ///< the tangents at the ends
};

class PreparedLaw {
public:
  PreparedLaw(const Law& law, const LawGraph& graph);

  bool radial() const { return radial_; }
  const LawGraph& graph() const { return *graph_; }
  const Law& law() const { return *law_; }
  /// The largest limit of the slope at a break or at 0: what |xi| is compared with.
  double slope_scale() const { return slope_scale_; }
  int components() const { return static_cast<int>(components_.size()); }
  const LawComponent& component(int k) const { return components_[k]; }
  int component_of_piece(int piece) const { return component_of_[piece]; }
  /// Does the slope fall somewhere on this piece (radial: or across the direction of slip)?
  bool softens(int piece) const { return softens_[piece] != 0; }
  /// Is this state one the graph has?
  bool valid_state(int state) const;

  /// Slope and curvature of an extended component at z (radial: z >= 0).
  GraphPoint on_component(int k, double z) const;
  /// The point of the extended component with (1 + gamma m) z + gamma s = y, s in its graph at z;
  /// radial: y >= 0, state -1 when y does not exceed gamma times the slope at the origin.
  /// `hint` is a state near the answer. Exists and is unique for every gamma > 0.
  GraphPoint resolvent(int k, double y, double gamma, const GraphPoint& hint) const;

private:
  void add_component(int first, int last);
  double descend(int piece, LawComponent& c) const;
  double descent_across(int piece, double low, double high) const;
  GraphPoint solve_inside(const LawComponent& c, int piece, double y, double a, double gamma,
                          double guess) const;
  GraphPoint iterate(int piece, double y, double a, double gamma, double guess) const;

  const Law* law_;
  const LawGraph* graph_;
  bool radial_;
  double slope_scale_ = 0.0;
  std::vector<LawComponent> components_;
  std::vector<int> component_of_;
  std::vector<char> softens_; ///< by piece
};

} // namespace hvi::solver
