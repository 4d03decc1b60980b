// The symmetric factorisation: K = L L^T by CHOLMOD with the contact unknowns last, so that the
// trailing block L22 of L gives the Schur complement S = L22 L22^T without a solve.
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/cholesky.hpp"

#include "solver/common/clock.hpp"
#include "solver/linear/cholesky_factor.hpp"
#include "solver/linear/one_blas_thread.hpp"
#include "solver/linear/ordering.hpp"
#include "solver/linear/supernodes.hpp"

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

class Cholesky final : public Factorisation {
public:
  Cholesky(const SparseMatrix& k, std::span<const int> contact, OrderStore* known);
  explicit Cholesky(const Cholesky* analysed);

  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<Cholesky>(this);
  }
  void factor(const SparseMatrix& k) override;
  void reduce(const Vector& b, Vector& r) override;
  void back(const Vector& c, Vector& x) override;
  Vector kept() const override;
  void resume(const Vector& kept) override;
  void reduce_each(std::span<const Vector> b, std::vector<Vector>& r) override;
  void back_each(std::span<const Vector> c, std::vector<Vector>& x) override;
  void back_all(const DenseMatrix& c, std::span<const Vector> kept, const DenseMatrix& weights,
                DenseMatrix& x, std::vector<int>& place) override;
  void solve(const Vector& b, Vector& x) override;
  std::optional<LowerFactor> lower() const override;
  const DenseMatrix& schur() const override;
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void prepare();
  void count_solve();
  void count_solves_at_once();

  FactorStatistics statistics_; // the factor writes into it
  double start_;
  CholeskyFactor l_;
  int size_, interior_;
  bool factored_ = false;
  Supernodes supernodes_;
  std::vector<double> inverse_diagonal_; ///< of L, interior
  std::vector<double> y_, x_;            ///< of triangular solves, in the order of elimination
  DenseMatrix each_; ///< a row for each right-hand side between `reduce_each` and `back_each`
  DenseMatrix l22_;
  mutable DenseMatrix schur_; ///< built at the first use after a factorisation
  mutable bool schur_ready_ = false;
  Vector reduced_; ///< workspace of `solve`
};

Cholesky::Cholesky(const SparseMatrix& k, std::span<const int> contact, OrderStore* known)
    : start_(cpu_seconds()), l_(k, contact, known, statistics_), size_(static_cast<int>(k.rows())),
      interior_(l_.interior()) {
  prepare();
  statistics_.analyses = 1;
  statistics_.seconds_analyse =
      cpu_seconds() - start_ + (known != nullptr ? known->seconds_of_last() : 0.0);
}

Cholesky::Cholesky(const Cholesky* analysed)
    : start_(cpu_seconds()), l_(analysed->l_), size_(analysed->size_), interior_(l_.interior()) {
  prepare();
  statistics_.nonzeros = analysed->statistics_.nonzeros;
  statistics_.flops = analysed->statistics_.flops;
  statistics_.ordering = analysed->statistics_.ordering;
  statistics_.seconds_analyse = cpu_seconds() - start_;
}

/// Everything that has the size of the factor.
void Cholesky::prepare() {
  supernodes_ = Supernodes(l_.structure(), interior_);
  inverse_diagonal_.resize(static_cast<std::size_t>(interior_));
  y_.resize(static_cast<std::size_t>(size_));
  x_.resize(static_cast<std::size_t>(size_));
  reduced_.resize(size_ - interior_);
  statistics_.bytes = l_.bytes();
}

void Cholesky::factor(const SparseMatrix& k) {
  const double start = cpu_seconds();
  factored_ = schur_ready_ = false;
  l_.compute(k);
  ++statistics_.factorisations;
  l_.take_diagonal(inverse_diagonal_);
  l_.take_trailing_block(l22_);
  statistics_.seconds_factor = cpu_seconds() - start;
  factored_ = true;
}

std::optional<LowerFactor> Cholesky::lower() const {
  if (!factored_) return std::nullopt;
  return LowerFactor{supernodes_, l_.values(), inverse_diagonal_, l_.permutation(), l22_};
}

const DenseMatrix& Cholesky::schur() const {
  if (!schur_ready_) {
    schur_ = times_transpose(l22_);
    schur_ready_ = true;
  }
  return schur_;
}

void Cholesky::reduce(const Vector& b, Vector& r) {
  if (!factored_) throw std::logic_error("reduce before a successful factorisation");
  for (int position = 0; position < size_; ++position) y_[position] = b[l_.permutation()[position]];
  supernodes_.forward(l_.values(), inverse_diagonal_.data(), y_.data());
  r.resize(size_ - interior_);
  std::copy(y_.begin() + interior_, y_.end(), r.data());
  count_solve();
}

