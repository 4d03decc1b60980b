// The symmetric factorisation: K = L L^T by CHOLMOD with the contact unknowns last, so that what
// the elimination of the others leaves of K is the Schur complement S = L22 L22^T, without a solve.
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/cholesky.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/linear/blas_threads.hpp"
#include "solver/linear/changed_unknowns.hpp"
#include "solver/linear/cholesky_factor.hpp"
#include "solver/linear/dense_blocks.hpp"
#include "solver/linear/ordering.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

namespace hvi::solver {
namespace {

/// Of an error a correction with a factor of singles leaves at most this part, or doubles are
/// taken: steps converge in a few corrections more.
constexpr double most_left = 0.01;
/// The range of singles, whose squares are formed.
constexpr double least_single = 1e-15, most_single = 1e15;

/// The whole of a symmetric matrix from its lower triangle, by blocks that stay in the caches.
template <class Entry>
DenseMatrix both_triangles(const SquareOf<Entry>& lower) {
  constexpr Eigen::Index block = 64;
  const Eigen::Index n = lower.rows();
  DenseMatrix out(n, n);
  for (Eigen::Index j = 0; j < n; j += block)
    for (Eigen::Index i = j; i < n; i += block) {
      const Eigen::Index rows = std::min(block, n - i), columns = std::min(block, n - j);
      DenseMatrix part = lower.block(i, j, rows, columns).template cast<double>();
      if (i == j) part = DenseMatrix(part.selfadjointView<Eigen::Lower>());
      out.block(i, j, rows, columns) = part;
      out.block(j, i, columns, rows) = part.transpose();
    }
  return out;
}

/// S of the contact unknowns, and L22 with S = L22 L22^T.
class ContactFactor {
public:
  /// The diagonal of L22, up to the first pivot that is not positive.
  std::vector<double> take_from(CholeskyFactor& l) {
    doubles_.resize(0, 0), singles_.resize(0, 0), schur_.resize(0, 0);
    return l.entries() == FactorEntries::singles ? take_from(l, singles_) : take_from(l, doubles_);
  }
  const DenseMatrix& schur() const { return schur_; }
  /// In place, for one right-hand side.
  void forward(double* y) const {
    if (singles_.size() > 0) return forward_with_singles(y);
    dense_blocks::solve(static_cast<int>(doubles_.rows()), doubles_.data(), CblasNoTrans, y);
  }
  void back(double* y) const {
    if (singles_.size() > 0) return back_with_singles(y);
    dense_blocks::solve(static_cast<int>(doubles_.rows()), doubles_.data(), CblasTrans, y);
  }

  /// In place, S^-1 columns.
  void solve(DenseMatrix& columns) const {
    const OneBlasThread one_thread;
    const auto n = static_cast<int>(columns.rows()), count = static_cast<int>(columns.cols());
    if (singles_.size() == 0)
      return dense_blocks::solve_both(n, count, doubles_.data(), columns.data());
    SquareOf<float> x = columns.cast<float>();
    dense_blocks::solve_both(n, count, singles_.data(), x.data());
    columns = x.cast<double>();
  }

private:
  template <class Entry>
  std::vector<double> take_from(CholeskyFactor& l, SquareOf<Entry>& l22) {
    l.take_trailing_block(l22);
    schur_ = both_triangles(l22);
    const OneBlasThread one_thread;
    const auto n = static_cast<int>(l22.rows());
    const int failed = n > 0 ? dense_blocks::cholesky(n, l22.data(), n) : 0;
    std::vector<double> diagonal(static_cast<std::size_t>(failed > 0 ? failed - 1 : n));
    for (std::size_t i = 0; i < diagonal.size(); ++i)
      diagonal[i] = l22.diagonal()[static_cast<Eigen::Index>(i)];
    return diagonal;
  }
  void forward_with_singles(double* y) const {
    const Eigen::Index n = singles_.rows();
    for (Eigen::Index j = 0; j < n; ++j) {
      y[j] /= double{singles_(j, j)};
      for (Eigen::Index i = j + 1; i < n; ++i) y[i] -= double{singles_(i, j)} * y[j];
    }
  }
  void back_with_singles(double* y) const {
    const Eigen::Index n = singles_.rows();
    for (Eigen::Index j = n - 1; j >= 0; --j) {
      for (Eigen::Index i = j + 1; i < n; ++i) y[j] -= double{singles_(i, j)} * y[i];
      y[j] /= double{singles_(j, j)};
    }
  }

  SquareOf<double> doubles_; ///< L22 is the one of both that is not empty
  SquareOf<float> singles_;
  DenseMatrix schur_;
};

/// A triangular solve reads the columns of the interior; with one right-hand side what counts is
/// all that CHOLMOD stores of them.
void count_solve(const CholeskyFactor& l, const LowerFactor& lower, RightHandSides y,
                 FactorStatistics& statistics) {
  ++statistics.triangular_solves;
  const double entries =
      y.stride == 1 ? static_cast<double>(l.interior_entries()) : lower.structure.nonzeros();
  const bool singles = l.entries() == FactorEntries::singles;
  statistics.bytes_read += entries * (singles ? sizeof(float) : sizeof(double));
}

class Cholesky final : public Factorisation {
public:
  /// `start`: of the analysis, in cpu_seconds().
  Cholesky(const SparseMatrix& k, std::span<const int> contact, FactorEntries entries,
           OrderStore* known, double start);
  Cholesky(const Cholesky& analysed, double start);

  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<Cholesky>(*this, cpu_seconds());
  }
  void factor(const SparseMatrix& k) override;
  void forward(RightHandSides y, Columns columns) override;
  void back(RightHandSides y, Columns columns) override;
  const DenseMatrix& schur() const override { return contact_.schur(); }
  bool solve_schur(DenseMatrix& columns) const override {
    contact_.solve(columns);
    return true;
  }
  const EliminationOrder& order() const override { return l_.order(); }
  const FactorStatistics& statistics() const override { return statistics_; }
  const LowerFactor* lower() const { return lower_.values != nullptr ? &lower_ : nullptr; }

private:
  void take_factor(const SparseMatrix& k);
  bool singles_will_do(const SparseMatrix& k);
  double left_by_a_correction(const SparseMatrix& k);

