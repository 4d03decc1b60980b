// Has every step of a run one solution, whatever its load?
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/linear/factorisation.hpp"

#include <string>
#include <vector>

namespace hvi::solver {

/// How steeply the slopes of the laws fall, by proof.
struct LawDescent {
  std::string obstacle;       ///< why that is not known, or says nothing of the steps
  std::vector<double> weight; ///< steepest descent of each law term's slope
  bool softens = false;       ///< some fall
  bool moves = false;         ///< some laws depend on place or time
};
LawDescent descent_of_laws(const Problem& problem, const Operators& operators,
                           const Contact& contact);

/// Why a run does not promise one solution in every step; empty: every step has exactly one, as
/// sym K_n - sum_i m_i M_i^T W M_i is positive definite for the matrix K_n of every step, with m_i
/// the steepest descent of law i, by proof (Cholesky factors: up to rounding).
class Uniqueness {
public:
  Uniqueness(const Problem& problem, const Operators& operators, const Contact& contact);

  /// There are no laws, or none softens and the factor of a symmetric K says the rest, or they
  /// cannot be judged: nothing is left to be asked of the matrices.
  bool settled() const { return settled_; }
  bool softens() const { return laws_.softens; }
  /// All steps have one matrix, and the condensed problem can be asked: `judge` it.
  bool condensed() const { return condensed_; }
  void judge(bool convex);
  /// The same of forms that are not symmetric: `judge_condensed` S, dense, of a step's K.
  bool condensed_without_symmetry() const { return unsymmetric_; }
  void judge_condensed(const SparseMatrix& k, const DenseMatrix& s);
  /// Judges the matrices of all steps on all unknowns. `like`: a factor of one of them, whose
  /// analysis is taken over; or null.
  void judge_all(const Factorisation* like);

  const std::string& obstacle() const { return laws_.obstacle; }
  bool holds() const { return laws_.obstacle.empty(); }

private:
  std::string too_soft() const;

  const Problem& problem_;
  const Operators& operators_;
  const Contact& contact_;
  LawDescent laws_; ///< its obstacle is that of the run
  bool settled_ = false, condensed_ = false, unsymmetric_ = false;
};

/// sum_i weight_i M_i^T W M_i on the unknowns, weight_i per law term.
SparseMatrix law_form(const Contact& contact, const std::vector<double>& weight, int n_unknowns);
/// The weights of laws in a step whose fields have these factors: a law on u' descends in the
/// increment as much faster as u' does.
std::vector<double> in_step(const Contact& contact, std::vector<double> weight,
                            const Vector& of_fields);

} // namespace hvi::solver
