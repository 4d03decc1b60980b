// The symmetric factorisation: K = L L^T by CHOLMOD with the contact unknowns last, so that the
// trailing block L22 of L gives the Schur complement S = L22 L22^T without a solve.
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/cholesky.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/linear/cholmod_session.hpp"
#include "solver/linear/one_blas_thread.hpp"
#include "solver/linear/ordering.hpp"
#include "solver/linear/packed_factor.hpp"
#include "solver/linear/permuted_lower.hpp"
#include "solver/linear/supernodes.hpp"
#include "solver/linear/symbolic.hpp"

#include <fmt/format.h>

#include <cblas.h>

#include <algorithm>
#include <cmath>
#include <limits>

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
  ~Cholesky() override { cholmod_l_free_factor(&l_, session_.common()); }
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<Cholesky>(this);
  }
  void factor(const SparseMatrix& k) override;
  void reduce(const Vector& b, Vector& r) override;
  void back(const Vector& c, Vector& x) override;
  void extend(const Vector& c, Vector& x) override;
  Vector kept() const override;
  void resume(const Vector& kept) override;
  void reduce_each(std::span<const Vector> b, std::vector<Vector>& r) override;
  void back_each(std::span<const Vector> c, std::vector<Vector>& x) override;
  void back_all(const DenseMatrix& c, std::span<const Vector> kept, const DenseMatrix& weights,
                DenseMatrix& x, std::vector<int>& place) override;
  std::optional<double> energy(const Vector& b) override;
  void solve(const Vector& b, Vector& x) override;
  bool set_precision(FactorPrecision storage) override;
  const DenseMatrix& schur() const override;
  const DenseMatrix& schur_factor() const override { return l22_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void analyse_pattern(const SparseMatrix& k, std::span<const int> contact, OrderStore* known);
  void prepare();
  void check_contact_last(std::span<const int> contact) const;
  void check_pivots();
  void read_trailing_block();
  void count_solve();
  void count_solves_at_once();
  [[noreturn]] void fail_at(int position, double pivot) const;
  const double* values() const { return static_cast<const double*>(l_->x); }

  double start_;
  CholmodSession session_;
  PermutedLower a_;
  cholmod_factor* l_ = nullptr;
  int size_, interior_;
  bool factored_ = false;
  std::vector<int> permutation_; ///< position -> unknown
  Supernodes supernodes_;
  FactorPrecision storage_ = FactorPrecision::full;
  FactorPrecision storage_of_y_ = FactorPrecision::full;
  PackedFactor packed_;                  ///< the interior of L in reduced precision, if used
  std::vector<double> inverse_diagonal_; ///< of L, interior
  std::vector<double> y_, x_;            ///< of triangular solves, in the order of elimination
  DenseMatrix each_; ///< a row for each right-hand side between `reduce_each` and `back_each`
  DenseMatrix l22_;
  mutable DenseMatrix schur_; ///< built at the first use after a factorisation
  mutable bool schur_ready_ = false;
  Vector reduced_; ///< workspace of `solve`
  FactorStatistics statistics_;
};

Cholesky::Cholesky(const SparseMatrix& k, std::span<const int> contact, OrderStore* known)
    : start_(cpu_seconds()), size_(static_cast<int>(k.rows())),
      interior_(size_ - static_cast<int>(contact.size())) {
  analyse_pattern(k, contact, known);
  check_contact_last(contact);
  prepare();
  statistics_.analyses = 1;
  statistics_.seconds_analyse =
      cpu_seconds() - start_ + (known != nullptr ? known->seconds_of_last() : 0.0);
}

Cholesky::Cholesky(const Cholesky* analysed)
    : start_(cpu_seconds()), a_(analysed->a_), size_(analysed->size_),
      interior_(analysed->interior_), permutation_(analysed->permutation_) {
  l_ = cholmod_l_copy_factor(analysed->l_, session_.common());
  // Supernodal and symbolic again: the copied values are of no use.
  const bool done = l_ != nullptr && (l_->xtype == CHOLMOD_PATTERN ||
                                      cholmod_l_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, l_,
                                                              session_.common()) != 0);
  if (!done) throw OutOfMemory("no memory for one more factor of {} unknowns", size_);
  prepare();
  statistics_.nonzeros = analysed->statistics_.nonzeros;
  statistics_.flops = analysed->statistics_.flops;
  statistics_.ordering = analysed->statistics_.ordering;
  statistics_.seconds_analyse = cpu_seconds() - start_;
}

