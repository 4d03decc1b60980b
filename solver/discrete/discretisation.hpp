// Mesh, parts and space of a plan: what all that is computed on a mesh refers to.
#pragma once

#include "solver/fem/space.hpp"

#include <memory>
#include <vector>

namespace hvi::solver {

class SharedWork;

/// Mesh, parts and space of a plan, made once and shared by run, check and study.
struct Discretisation {
  Mesh mesh;
  std::vector<Region> parts;
  Space space; ///< points into `mesh`
  DofMap dofs;
  double seconds = 0;
  /// Nodes of the first side of a pair that have no partner: how many, and one of them.
  struct Alone {
    int part = 0, points = 0;
    Point first{};
  };
  std::vector<Alone> alone;
  std::shared_ptr<SharedWork> shared; ///< set: what a run computes, later runs on it take over
  Discretisation() = default;
  Discretisation(const Discretisation&) = delete;
  Discretisation& operator=(const Discretisation&) = delete;
};

} // namespace hvi::solver
