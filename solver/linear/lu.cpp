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
#include "solver/linear/blas_threads.hpp"
#include "solver/linear/ordering.hpp"
#include "solver/linear/umfpack_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace hvi::solver {
namespace {

using Symbolic = std::unique_ptr<void, FreeSymbolic>;
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

/// An order of elimination for a pattern and what UMFPACK makes of both; factors may share it.
class LuAnalysis {
public:
  LuAnalysis(const SparseMatrix& k, std::span<const int> contact);
  /// Throws Failure(bad_value) where K has another pattern, OutOfMemory.
  Numeric factor(const SparseMatrix& k, double& flops) const;

  EliminationOrder order;
  std::string ordering; ///< who found it
  double bytes = 0.0;   ///< that a factorisation takes

private:
  void check_pattern(const SparseMatrix& k) const;

  std::vector<Long> start_, column_; ///< the pattern of K by rows
  std::array<double, UMFPACK_CONTROL> control_{};
  Symbolic symbolic_;
};

/// Contact last, then postordered: the frontal matrices of UMFPACK follow the elimination tree.
LuAnalysis::LuAnalysis(const SparseMatrix& k, std::span<const int> contact)
    : start_(k.outerIndexPtr(), k.outerIndexPtr() + k.rows() + 1),
      column_(k.innerIndexPtr(), k.innerIndexPtr() + k.nonZeros()) {
  CholmodSession session;
  const ContactLastOrder found = order_contact_last(k, contact, session);
  order = elimination_order(found, contact);
  ordering = found.name;
  // UMFPACK's own L and U, their copy with indices of 64 bits, and ours with 32.
  bytes = 2.0 * found.nonzeros * (2 * sizeof(double) + 3 * sizeof(Long) - sizeof(int));
  umfpack_dl_defaults(control_.data());
  control_[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
  control_[UMFPACK_SYM_PIVOT_TOLERANCE] = 0.0;
  control_[UMFPACK_FIXQ] = 1.0;
  control_[UMFPACK_SINGLETONS] = 0.0; // they would be eliminated first, contact or not
  control_[UMFPACK_SCALE] = UMFPACK_SCALE_NONE;
  void* symbolic = nullptr;
  const auto status =
      umfpack_dl_qsymbolic(order.size(), order.size(), start_.data(), column_.data(), nullptr,
                           found.permutation.data(), &symbolic, control_.data(), nullptr);
  symbolic_ = Symbolic(symbolic);
  if (status < 0) throw OutOfMemory("no memory to analyse a matrix of {} unknowns", order.size());
}

void LuAnalysis::check_pattern(const SparseMatrix& k) const {
  if (!k.isCompressed() || k.rows() != order.size() ||
      !std::equal(start_.begin(), start_.end(), k.outerIndexPtr()) ||
      !std::equal(column_.begin(), column_.end(), k.innerIndexPtr()))
    throw Failure(FailureKind::bad_value, {},
                  "the matrix to factor does not have the pattern that was analysed");
}

Numeric LuAnalysis::factor(const SparseMatrix& k, double& flops) const {
  check_pattern(k);
  std::array<double, UMFPACK_INFO> info{};
  void* numeric = nullptr;
  const auto status = umfpack_dl_numeric(start_.data(), column_.data(), k.valuePtr(),
                                         symbolic_.get(), &numeric, control_.data(), info.data());
  if (status < 0) throw OutOfMemory("no memory to factor a matrix of {} unknowns", order.size());
  flops = info[UMFPACK_FLOPS];
  return Numeric(numeric);
}

[[noreturn]] void fail_at(int position, double pivot, const EliminationOrder& order) {
  throw NotFactorable(order.unknown[position], pivot,
                      "the matrix is not coercive: the elimination breaks down");
}

/// UMFPACK takes the rows of K for columns, so it factors the transpose: K = L U with the lower
/// triangle by rows and the (unit) upper one by columns, as the two triangular solves read them.
struct LuFactor {
  Triangle lower, upper_transposed;
  DenseMatrix lower22, upper22, schur; ///< of the contact unknowns, S = L22 U22

  void take_triangles(void* numeric, const EliminationOrder& order);
  void check_pivots(const SparseMatrix& k, const EliminationOrder& order) const;
  void take_trailing_blocks(int interior);
};

/// Copies L and U, with 32-bit indices in ascending order; throws where a pivot is not diagonal.
void LuFactor::take_triangles(void* numeric, const EliminationOrder& order) {
  Long l_entries = 0, u_entries = 0, rows = 0, columns = 0, diagonals = 0;
  // Where UMFPACK has no memory to unpack an array it leaves it unchanged.
  const auto check = [&](Long status) {
    if (status < 0) throw OutOfMemory("no memory for a factor of {} unknowns", order.size());
  };
  check(umfpack_dl_get_lunz(&l_entries, &u_entries, &rows, &columns, &diagonals, numeric));
  const auto n = order.unknown.size();
  std::vector<Long> l_index(l_entries), u_index(u_entries), row_order(n), column_order(n);
  Triangle& u = lower; // U of the transpose is L of K
  Triangle& l = upper_transposed;
  l.start.resize(n + 1);
  u.start.resize(n + 1);
  l.value.resize(l_entries);
  u.value.resize(u_entries);
  check(umfpack_dl_get_numeric(l.start.data(), l_index.data(), l.value.data(), u.start.data(),
                               u_index.data(), u.value.data(), row_order.data(),
                               column_order.data(), nullptr, nullptr, nullptr, numeric));
  l.index.assign(l_index.begin(), l_index.end());
  u.index.assign(u_index.begin(), u_index.end());
  if (!std::ranges::equal(column_order, order.unknown))
    throw std::logic_error("UMFPACK changed the given order");
  // A zero on the diagonal is the only reason to leave it.
  const auto moved = std::ranges::mismatch(row_order, order.unknown).in1 - row_order.begin();
  if (moved < order.size()) fail_at(static_cast<int>(moved), 0.0, order);
}

void LuFactor::check_pivots(const SparseMatrix& k, const EliminationOrder& order) const {
  const Vector diagonal = k.diagonal();
  double least = 1.0;
  int where = -1;
  for (int position = 0; position < order.size(); ++position) {
    const double entry = lower.value[lower.start[position + 1] - 1];
    const double pivot = entry / diagonal[order.unknown[position]];
    if (!std::isfinite(pivot)) fail_at(position, pivot, order);
    if (pivot < least) {
      least = pivot;
      where = position;
    }
  }
  if (least < smallest_pivot) fail_at(where, least, order);
}

void LuFactor::take_trailing_blocks(int interior) {
  lower22 = lower.trailing(interior);
  upper22 = upper_transposed.trailing(interior).transpose();
  schur.noalias() = lower22 * upper22;
}

/// As `act` has it, for each of the right-hand sides by itself.
template <class F>
void for_each_of(RightHandSides y, int size, F&& act) {
  if (y.stride == 1) return act(y.values);
  Vector one(size);
  for (int k = 0; k < y.count; ++k) {
    for (int i = 0; i < size; ++i) one[i] = y.values[static_cast<std::ptrdiff_t>(i) * y.stride + k];
    act(one.data());
    for (int i = 0; i < size; ++i) y.values[static_cast<std::ptrdiff_t>(i) * y.stride + k] = one[i];
  }
}

class Lu final : public Factorisation {
public:
  Lu(std::shared_ptr<const LuAnalysis> analysis, FactorStatistics so_far)
      : analysis_(std::move(analysis)), statistics_(std::move(so_far)) {
    statistics_.ordering = analysis_->ordering;
    statistics_.bytes = analysis_->bytes;
  }
  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<Lu>(analysis_, FactorStatistics());
  }
  void factor(const SparseMatrix& k) override;
  void forward(RightHandSides y, Columns columns) override;
  void back(RightHandSides y, Columns columns) override;
  const DenseMatrix& schur() const override { return factor_.schur; }
  const EliminationOrder& order() const override { return analysis_->order; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void count_solve(const Triangle& read);

  std::shared_ptr<const LuAnalysis> analysis_;
  LuFactor factor_;
  bool factored_ = false;
  FactorStatistics statistics_;
};

void Lu::factor(const SparseMatrix& k) {
  const double start = cpu_seconds();
  const OneBlasThread one_thread;
  factored_ = false;
  {
    const Numeric numeric = analysis_->factor(k, statistics_.flops);
    ++statistics_.factorisations;
    factor_.take_triangles(numeric.get(), order());
  }
  statistics_.nonzeros =
      static_cast<double>(factor_.lower.value.size() + factor_.upper_transposed.value.size());
  statistics_.bytes = statistics_.nonzeros * (sizeof(double) + sizeof(int));
  factor_.check_pivots(k, order());
  factor_.take_trailing_blocks(order().interior);
  statistics_.seconds_factor += cpu_seconds() - start;
  factored_ = true;
}

/// The transpose has U^T first, then L^T: the same two triangles the other way round.
void Lu::forward(RightHandSides y, Columns columns) {
  const bool transposed = columns == Columns::transposed;
  const Triangle& triangle = transposed ? factor_.upper_transposed : factor_.lower;
  const int interior = order().interior;
  for_each_of(y, order().size(), [&](double* of) {
    count_solve(triangle);
    triangle.forward(transposed ? order().size() : interior, of);
  });
  if (columns != Columns::all) return;
  Eigen::Map<Vector> contact(y.only() + interior, order().contacts());
  factor_.lower22.triangularView<Eigen::Lower>().solveInPlace(contact);
}

void Lu::back(RightHandSides y, Columns columns) {
  const bool transposed = columns == Columns::transposed;
  const Triangle& triangle = transposed ? factor_.lower : factor_.upper_transposed;
  const int interior = order().interior;
  if (columns == Columns::all) {
    Eigen::Map<Vector> contact(y.only() + interior, order().contacts());
    factor_.upper22.triangularView<Eigen::UnitUpper>().solveInPlace(contact);
  }
  for_each_of(y, order().size(), [&](double* of) {
    count_solve(triangle);
    triangle.backward(transposed ? order().size() : interior, of);
  });
}

void Lu::count_solve(const Triangle& read) {
  if (!factored_) throw std::logic_error("a solve before a factorisation");
  ++statistics_.triangular_solves;
  statistics_.bytes_read += read.bytes();
}

} // namespace

std::unique_ptr<Factorisation> analyse_lu(const SparseMatrix& k, std::span<const int> contact) {
  const double start = cpu_seconds();
  auto analysis = std::make_shared<const LuAnalysis>(k, contact);
  FactorStatistics so_far;
  so_far.analyses = 1;
  so_far.seconds_analyse = cpu_seconds() - start;
  return std::make_unique<Lu>(std::move(analysis), so_far);
}

} // namespace hvi::solver