/// Everything that has the size of the factor.
void Cholesky::prepare() {
  supernodes_ = Supernodes(*l_, interior_);
  inverse_diagonal_.resize(static_cast<std::size_t>(interior_));
  y_.resize(static_cast<std::size_t>(size_));
  x_.resize(static_cast<std::size_t>(size_));
  reduced_.resize(size_ - interior_);
  const double contacts = size_ - interior_; // L22 and S
  statistics_.bytes = static_cast<double>(l_->xsize) * sizeof(double) +
                      static_cast<double>(l_->ssize) * (sizeof(Long) + sizeof(int)) +
                      2.0 * contacts * contacts * sizeof(double);
}

void Cholesky::analyse_pattern(const SparseMatrix& k, std::span<const int> contact,
                               OrderStore* known) {
  {
    auto order = known != nullptr ? known->order(k, contact, session_)
                                  : order_contact_last(k, contact, session_);
    l_ = symbolic_factor(order, session_);
    cholmod_l_free_work(session_.common()); // what comes next may take the place of both
    if (l_ == nullptr || l_->is_super == 0) {
      refuse_too_large(*session_.common(), size_);
      throw OutOfMemory("no memory to analyse a matrix of {} unknowns", size_);
    }
    permutation_.assign(order.permutation.begin(), order.permutation.end());
    statistics_.nonzeros = order.nonzeros;
    statistics_.flops = order.flops;
    statistics_.ordering = std::move(order.name);
  }
  a_ = PermutedLower(k, permutation_);
}

void Cholesky::check_contact_last(std::span<const int> contact) const {
  if (!std::equal(contact.begin(), contact.end(), permutation_.begin() + interior_))
    throw std::logic_error("the postorder moved a contact unknown from the end of the elimination");
}

void Cholesky::factor(const SparseMatrix& k) {
  const double start = cpu_seconds();
  const OneBlasThread one_thread;
  factored_ = schur_ready_ = false;
  a_.assign(k);
  cholmod_sparse view = a_.view();
  cholmod_common* common = session_.common();
  if (l_->xtype == CHOLMOD_PATTERN && // else CHOLMOD would make room itself, in small pages
      cholmod_l_change_factor(CHOLMOD_REAL, true, true, true, true, l_, common) != 0)
    advise_large_pages(l_->x, l_->xsize * sizeof(double));
  double nothing[2] = {0.0, 0.0}; // is added to the diagonal
  cholmod_l_super_numeric(&view, nullptr, nothing, l_, common);
  if (common->status < CHOLMOD_OK) {
    refuse_too_large(*common, size_);
    throw OutOfMemory("no memory to factor a matrix of {} unknowns ({:.2g} bytes)", size_,
                      statistics_.bytes);
  }
  ++statistics_.factorisations;
  if (common->status == CHOLMOD_NOT_POSDEF) fail_at(static_cast<int>(l_->minor), 0.0);
  check_pivots();
  read_trailing_block();
  if (!packed_.empty()) statistics_.bytes -= packed_.bytes();
  packed_.clear();
  cholmod_l_free_work(common); // its memory serves for the copies of the factor
  a_.forget_values();
  set_precision(storage_);
  statistics_.seconds_factor = cpu_seconds() - start;
  factored_ = true;
}

/// Reads the diagonal of L, which lies scattered in memory, once; throws where a pivot is not
/// finite or is nothing but rounding.
void Cholesky::check_pivots() {
  const auto* super = static_cast<const Long*>(l_->super);
  const auto* row_start = static_cast<const Long*>(l_->pi);
  const auto* value_start = static_cast<const Long*>(l_->px);
  double least = std::numeric_limits<double>::infinity();
  int where = -1;
  for (std::size_t s = 0; s < l_->nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long position = super[s]; position < super[s + 1]; ++position) {
      const double entry = values()[value_start[s] + (position - super[s]) * (stride + 1)];
      const double pivot = entry * entry / a_.diagonal()[position];
      if (!std::isfinite(pivot)) fail_at(static_cast<int>(position), pivot);
      if (pivot < least) {
        least = pivot;
        where = static_cast<int>(position);
      }
      if (position < interior_) inverse_diagonal_[position] = 1.0 / entry;
    }
  }
  if (least < smallest_pivot) fail_at(where, least);
}

void Cholesky::fail_at(int position, double pivot) const {
  const bool known = position >= 0 && position < size_;
  throw NotFactorable(known ? permutation_[position] : -1, pivot,
                      "the matrix is not positive definite: the elimination breaks down");
}

