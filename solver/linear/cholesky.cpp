// The symmetric factorisation: K = L L^T by CHOLMOD with the contact unknowns last, so that the
// trailing block L22 of L gives the Schur complement S = L22 L22^T without a solve.
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/cholesky.hpp"

#include "solver/common/clock.hpp"
#include "solver/linear/changed_unknowns.hpp"
#include "solver/linear/cholesky_factor.hpp"
#include "solver/linear/one_blas_thread.hpp"
#include "solver/linear/ordering.hpp"

#include <cblas.h>

#include <algorithm>
#include <stdexcept>

namespace hvi::solver {
namespace {

/// L L^T for a lower triangle, by columns of blocks: a block column of the product takes only the
/// columns of L up to its end. OpenBLAS, as Eigen's own product is compiled for any processor.
DenseMatrix times_transpose(const DenseMatrix& l) {
  const OneBlasThread one_thread;
  constexpr int block = 128;
  const int size = static_cast<int>(l.rows());
  DenseMatrix product(size, size);
  for (int first = 0; first < size; first += block) {
    const int columns = std::min(block, size - first);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, size - first, columns, first + columns,
                1.0, &l(first, 0), size, &l(first, 0), size, 0.0, &product(first, first), size);
  }
  product.triangularView<Eigen::StrictlyUpper>() = product.transpose();
  return product;
}

/// L22 of the contact unknowns, and S = L22 L22^T.
class ContactFactor {
public:
  void take_from(const CholeskyFactor& l) {
    l.take_trailing_block(l22_);
    schur_.resize(0, 0);
  }
  const DenseMatrix& schur() const {
    if (schur_.size() < l22_.size()) schur_ = times_transpose(l22_);
    return schur_;
  }
  /// In place, for one right-hand side.
  void forward(double* y_c) const {
    l22_.triangularView<Eigen::Lower>().solveInPlace(entries(y_c));
  }
  void back(double* y_c) const {
    l22_.transpose().triangularView<Eigen::Upper>().solveInPlace(entries(y_c));
  }

private:
  Eigen::Map<Vector> entries(double* y_c) const { return {y_c, l22_.rows()}; }

  DenseMatrix l22_;
  mutable DenseMatrix schur_; ///< made at the first use after a factorisation
};

/// A triangular solve reads the columns of the interior; with one right-hand side what counts is
/// all that CHOLMOD stores of them.
void count_solve(const CholeskyFactor& l, const LowerFactor& lower, RightHandSides y,
                 FactorStatistics& statistics) {
  if (lower.values == nullptr) throw std::logic_error("a solve before a factorisation");
  ++statistics.triangular_solves;
  const double contacts = l.order().contacts();
  const double entries = y.stride == 1
                             ? static_cast<double>(l.structure().xsize) - contacts * contacts
                             : lower.structure.nonzeros();
  statistics.bytes_read += entries * sizeof(double);
}

class Cholesky final : public Factorisation {
public:
  /// `start`: of the analysis, in cpu_seconds().
  Cholesky(const SparseMatrix& k, std::span<const int> contact, OrderStore* known, double start);
  Cholesky(const Cholesky& analysed, double start);

  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<Cholesky>(*this, cpu_seconds());
  }
  void factor(const SparseMatrix& k) override;
  void forward(RightHandSides y, Columns columns) override;
  void back(RightHandSides y, Columns columns) override;
  const DenseMatrix& schur() const override { return contact_.schur(); }
  const EliminationOrder& order() const override { return l_.order(); }
  const FactorStatistics& statistics() const override { return statistics_; }
  const LowerFactor* lower() const { return lower_.values != nullptr ? &lower_ : nullptr; }

private:
  FactorStatistics statistics_; // the factor writes into it
  CholeskyFactor l_;
  LowerFactor lower_;
  ContactFactor contact_;
};

/// Everything that has the size of the factor.
LowerFactor without_values(const CholeskyFactor& l) {
  const int interior = l.order().interior;
  return {Supernodes(l.structure(), interior), nullptr,
          std::vector<double>(static_cast<std::size_t>(interior))};
}

Cholesky::Cholesky(const SparseMatrix& k, std::span<const int> contact, OrderStore* known,
                   double start)
    : l_(k, contact, known, statistics_), lower_(without_values(l_)) {
  statistics_.bytes = l_.bytes();
  statistics_.analyses = 1;
  statistics_.seconds_analyse =
      cpu_seconds() - start + (known != nullptr ? known->seconds_of_last() : 0.0);
}

Cholesky::Cholesky(const Cholesky& analysed, double start)
    : l_(analysed.l_), lower_(without_values(l_)) {
  statistics_.nonzeros = analysed.statistics_.nonzeros;
  statistics_.flops = analysed.statistics_.flops;
  statistics_.bytes = l_.bytes();
  statistics_.ordering = analysed.statistics_.ordering;
  statistics_.seconds_analyse = cpu_seconds() - start;
}

void Cholesky::factor(const SparseMatrix& k) {
  const double start = cpu_seconds();
  lower_.values = nullptr;
  l_.compute(k);
  ++statistics_.factorisations;
  l_.take_diagonal(lower_.inverse_diagonal);
  contact_.take_from(l_);
  statistics_.seconds_factor = cpu_seconds() - start;
  lower_.values = l_.values();
}

void Cholesky::forward(RightHandSides y, Columns columns) {
  count_solve(l_, lower_, y, statistics_);
  lower_.structure.forward(lower_.values, lower_.inverse_diagonal.data(), y);
  if (columns != Columns::interior) contact_.forward(y.only() + order().interior);
}

void Cholesky::back(RightHandSides y, Columns columns) {
  count_solve(l_, lower_, y, statistics_);
  if (columns != Columns::interior) contact_.back(y.only() + order().interior);
  lower_.structure.backward(lower_.values, lower_.inverse_diagonal.data(), y);
}

} // namespace

std::unique_ptr<Factorisation> analyse_cholesky(const SparseMatrix& k, std::span<const int> contact,
                                                OrderStore* known) {
  return std::make_unique<Cholesky>(k, contact, known, cpu_seconds());
}

const LowerFactor* lower_factor(const Factorisation& of) {
  const auto* const cholesky = dynamic_cast<const Cholesky*>(&eliminating(of));
  return cholesky != nullptr ? cholesky->lower() : nullptr;
}

} // namespace hvi::solver
