// Points whose law has a bound that is another law's multiplier (Coulomb's friction), with the
// graphs that the bounds give them.
#pragma once

#include "solver/inequality/position.hpp"

namespace hvi::solver {

struct CoupledBound {
  int point = 0, normal = 0; ///< points: the coupled one, and the one whose multiplier it reads
  Point x{};
  LawGraph graph;
  double multiplier = 0.0; ///< of the normal law
  double rate = 0.0;       ///< d slope / d multiplier at the point's place on its graph
  bool known = false;      ///< graph belongs to multiplier
};

/// Takes the coupled points' laws and the penalties of all points over, and gives them back.
class CoupledBounds {
public:
  CoupledBounds(ContactPoints& points, Position& at);
  ~CoupledBounds();
  CoupledBounds(const CoupledBounds&) = delete;
  CoupledBounds& operator=(const CoupledBounds&) = delete;

  /// Bounds know this part of the multiplier. At 0 the laws are plain ones.
  double share() const { return share_; }
  void set_share(double value);
  void set(CoupledBound& b, double multiplier);
  LawGraph graph(const CoupledBound& b, double multiplier) const; ///< in the present share of it
  bool is_coupled(int p) const { return bound_of_[p] >= 0; }
  /// d slope / d multiplier at the point's place now.
  double slope_rate(const CoupledBound& b) const;
  Small slip(const CoupledBound& b) const; ///< its direction; 0 where the point rests

  std::vector<CoupledBound> all;

private:
  ContactPoints& points_;
  Position& at_;
  std::vector<double> penalties_; ///< those that the points had
  std::vector<int> bound_of_;     ///< by point; -1: a law of its own
  double share_ = 1.0;
};

} // namespace hvi::solver