/// Gathers the contact columns, which lie in one or several supernodes, into a dense L22.
void Cholesky::read_trailing_block() {
  const int contacts = size_ - interior_;
  l22_.setZero(contacts, contacts);
  const auto* super = static_cast<const Long*>(l_->super);
  const auto* row_start = static_cast<const Long*>(l_->pi);
  const auto* value_start = static_cast<const Long*>(l_->px);
  const auto* row = static_cast<const Long*>(l_->s);
  for (std::size_t s = 0; s < l_->nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long column = std::max<Long>(super[s], interior_); column < super[s + 1]; ++column)
      for (Long i = column - super[s]; i < stride; ++i)
        l22_(row[row_start[s] + i] - interior_, column - interior_) =
            values()[value_start[s] + (column - super[s]) * stride + i];
  }
}

bool Cholesky::set_precision(FactorPrecision storage) {
  storage_ = storage;
  if (storage != FactorPrecision::full && packed_.empty()) {
    if (packed_.pack(supernodes_, values()))
      statistics_.bytes += packed_.bytes();
    else
      storage_ = FactorPrecision::full;
  }
  return storage_ == storage;
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
  for (int position = 0; position < size_; ++position) y_[position] = b[permutation_[position]];
  storage_of_y_ = storage_;
  if (storage_ == FactorPrecision::full)
    supernodes_.forward(values(), inverse_diagonal_.data(), y_.data());
  else
    packed_.forward(storage_ == FactorPrecision::fine, y_.data());
  r.resize(size_ - interior_);
  std::copy(y_.begin() + interior_, y_.end(), r.data());
  count_solve();
}

/// A triangular solve reads the columns of the interior in the chosen precision.
void Cholesky::count_solve() {
  ++statistics_.triangular_solves;
  const double n_contact = size_ - interior_;
  const double entries = static_cast<double>(l_->xsize) - n_contact * n_contact;
  statistics_.bytes_read += storage_ == FactorPrecision::full
                                ? entries * sizeof(double)
                                : packed_.bytes_read(storage_ == FactorPrecision::fine);
}

void Cholesky::back(const Vector& c, Vector& x) {
  if (!factored_) throw std::logic_error("back before a successful factorisation");
  std::copy_n(c.data(), size_ - interior_, x_.begin() + interior_);
  const bool full = storage_ == FactorPrecision::full;
  if (full != (storage_of_y_ == FactorPrecision::full)) // packed solves take y over L's diagonal
    for (int i = 0; i < interior_; ++i)
      y_[i] *= full ? 1.0 / inverse_diagonal_[i] : inverse_diagonal_[i];
  storage_of_y_ = storage_;
  if (full)
    supernodes_.backward(values(), inverse_diagonal_.data(), y_.data(), x_.data());
  else
    packed_.backward(storage_ == FactorPrecision::fine, y_.data(), x_.data());
  x.resize(size_);
  for (int position = 0; position < size_; ++position) x[permutation_[position]] = x_[position];
  count_solve();
}

void Cholesky::extend(const Vector& c, Vector& x) {
  std::fill_n(y_.begin(), interior_, 0.0);
  storage_of_y_ = storage_;
  back(c, x);
}

Vector Cholesky::kept() const {
  Vector out = Eigen::Map<const Vector>(y_.data(), interior_);
  if (storage_of_y_ != FactorPrecision::full) // packed solves leave y over L's diagonal
    out.array() /= Eigen::Map<const Vector>(inverse_diagonal_.data(), interior_).array();
  return out;
}

void Cholesky::resume(const Vector& kept) {
  std::copy_n(kept.data(), interior_, y_.begin());
  storage_of_y_ = FactorPrecision::full;
}

/// In double precision: many right-hand sides are those of checks.
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
    for (int k = 0; k < count; ++k) each_(k, position) = b[k][permutation_[position]];
  supernodes_.forward_all(values(), inverse_diagonal_.data(), groups, each_.data());
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
  supernodes_.backward_all(values(), inverse_diagonal_.data(), groups, each_.data());
  x.assign(c.size(), Vector(size_));
  for (int position = 0; position < size_; ++position)
    for (int k = 0; k < count; ++k) x[k][permutation_[position]] = each_(k, position);
  each_.resize(0, 0);
  count_solves_at_once();
}

/// In double precision, too.
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
  supernodes_.backward_all(values(), inverse_diagonal_.data(), groups, x.data());
  place.resize(static_cast<std::size_t>(size_));
  for (int position = 0; position < size_; ++position) place[permutation_[position]] = position;
  count_solves_at_once();
}

void Cholesky::count_solves_at_once() {
  ++statistics_.triangular_solves;
  statistics_.bytes_read += supernodes_.nonzeros() * sizeof(double);
}

/// |L^-1 b|^2.
std::optional<double> Cholesky::energy(const Vector& b) {
  reduce(b, reduced_);
  if (interior_ < size_) l22_.triangularView<Eigen::Lower>().solveInPlace(reduced_);
  return kept().squaredNorm() + reduced_.squaredNorm();
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
