// The bilinear forms of a plan as few matrices as possible.
//
// Every form belongs to a field: u' (A), u (B) or w_m (E_m). Each field's operator is a combination
// of the same base matrices T_b,   A = sum_b weight(1, b) T_b,  B = sum_b weight(0, b) T_b, ...
// so proportional tensors share one matrix, and a product with B and E together reads it once.
#pragma once

#include "solver/discrete/chosen_solver.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"
#include "solver/linear/iterative_solver.hpp"
#include "solver/linear/symmetric_blocks.hpp"
#include "solver/plan/couplings.hpp"
#include "solver/plan/problem.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace hvi::solver {

class DealtMatrices;

struct Operators {
  std::vector<SparseMatrix> bases; ///< unknowns x state
  /// If not empty, of the base matrices the upper halves are kept only (halved_bases.hpp), and
  /// `bases` has empty ones in their places.
  std::vector<SymmetricBlocks> halves;
  DenseMatrix weights;   ///< fields (slot::field numbering) x bases
  bool symmetric = true; ///< all of them, on the unknowns
  bool mirrored = true;  ///< and by their coefficients already
  /// Unknowns that act on each other: pivots of K are chosen by size, its symmetry is not used.
  bool coupled = false;
  int n_unknowns = 0;
  /// Base matrices whose forms read states, with these: they are those of the states at hand
  /// (body_states.hpp).
  std::vector<std::pair<int, const FormTerm*>> changing;
  /// If set, the number of contact unknowns, which come first: they are coupled with no others, and
  /// the others with none.
  std::optional<int> separate;
  /// Set: several processes have the rows of the base matrices, and `bases` has empty ones in their
  /// places.
  std::shared_ptr<DealtMatrices> dealt;
  SharedWork* shared = nullptr; ///< of the discretisation; factors may be had from there
  ChosenSolver chosen;
  /// Set: systems are solved by iterations on all unknowns, which are these.
  std::shared_ptr<const UnknownsOfNodes> iterative;
  double memory_to_come = 0.0; ///< bytes that a run will take besides its factors

  /// Is this the matrix of a form that reads states?
  bool changes(int b) const {
    return std::ranges::any_of(changing, [b](const auto& form) { return form.first == b; });
  }
  int n_bases() const { return static_cast<int>(bases.size()); }
  int n_fields() const { return static_cast<int>(weights.rows()); }
  /// Does any form act on this field?
  bool acts_on(int field) const { return !weights.row(field).isZero(0.0); }
};

/// Assembles what is distinct: terms with the same part, rule and proportional coefficients are
/// assembled once, equal patterns are compared by value, and bases that always occur in the same
/// ratio (the same material law on two parts) are added up. `threads`: so many terms at a time.
/// `by_values`: else matrices that are equal and were not written so stay apart, as where several
/// processes have their rows (dealt_operators.hpp): checkpoints know the base matrices.
Operators assemble_operators(const Problem& problem, const Discretisation& discretisation,
                             const StateLayout& layout, int threads, bool by_values = true);

/// Of each term its matrix: rows for the layout's unknowns, columns for its states.
std::vector<SparseMatrix> assemble_terms(const Discretisation& discretisation,
                                         const StateLayout& layout,
                                         std::span<const FormTerm* const> terms, int threads);

/// Unknowns that no form couples have no entries in common: they are apart in memory and factors.
void take_apart(const Couplings& couplings, const Space& space, const StateLayout& layout,
                std::vector<SparseMatrix>& matrices);

/// Of a matrix's largest entry: the rounding of an assembly.
inline constexpr double asymmetry_of_rounding = 1e-12;
/// Are entries that far from their mirror images at most?
bool symmetric_to_rounding(const SparseMatrix& matrix);

/// The sum of the plan's forms on one field, on all dofs, with the initial states.
SparseMatrix matrix_of_field(const Problem& problem, const Discretisation& discretisation,
                             int field);

/// The columns of a base matrix that belong to unknowns.
SparseMatrix on_unknowns(const SparseMatrix& base, int n_unknowns);

/// sum_b gamma_b T_b on the unknowns; its pattern does not depend on gamma.
SparseMatrix combine(const Operators& operators, const Vector& gamma);

} // namespace hvi::solver
