// See factored_matrix.hpp.
#include "solver/formulation/factored_matrix.hpp"

#include "solver/inequality/iterative_operator.hpp"
#include "solver/linear/changed_unknowns.hpp"
#include "solver/linear/condition_estimate.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/indefinite.hpp"
#include "solver/linear/iterative_factorisation.hpp"
#include "solver/linear/separate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hvi::solver {
namespace {

SharedFactor own(std::unique_ptr<Factorisation> factor) {
  return {std::move(factor), false, false};
}

/// Not factored yet.
std::unique_ptr<Factorisation> analyse_changed(const Operators& operators, const Contact& contact,
                                               const SparseMatrix& k, FactorEntries entries) {
  const SparseMatrix changed = contact.change->congruent(k);
  return with_changed_unknowns(
      operators.coupled ? coupled_factor(changed, contact.unknowns, contact.of_unknown)
                        : analyse(changed, contact.unknowns, operators.symmetric, nullptr, entries),
      contact.change);
}

/// Of K. `shared`: may have it already; `like`: shares its analysis; both may be null.
SharedFactor make_factor(const Operators& operators, const Contact& contact, const SparseMatrix& k,
                         SharedWork* shared, const FactoredMatrix* like, FactorEntries entries) {
  if (operators.separate) {
    auto out = own(separate_factor(*operators.separate, operators.n_unknowns));
    out->factor(k);
    return out;
  }
  if (operators.coupled && !contact.change) {
    auto out = own(coupled_factor(k, contact.unknowns, contact.of_unknown));
    factor_where_it_fits(*out, k, contact.unknowns.size(), operators.memory_to_come);
    return out;
  }
  if (shared == nullptr && like != nullptr && like->factorisation()) {
    auto out = own(like->factorisation()->another());
    factor_where_it_fits(*out, k, contact.unknowns.size(), 0.0);
    return out;
  }
  if (contact.change) {
    auto out = own(analyse_changed(operators, contact, k, entries));
    factor_where_it_fits(*out, k, contact.unknowns.size(), operators.memory_to_come);
    return out;
  }
  return take_factor(shared, k, contact.unknowns, operators.symmetric, operators.memory_to_come,
                     entries);
}

} // namespace

/// The first factor may be shared with another run, and is then replaced by one of this run; a
/// factor of this run is made anew in its place.
void FactoredMatrix::factor(const Vector& gamma) {
  if (gamma.size() != operators_.n_bases())
    throw std::invalid_argument("a coefficient for each base matrix is needed");
  gamma_ = gamma;
  if (operators_.dealt) return factor_dealt();
  SparseMatrix k = combine(operators_, gamma);
  set_matrix(k);
  half_ = {};
  free_ = motions_.empty() ? nullptr : find_free_body(motions_, k_, *layout_);
  if (operators_.iterative) return prepare_iterations();
  if (contact_.whole) return;
  const SparseMatrix instead = free_ ? held() : SparseMatrix();
  const SparseMatrix& matrix = free_ ? instead : k_;
  if (factorisation_ && !factorisation_.is_shared()) {
    factorisation_->factor(matrix);
    return;
  }
  auto* const shared = factorisation_ ? nullptr : operators_.shared;
  factorisation_ =
      make_factor(operators_, contact_, matrix, shared, std::exchange(like_, nullptr), entries_);
}

void FactoredMatrix::factor_dealt() {
  if (!dealt_) dealt_ = std::make_unique<DealtMatrix>(*operators_.dealt);
  dealt_->combine(gamma_);
  const auto by_k = [this](const DenseMatrix& motions, bool transposed) {
    return dealt_->forces_of(motions, transposed);
  };
  free_ = motions_.empty() ? nullptr : find_free_body(motions_, by_k, *layout_);
  if ((dealt_held_ != nullptr) != (free_ != nullptr)) iterations_.reset(), dealt_held_.reset();
  if (free_) {
    if (!dealt_held_) dealt_held_ = std::make_unique<DealtMatrix>(*operators_.dealt);
    dealt_held_->combine(gamma_);
    Vector more = Vector::Zero(operators_.n_unknowns);
    for_held([&](int i, double stiffness) { more[i] = stiffness; });
    dealt_held_->stiffen(more);
  }
  const DealtMatrix& of = free_ ? *dealt_held_ : *dealt_;
  if (iterations_)
    iterations_->matrix_changed();
  else
    iterate_with(petsc_solver(of.rows(), of.pieces(), symmetric(), *operators_.iterative));
  if (free_) iterations_->set_free_motions(free_->on_unknowns);
  if (contact_.none()) take_for_a_factor();
}

const MatrixRows& FactoredMatrix::rows_of_iterations() const {
  if (dealt_held_) return *dealt_held_;
  if (dealt_) return *dealt_;
  return *rows_;
}