  FactorStatistics statistics_; // the factor writes into it
  CholeskyFactor l_;
  bool factored_ = false;
  LowerFactor lower_;
  ContactFactor contact_;
};

/// Everything that has the size of the factor.
LowerFactor without_values(const CholeskyFactor& l) {
  const int interior = l.order().interior;
  return {Supernodes(l.structure(), interior), nullptr,
          std::vector<double>(static_cast<std::size_t>(interior))};
}

Cholesky::Cholesky(const SparseMatrix& k, std::span<const int> contact, FactorEntries entries,
                   OrderStore* known, double start)
    : l_(k, contact, known, entries, statistics_), lower_(without_values(l_)) {
  statistics_.bytes = l_.bytes();
  statistics_.entries = entries;
  statistics_.analyses = 1;
  statistics_.seconds_analyse =
      cpu_seconds() - start + (known != nullptr ? known->seconds_of_last() : 0.0);
}

Cholesky::Cholesky(const Cholesky& analysed, double start)
    : l_(analysed.l_), lower_(without_values(l_)) {
  statistics_.nonzeros = analysed.statistics_.nonzeros;
  statistics_.flops = analysed.statistics_.flops;
  statistics_.bytes = l_.bytes();
  statistics_.entries = l_.entries();
  statistics_.ordering = analysed.statistics_.ordering;
  statistics_.seconds_analyse = cpu_seconds() - start;
}

void Cholesky::take_factor(const SparseMatrix& k) {
  std::vector<double> of_contact;
  if (l_.compute(k)) of_contact = contact_.take_from(l_);
  ++statistics_.factorisations;
  l_.take_diagonal(of_contact, lower_.inverse_diagonal);
  factored_ = true;
}

/// The norm of 1 - (L L^T)^-1 K, by three steps of the power method.
double Cholesky::left_by_a_correction(const SparseMatrix& k) {
  std::minstd_rand random; // of a fixed seed
  Vector error(k.rows()), x;
  for (double& entry : error) entry = (random() & 64U) != 0U ? 1.0 : -1.0;
  double size = error.norm(), out = 0.0;
  for (int pass = 0; pass < 3 && size > 0.0; ++pass) {
    solve(*this, k * error, x);
    error -= x;
    const double before = std::exchange(size, error.norm());
    if (!std::isfinite(size)) return std::numeric_limits<double>::infinity();
    out = size / before;
  }
  return out;
}

/// Factors K in singles. False: its numbers are beyond them, or they say too little of it.
bool Cholesky::singles_will_do(const SparseMatrix& k) {
  const auto diagonal = k.diagonal().cwiseAbs();
  if (!(diagonal.minCoeff() >= least_single && diagonal.maxCoeff() <= most_single)) return false;
  try {
    take_factor(k);
  } catch (const NotFactorable&) {
    return false;
  }
  statistics_.left = left_by_a_correction(k);
  return statistics_.left <= most_left;
}

void Cholesky::factor(const SparseMatrix& k) {
  const double start = cpu_seconds();
  factored_ = false, lower_.values = nullptr;
  if (l_.entries() == FactorEntries::singles && !singles_will_do(k)) {
    factored_ = false;
    l_.take_doubles();
    statistics_.entries = l_.entries(), statistics_.bytes = l_.bytes();
    require_memory(l_.bytes(),
                   fmt::format("the factor of a matrix of {} unknowns in double precision, as "
                               "single precision is too little for it",
                               k.rows()));
  }
  if (l_.entries() == FactorEntries::doubles) {
    take_factor(k);
    lower_.values = l_.values<double>();
  }
  statistics_.seconds_factor += cpu_seconds() - start;
}

void Cholesky::forward(RightHandSides y, Columns columns) {
  if (!factored_) throw std::logic_error("a solve before a factorisation");
  count_solve(l_, lower_, y, statistics_);
  l_.with_values([&](const auto* values) {
    lower_.structure.forward(values, lower_.inverse_diagonal.data(), y);
  });
  if (columns != Columns::interior) contact_.forward(y.only() + order().interior);
}

void Cholesky::back(RightHandSides y, Columns columns) {
  if (!factored_) throw std::logic_error("a solve before a factorisation");
  count_solve(l_, lower_, y, statistics_);
  if (columns != Columns::interior) contact_.back(y.only() + order().interior);
  l_.with_values([&](const auto* values) {
    lower_.structure.backward(values, lower_.inverse_diagonal.data(), y);
  });
}

} // namespace

std::unique_ptr<Factorisation> analyse_cholesky(const SparseMatrix& k, std::span<const int> contact,
                                                FactorEntries entries, OrderStore* known) {
  return std::make_unique<Cholesky>(k, contact, entries, known, cpu_seconds());
}

const LowerFactor* lower_factor(const Factorisation& of) {
  const auto* const cholesky = dynamic_cast<const Cholesky*>(&eliminating(of));
  return cholesky != nullptr ? cholesky->lower() : nullptr;
}

} // namespace hvi::solver
