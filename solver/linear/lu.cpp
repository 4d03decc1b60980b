// The unsymmetric factorisation. K is coercive, so each diagonal pivot of an elimination in any
// order is safe: UMFPACK is made to use the diagonal and an order with the contact unknowns last.
// Then the trailing blocks of its L and U give S = L22 U22 without a solve, and the two triangular
// solves of a step read L once and U once, as with Cholesky.
//
// T. A. Davis, Algorithm 832: UMFPACK, an unsymmetric-pattern multifrontal method, ACM Trans. Math.
// Softw. 30 (2004) 196-199.
#include "solver/linear/lu.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/linear/one_blas_thread.hpp"
#include "solver/linear/ordering.hpp"

#include <fmt/format.h>

#include <umfpack.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {
namespace {

struct FreeSymbolic {
  void operator()(void* object) const { umfpack_dl_free_symbolic(&object); }
};
struct FreeNumeric {
  void operator()(void* object) const { umfpack_dl_free_numeric(&object); }
};
using Symbolic = std::shared_ptr<void>; ///< of one or several factors
using Numeric = std::unique_ptr<void, FreeNumeric>;

/// A triangle by rows, or its transpose by columns; the last entry of a row is the diagonal.
struct Triangle {
  std::vector<Long> start;
  std::vector<int> index;
  std::vector<double> value;

