// Unknowns that live on a part of the mesh are read there only.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"

#include <array>
#include <vector>

namespace hvi::solver {

/// Failure(bad_value) for each form, load, law, state and probe that sees an unknown where its
/// space has no functions. What is said to count in a part only (inside) is not seen elsewhere.
std::vector<Failure> outside_domains(const Plan& plan, const Discretisation& discretisation);

/// The cells of a part, or of the mesh (-1), in which all unknowns that an expression reads live.
class ReadingCells {
public:
  ReadingCells(const Discretisation& d, const Expr& expression, int part = -1);
  bool has(int cell) const;

private:
  const Space& space_;
  std::vector<char> of_part_; ///< by cell; empty: all are
  std::array<bool, slot::most_unknowns> read_{};
};

/// The one of them around a point, with the point's coordinates there; -1: none. `found`: what the
/// mesh says, which is tried first.
int cell_that_reads(const Discretisation& d, const Expr& expression, const Point& point, int found,
                    std::array<double, 4>& barycentric, int part = -1);

} // namespace hvi::solver