/// A triangular solve reads the columns of the interior.
void Cholesky::count_solve() {
  ++statistics_.triangular_solves;
  const double n_contact = size_ - interior_;
  const double entries = static_cast<double>(l_.structure().xsize) - n_contact * n_contact;
  statistics_.bytes_read += entries * sizeof(double);
}

void Cholesky::back(const Vector& c, Vector& x) {
  if (!factored_) throw std::logic_error("back before a successful factorisation");
  std::copy_n(c.data(), size_ - interior_, x_.begin() + interior_);
  supernodes_.backward(l_.values(), inverse_diagonal_.data(), y_.data(), x_.data());
  x.resize(size_);
  for (int position = 0; position < size_; ++position) x[l_.permutation()[position]] = x_[position];
  count_solve();
}

Vector Cholesky::kept() const { return Eigen::Map<const Vector>(y_.data(), interior_); }

void Cholesky::resume(const Vector& kept) { std::copy_n(kept.data(), interior_, y_.begin()); }

void Cholesky::reduce_each(std::span<const Vector> b, std::vector<Vector>& r) {
  if (!factored_) throw std::logic_error("reduce before a successful factorisation");
  constexpr int lanes = Supernodes::lanes;
  const auto count = static_cast<int>(b.size()), groups = (count + lanes - 1) / lanes;
  each_.resize(0, 0);
  if (count == 1) return Factorisation::reduce_each(b, r);
  if (count == 0 || count > most_at_once)
    throw std::logic_error("too many right-hand sides at once");
  each_.setZero(groups * lanes, size_);
  for (int position = 0; position < size_; ++position)
    for (int k = 0; k < count; ++k) each_(k, position) = b[k][l_.permutation()[position]];
  supernodes_.forward_all(l_.values(), inverse_diagonal_.data(), groups, each_.data());
  r.resize(b.size());
  for (int k = 0; k < count; ++k) r[k] = each_.row(k).tail(size_ - interior_);
  count_solves_at_once();
}

void Cholesky::back_each(std::span<const Vector> c, std::vector<Vector>& x) {
  const auto count = static_cast<int>(c.size());
  if (count == 1) return Factorisation::back_each(c, x);
  constexpr int lanes = Supernodes::lanes;
  const int groups = static_cast<int>(each_.rows()) / lanes;
  if (each_.size() == 0 || count > each_.rows())
    throw std::logic_error("back_each before its reduce_each");
  for (int k = 0; k < count; ++k) each_.row(k).tail(size_ - interior_) = c[k].transpose();
  supernodes_.backward_all(l_.values(), inverse_diagonal_.data(), groups, each_.data());
  x.assign(c.size(), Vector(size_));
  for (int position = 0; position < size_; ++position)
    for (int k = 0; k < count; ++k) x[k][l_.permutation()[position]] = each_(k, position);
  each_.resize(0, 0);
  count_solves_at_once();
}

void Cholesky::back_all(const DenseMatrix& c, std::span<const Vector> kept,
                        const DenseMatrix& weights, DenseMatrix& x, std::vector<int>& place) {
  if (!factored_) throw std::logic_error("back before a successful factorisation");
  constexpr int lanes = Supernodes::lanes;
  const auto count = static_cast<int>(c.cols()), groups = (count + lanes - 1) / lanes;
  if (count == 0 || count > most_at_once)
    throw std::logic_error("too many right-hand sides at once");
  x.resize(groups * lanes, size_); // in the order of elimination
  auto inside = x.leftCols(interior_);
  if (kept.empty()) inside.setZero();
  Vector weight = Vector::Zero(x.rows());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    weight.head(count) = weights.col(static_cast<Eigen::Index>(k));
    if (k == 0)
      inside.noalias() = weight * kept[k].transpose();
    else
      inside.noalias() += weight * kept[k].transpose();
  }
  x.rightCols(size_ - interior_).topRows(count) = c.transpose();
  x.rightCols(size_ - interior_).bottomRows(groups * lanes - count).setZero();
  supernodes_.backward_all(l_.values(), inverse_diagonal_.data(), groups, x.data());
  place.resize(static_cast<std::size_t>(size_));
  for (int position = 0; position < size_; ++position) place[l_.permutation()[position]] = position;
  count_solves_at_once();
}

void Cholesky::count_solves_at_once() {
  ++statistics_.triangular_solves;
  statistics_.bytes_read += supernodes_.nonzeros() * sizeof(double);
}

void Cholesky::solve(const Vector& b, Vector& x) {
  reduce(b, reduced_);
  if (interior_ < size_) {
    l22_.triangularView<Eigen::Lower>().solveInPlace(reduced_);
    l22_.transpose().triangularView<Eigen::Upper>().solveInPlace(reduced_);
  }
  back(reduced_, x);
}

} // namespace

std::unique_ptr<Factorisation> analyse_cholesky(const SparseMatrix& k, std::span<const int> contact,
                                                OrderStore* known) {
  return std::make_unique<Cholesky>(k, contact, known);
}

} // namespace hvi::solver
