// How a problem is solved.
#pragma once

#include "solver/common/factor_entries.hpp"
#include "solver/kernel/kernel_spec.hpp"
#include "solver/law/branch.hpp"

#include <optional>
#include <string_view>

namespace hvi::solver {

/// How the linear systems of steps are solved.
enum class LinearSolver {
  direct,           ///< a factor of the matrix, condensed to the contact unknowns
  iterative,        ///< conjugate gradients with multigrid, on all unknowns
  automatic,        ///< which of both is predicted to take less time, of those that fit
  direct_if_it_fits ///< iterative where a factor does not fit into the memory
};

/// "direct", "iterative" or "automatic"; nothing: no such word.
inline std::optional<LinearSolver> linear_solver_of(std::string_view word) {
  if (word == "direct") return LinearSolver::direct;
  if (word == "iterative") return LinearSolver::iterative;
  if (word == "automatic") return LinearSolver::automatic;
  return std::nullopt;
}

/// "double" or "single"; nothing: no such word.
inline std::optional<FactorEntries> factor_entries_of(std::string_view word) {
  if (word == "double") return FactorEntries::doubles;
  if (word == "single") return FactorEntries::singles;
  return std::nullopt;
}

struct SolverOptions {
  LinearSolver solver = LinearSolver::direct_if_it_fits;
  FactorEntries factor = FactorEntries::doubles; ///< of symmetric matrices of one unknown
  double tolerance = 1e-10;                      ///< certificate
  double memory_tolerance = 1e-8;
  HistoryRoute route = HistoryRoute::automatic;
  Branch branch = Branch::continuing;
  int threads = 1;
  bool proportional_path = true; ///< the evolution on contact unknowns where it is possible
  bool rows_refused = false;     ///< a run has tried that: a step was not certified on all rows
  bool jumps_as_unknowns = true; ///< across pairs, where that is possible
  bool reduced_precision = true; ///< the factor with fewer bits an entry where that is enough
  bool audit = true;             ///< replay a few scalars of the memory against the direct sum
};

} // namespace hvi::solver