  double bytes() const {
    return static_cast<double>(value.size()) * (sizeof(double) + sizeof(int));
  }
  /// y := T^-1 y for the first `count` unknowns; y := y - (their columns) y for the rest.
  void forward(int count, double* y) const {
    const int size = static_cast<int>(start.size()) - 1;
    for (int row = 0; row < size; ++row) {
      double sum = y[row];
      Long at = start[row];
      const Long end = row < count ? start[row + 1] - 1 : start[row + 1];
      for (; at < end && index[at] < count; ++at) sum -= value[at] * y[index[at]];
      y[row] = row < count ? sum / value[end] : sum;
    }
  }
  /// x := T^-T x where the unknowns from `count` on are given.
  void backward(int count, double* x) const {
    for (int row = static_cast<int>(start.size()) - 2; row >= 0; --row) {
      const Long diagonal = start[row + 1] - 1;
      if (row < count) x[row] /= value[diagonal];
      Long at = start[row];
      for (; at < diagonal && index[at] < count; ++at) x[index[at]] -= value[at] * x[row];
    }
  }
  /// The trailing block from `count` on.
  DenseMatrix trailing(int count) const {
    const auto size = static_cast<Eigen::Index>(start.size()) - 1 - count;
    DenseMatrix block = DenseMatrix::Zero(size, size);
    for (Eigen::Index row = 0; row < size; ++row)
      for (Long at = start[row + count]; at < start[row + count + 1]; ++at)
        if (index[at] >= count) block(row, index[at] - count) = value[at];
    return block;
  }
};

class Lu final : public Factorisation {
public:
  Lu(const SparseMatrix& k, std::span<const int> contact);
  std::unique_ptr<Factorisation> another() const override;
  void factor(const SparseMatrix& k) override;
  void reduce(const Vector& b, Vector& r) override;
  void back(const Vector& c, Vector& x) override;
  Vector kept() const override { return y_.head(interior_); }
  void resume(const Vector& kept) override { y_.head(interior_) = kept; }
  void solve(const Vector& b, Vector& x) override;
  void solve_transposed(const Vector& b, Vector& x) override;
  const DenseMatrix& schur() const override { return schur_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void order(const SparseMatrix& k, std::span<const int> contact);
  void check_pattern(const SparseMatrix& k) const;
  Numeric factor_with_umfpack(const SparseMatrix& k);
  void take_triangles(void* numeric);
  void check_pivots(const SparseMatrix& k) const;
  [[noreturn]] void fail_at(int position, double pivot) const;

  int size_, interior_;
  std::vector<Long> start_, column_; ///< the pattern of K by rows
  std::vector<Long> permutation_;    ///< position -> unknown
  std::array<double, UMFPACK_CONTROL> control_{};
  Symbolic symbolic_;
  // UMFPACK takes the rows of K for columns, so it factors the transpose: K = L U with the lower
  // triangle by rows and the (unit) upper one by columns, as the two triangular solves read them.
  Triangle lower_, upper_transposed_;
  DenseMatrix lower22_, upper22_, schur_;
  Vector y_, x_, reduced_;
  bool factored_ = false;
  double bytes_to_factor_ = 0.0;
  FactorStatistics statistics_;
};

Lu::Lu(const SparseMatrix& k, std::span<const int> contact)
    : size_(static_cast<int>(k.rows())), interior_(size_ - static_cast<int>(contact.size())),
      start_(k.outerIndexPtr(), k.outerIndexPtr() + k.rows() + 1),
      column_(k.innerIndexPtr(), k.innerIndexPtr() + k.nonZeros()), y_(size_), x_(size_) {
  const double start = cpu_seconds();
  order(k, contact);
  umfpack_dl_defaults(control_.data());
  control_[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
  control_[UMFPACK_SYM_PIVOT_TOLERANCE] = 0.0;
  control_[UMFPACK_FIXQ] = 1.0;
  control_[UMFPACK_SINGLETONS] = 0.0; // they would be eliminated first, contact or not
  control_[UMFPACK_SCALE] = UMFPACK_SCALE_NONE;
  void* symbolic = nullptr;
  const auto status =
      umfpack_dl_qsymbolic(size_, size_, start_.data(), column_.data(), nullptr,
                           permutation_.data(), &symbolic, control_.data(), nullptr);
  symbolic_ = Symbolic(symbolic, FreeSymbolic{});
  if (status < 0) throw OutOfMemory("no memory to analyse a matrix of {} unknowns", size_);
  statistics_.analyses = 1;
  statistics_.seconds_analyse = cpu_seconds() - start;
}

std::unique_ptr<Factorisation> Lu::another() const {
  auto out = std::make_unique<Lu>(*this);
  out->factored_ = false;
  out->statistics_ = {};
  out->statistics_.ordering = statistics_.ordering;
  out->statistics_.bytes = bytes_to_factor_;
  return out;
}

/// Contact last, then postordered: the frontal matrices of UMFPACK follow the elimination tree.
void Lu::order(const SparseMatrix& k, std::span<const int> contact) {
  CholmodSession session;
  const ContactLastOrder order = order_contact_last(k, contact, session);
  statistics_.ordering = order.name;
  // UMFPACK's own L and U, their copy with indices of 64 bits, and ours with 32.
  bytes_to_factor_ = 2.0 * order.nonzeros * (2 * sizeof(double) + 3 * sizeof(Long) - sizeof(int));
  statistics_.bytes = bytes_to_factor_;
  permutation_ = order.permutation;
  if (!std::equal(contact.begin(), contact.end(), permutation_.begin() + interior_))
    throw std::logic_error("the postorder moved a contact unknown from the end of the elimination");
}

void Lu::check_pattern(const SparseMatrix& k) const {
  if (!k.isCompressed() || k.rows() != size_ ||
      !std::equal(start_.begin(), start_.end(), k.outerIndexPtr()) ||
      !std::equal(column_.begin(), column_.end(), k.innerIndexPtr()))
    throw Failure(FailureKind::bad_value, {},
                  "the matrix to factor does not have the pattern that was analysed");
}

Numeric Lu::factor_with_umfpack(const SparseMatrix& k) {
  std::array<double, UMFPACK_INFO> info{};
  void* numeric = nullptr;
  const auto status = umfpack_dl_numeric(start_.data(), column_.data(), k.valuePtr(),
                                         symbolic_.get(), &numeric, control_.data(), info.data());
  if (status < 0) throw OutOfMemory("no memory to factor a matrix of {} unknowns", size_);
  ++statistics_.factorisations;
  statistics_.flops = info[UMFPACK_FLOPS];
  return Numeric(numeric);
}

void Lu::factor(const SparseMatrix& k) {
  const double start = cpu_seconds();
  const OneBlasThread one_thread;
  factored_ = false;
  check_pattern(k);
  take_triangles(factor_with_umfpack(k).get());
  check_pivots(k);
  lower22_ = lower_.trailing(interior_);
  upper22_ = upper_transposed_.trailing(interior_).transpose();
  schur_.noalias() = lower22_ * upper22_;
  statistics_.seconds_factor = cpu_seconds() - start;
  factored_ = true;
}

/// Copies L and U, with 32-bit indices in ascending order; throws where a pivot is not diagonal.
void Lu::take_triangles(void* numeric) {
  Long l_entries = 0, u_entries = 0, rows = 0, columns = 0, diagonals = 0;
  // Where UMFPACK has no memory to unpack an array it leaves it unchanged.
  const auto check = [this](Long status) {
    if (status < 0) throw OutOfMemory("no memory for a factor of {} unknowns", size_);
  };
  check(umfpack_dl_get_lunz(&l_entries, &u_entries, &rows, &columns, &diagonals, numeric));
  const auto n = static_cast<std::size_t>(size_);
  std::vector<Long> l_index(l_entries), u_index(u_entries), row_order(n), column_order(n);
  Triangle& u = lower_; // U of the transpose is L of K
  Triangle& l = upper_transposed_;
  l.start.resize(n + 1);
  u.start.resize(n + 1);
  l.value.resize(l_entries);
  u.value.resize(u_entries);
  check(umfpack_dl_get_numeric(l.start.data(), l_index.data(), l.value.data(), u.start.data(),
                               u_index.data(), u.value.data(), row_order.data(),
                               column_order.data(), nullptr, nullptr, nullptr, numeric));
  l.index.assign(l_index.begin(), l_index.end());
  u.index.assign(u_index.begin(), u_index.end());
  if (column_order != permutation_) throw std::logic_error("UMFPACK changed the given order");
  // A zero on the diagonal is the only reason to leave it.
  const auto moved = std::ranges::mismatch(row_order, permutation_).in1 - row_order.begin();
  if (moved < size_) fail_at(static_cast<int>(moved), 0.0);
  statistics_.nonzeros = static_cast<double>(l_entries + u_entries);
  statistics_.bytes = statistics_.nonzeros * (sizeof(double) + sizeof(int));
}

void Lu::check_pivots(const SparseMatrix& k) const {
  const Vector diagonal = k.diagonal();
  double least = 1.0;
  int where = -1;
  for (int position = 0; position < size_; ++position) {
    const double entry = lower_.value[lower_.start[position + 1] - 1];
    const double pivot = entry / diagonal[permutation_[position]];
    if (!std::isfinite(pivot)) fail_at(position, pivot);
    if (pivot < least) {
      least = pivot;
      where = position;
    }
  }
  if (least < smallest_pivot) fail_at(where, least);
}

void Lu::fail_at(int position, double pivot) const {
  throw NotFactorable(static_cast<int>(permutation_[position]), pivot,
                      "the matrix is not coercive: the elimination breaks down");
}

void Lu::reduce(const Vector& b, Vector& r) {
  if (!factored_) throw std::logic_error("reduce before a successful factorisation");
  for (int position = 0; position < size_; ++position) y_[position] = b[permutation_[position]];
  lower_.forward(interior_, y_.data());
  r = y_.tail(size_ - interior_);
  ++statistics_.triangular_solves;
  statistics_.bytes_read += lower_.bytes();
}

void Lu::back(const Vector& c, Vector& x) {
  if (!factored_) throw std::logic_error("back before a successful factorisation");
  x_ = y_;
  x_.tail(size_ - interior_) = c;
  upper_transposed_.backward(interior_, x_.data());
  x.resize(size_);
  for (int position = 0; position < size_; ++position) x[permutation_[position]] = x_[position];
  ++statistics_.triangular_solves;
  statistics_.bytes_read += upper_transposed_.bytes();
}

void Lu::solve(const Vector& b, Vector& x) {
  reduce(b, reduced_);
  if (interior_ < size_) {
    lower22_.triangularView<Eigen::Lower>().solveInPlace(reduced_);
    upper22_.triangularView<Eigen::UnitUpper>().solveInPlace(reduced_);
  }
  back(reduced_, x);
}

/// U^T first, then L^T: the same two triangles the other way round.
void Lu::solve_transposed(const Vector& b, Vector& x) {
  if (!factored_) throw std::logic_error("solve before a successful factorisation");
  for (int position = 0; position < size_; ++position) x_[position] = b[permutation_[position]];
  upper_transposed_.forward(size_, x_.data());
  lower_.backward(size_, x_.data());
  x.resize(size_);
  for (int position = 0; position < size_; ++position) x[permutation_[position]] = x_[position];
  statistics_.triangular_solves += 2;
  statistics_.bytes_read += upper_transposed_.bytes() + lower_.bytes();
}

} // namespace

std::unique_ptr<Factorisation> analyse_lu(const SparseMatrix& k, std::span<const int> contact) {
  return std::make_unique<Lu>(k, contact);
}

} // namespace hvi::solver