/// Iterations know the matrix by where its entries are.
void FactoredMatrix::set_matrix(SparseMatrix& k) {
  if (iterations_ && k.nonZeros() == k_.nonZeros())
    std::copy_n(k.valuePtr(), k.nonZeros(), k_.valuePtr());
  else
    k_.swap(k), iterations_.reset(); // Eigen 3.4 copies what is moved
}

/// Several unknowns are solved for one after the other by iterations, which is not symmetric.
bool FactoredMatrix::symmetric() const {
  return operators_.symmetric && !(operators_.iterative && operators_.iterative->several());
}

void FactoredMatrix::prepare_iterations() {
  if ((held_.rows() > 0) != (free_ != nullptr)) iterations_.reset(), held_ = {};
  if (free_) {
    SparseMatrix now = held();
    if (held_.nonZeros() == now.nonZeros())
      std::copy_n(now.valuePtr(), now.nonZeros(), held_.valuePtr());
    else
      held_.swap(now), iterations_.reset();
  }
  if (iterations_)
    iterations_->matrix_changed();
  else
    iterate_with(petsc_solver(free_ ? held_ : k_, symmetric(), *operators_.iterative));
  rows_ = std::make_unique<HeldRows>(free_ ? held_ : k_, contact_.of_unknown);
  if (free_) iterations_->set_free_motions(free_->on_unknowns);
  if (contact_.none()) take_for_a_factor();
}

void FactoredMatrix::iterate_with(std::unique_ptr<IterativeSolver> solver) {
  iterations_ = std::move(solver);
  iterations_->call_between_iterations(between_);
}

/// Without laws nothing but linear systems is to be solved.
void FactoredMatrix::take_for_a_factor() {
  factorisation_ = own(iterative_factorisation(*iterations_, rows_of_iterations()));
  factorisation_->factor(k_);
}

/// Where laws act on one of several unknowns what is left of the others on it may be symmetric and
/// positive definite, as A + B C^-1 B^T of a porous body, when K is not.
bool FactoredMatrix::has_an_energy() const {
  constexpr double rounding = 1e-11;
  return !contact_.of_unknown.empty() && !contact_.mixed &&
         is_positive_definite(factorisation_->schur(), rounding);
}

std::unique_ptr<ReducedOperator> FactoredMatrix::reduced_operator() const {
  const bool symmetric = this->symmetric() && !contact_.mixed;
  if (iterations_)
    return std::make_unique<IterativeOperator>(rows_of_iterations(), symmetric, *iterations_,
                                               !contact_.of_unknown.empty());
  if (contact_.whole) return sparse_operator(free_ ? held() : k_, symmetric);
  return dense_operator(factorisation_.kept(), symmetric || has_an_energy());
}

FactorStatistics FactoredMatrix::statistics() const {
  if (!iterations_) return factorisation_.statistics();
  const IterativeStatistics& of = iterations_->statistics();
  FactorStatistics out;
  out.bytes = of.bytes, out.iterative = of.work;
  out.seconds_factor = of.seconds_setup;
  out.factorisations = of.setups;
  return out;
}

template <class Held>
void FactoredMatrix::for_held(const Held& held) const {
  const SparseMatrix& force = contact_.force; // of those that no law sees iterations keep nothing
  for (const int i : contact_.loaded)
    if (!operators_.iterative || force.outerIndexPtr()[i] < force.outerIndexPtr()[i + 1])
      held(i, hold * std::abs(dealt_ ? dealt_->diagonal_entry(i) : k_.coeff(i, i)));
}

SparseMatrix FactoredMatrix::held() const {
  SparseMatrix out = k_;
  for_held([&](int i, double more) { out.coeffRef(i, i) += more; });
  out.makeCompressed(); // unknowns in no form had no entry
  return out;
}

void FactoredMatrix::add_held(const Vector& x, Vector& out) const {
  if (free_) for_held([&](int i, double more) { out[i] += more * x[i]; });
}

const SymmetricBlocks& FactoredMatrix::half(std::span<const SymmetricBlocks> bases) {
  if (half_.empty() && !bases.empty()) half_ = SymmetricBlocks::sum(bases, gamma_);
  if (half_.empty() && !bases.empty()) half_ = SymmetricBlocks(k_);
  return half_;
}

bool FactoredMatrix::in_singles() const {
  return factorisation_ && factorisation_->statistics().entries == FactorEntries::singles;
}

double FactoredMatrix::bytes() const {
  return static_cast<double>(k_.nonZeros()) * (sizeof(double) + sizeof(int)) + half_.bytes();
}

double condition(const FactoredMatrix& matrix, const Operators& operators) {
  if (matrix.free_body() != nullptr || operators.iterative) return 0.0;
  if (matrix.factorisation()) return estimate_condition(matrix.k(), *matrix.factorisation());
  const auto factor = operators.coupled ? coupled_factor(matrix.k(), {}, {})
                                        : analyse(matrix.k(), {}, operators.symmetric);
  factor->factor(matrix.k());
  return estimate_condition(matrix.k(), *factor);
}

} // namespace hvi::solver
