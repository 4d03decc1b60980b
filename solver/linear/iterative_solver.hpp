// Iterative solvers of  (K + H) x = b  behind one interface: K the matrix of a step, H what the
// laws at hand add to few of its rows.
#pragma once

#include "solver/linear/iteration_work.hpp"
#include "solver/linear/own_rows.hpp"
#include "solver/linear/pieces.hpp"
#include "solver/linear/sparse.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hvi::solver {

/// What an iterative solver is told of the unknowns besides their matrix.
struct UnknownsOfNodes {
  int components = 1;                  ///< of a node
  std::vector<std::int32_t> node;      ///< of each unknown; numbered from 0 without gaps
  std::vector<std::int32_t> component; ///< of each unknown
  int nodes = 0;
  std::vector<std::int32_t> first_component{0}; ///< of each of several unknowns u, theta, ...
  /// A column each, of one unknown: motions that cost no energy but where values are imposed
  /// (translations and turns, constants). Multigrid has to keep them on every level.
  DenseMatrix motions;
  /// Where the rows of K are dealt out already: of each node its place in the order of the
  /// processes, and how many each of them has. Empty: the solver deals them out.
  std::vector<std::int32_t> place;
  std::vector<int> counts;
  bool several() const { return first_component.size() > 1; }
};

struct IterativeAnswer {
  enum class Outcome {
    solved,
    indefinite, ///< a direction of no or negative curvature: the matrix is not positive definite
    stagnated
  };
  Outcome outcome = Outcome::solved;
  int iterations = 0;
  double reduction = 0.0; ///< of |b - (K + H) x| against |b|
  std::string reason;     ///< in words, where it is not solved
  bool solved() const { return outcome == Outcome::solved; }
};

struct IterativeStatistics {
  int setups = 0, solves = 0;
  int local_factors = 0; ///< of the layers at the contact
  double bytes = 0.0, seconds_setup = 0.0;
  IterationWork work;
};

class IterativeSolver {
public:
  virtual ~IterativeSolver() = default;
  /// The entries of K, which was given where the solver was made, have changed. What was set up for
  /// the last ones goes on serving while it does not take many more iterations.
  virtual void matrix_changed() = 0;
  /// A column for each motion that K all but takes to 0, so that the laws alone hold it.
  virtual void set_free_motions(const DenseMatrix& motions) = 0;
  /// H from now on; kept by reference. False: K + H has no factor on the layers at the contact, so
  /// that it is not positive definite (symmetric), or singular.
  virtual bool set_laws(const SparseMatrix& h, bool symmetric) = 0;
  /// The H that was set last; null: none.
  virtual const SparseMatrix* laws() const = 0;
  /// Called after iterations, not more than a few apart; what it throws ends the solve, of all
  /// processes, and is thrown by it.
  virtual void call_between_iterations(std::function<void()> what) = 0;
  /// x with |b - (K + H) x| <= reduction |b|.
  virtual IterativeAnswer solve(const Vector& b, double reduction, Vector& x) = 0;
  virtual const IterativeStatistics& statistics() const = 0;
};

/// Rows of K that each process has for itself (own_rows.hpp).
struct DealtRows {
  std::uint64_t set = 0;
  int matrix = 0;
  std::function<RowArrays()> place; ///< as they are now in all processes; those of the first one
  std::function<void()> leave;      ///< they were read
};

/// Can the module libhvi_petsc be loaded? It is, then.
bool petsc_is_there();

/// Of PETSc, from the module libhvi_petsc, which is opened now. `k` is kept by reference: its
/// arrays stay where they are. Throws Failure(missing_file) where the module cannot be loaded.
std::unique_ptr<IterativeSolver> petsc_solver(const SparseMatrix& k, bool symmetric,
                                              const UnknownsOfNodes& unknowns);
/// The same where each process has its rows of K; `pieces`: of all of it. They are placed, read and
/// left now and in each call of matrix_changed.
std::unique_ptr<IterativeSolver> petsc_solver(DealtRows k, Pieces pieces, bool symmetric,
                                              const UnknownsOfNodes& unknowns);

} // namespace hvi::solver
