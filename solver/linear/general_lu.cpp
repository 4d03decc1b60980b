// UMFPACK with pivots chosen by their size, on a matrix whose rows and columns have been scaled.
//
// Pivoting leaves no order with the contact unknowns last, so the whole of K is factored, and
//   S = ((K^-1)_cc)^-1,   r = S x0_c,   x = x0 + K^-1 E_c S (c - x0_c),   x0 = K^-1 b.
//
// The scaling: P. A. Knight, D. Ruiz, B. Ucar, A symmetry preserving algorithm for matrix scaling,
// INRIA research report 7552, 2012.
#include "solver/linear/general_lu.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/linear/cholmod_session.hpp"
#include "solver/linear/one_blas_thread.hpp"
#include "solver/linear/umfpack_objects.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {
namespace {

/// Each halves the exponent of what is too large or too small.
constexpr int scaling_passes = 6;

/// K without its zeros, by rows, with R K C in place of K: the largest entries of its rows and
/// columns are near 1 whatever the units of the unknowns are.
struct ScaledMatrix {
  std::vector<Long> start, column;
  std::vector<double> value;
  Vector row_scale, column_scale;

  explicit ScaledMatrix(const SparseMatrix& k);
  Long size() const { return static_cast<Long>(start.size()) - 1; }
  bool same_pattern(const ScaledMatrix& other) const {
    return start == other.start && column == other.column;
  }

private:
  void scale_once();
};

ScaledMatrix::ScaledMatrix(const SparseMatrix& k)
    : start{0}, row_scale(Vector::Ones(k.rows())), column_scale(Vector::Ones(k.rows())) {
  for (int i = 0; i < k.rows(); ++i) {
    for (SparseMatrix::InnerIterator it(k, i); it; ++it)
      if (it.value() != 0.0) {
        column.push_back(it.col());
        value.push_back(it.value());
      }
    start.push_back(static_cast<Long>(column.size()));
  }
  for (int pass = 0; pass < scaling_passes; ++pass) scale_once();
}

void ScaledMatrix::scale_once() {
  Vector rows = Vector::Zero(size()), columns = Vector::Zero(size());
  for (Long i = 0; i < size(); ++i)
    for (Long e = start[i]; e < start[i + 1]; ++e) {
      rows[i] = std::max(rows[i], std::abs(value[e]));
      columns[column[e]] = std::max(columns[column[e]], std::abs(value[e]));
    }
  const auto factor = [](double largest) { return largest > 0.0 ? 1.0 / std::sqrt(largest) : 1.0; };
  rows = rows.unaryExpr(factor), columns = columns.unaryExpr(factor);
  for (Long i = 0; i < size(); ++i)
    for (Long e = start[i]; e < start[i + 1]; ++e) value[e] *= rows[i] * columns[column[e]];
  row_scale = row_scale.cwiseProduct(rows);
  column_scale = column_scale.cwiseProduct(columns);
}

/// Below it the matrix of contact unknowns is rounding.
constexpr double smallest_condition = 1e-13;

/// Of a dense matrix: factors of its rows and columns that bring their largest entries near 1.
struct DenseScaling {
  Vector rows, columns;
  explicit DenseScaling(const DenseMatrix& m)
      : rows(Vector::Ones(m.rows())), columns(Vector::Ones(m.cols())) {
    DenseMatrix scaled = m;
    const auto factor = [](double largest) {
      return largest > 0.0 ? 1.0 / std::sqrt(largest) : 1.0;
    };
    for (int pass = 0; pass < scaling_passes; ++pass) {
      const Vector r = scaled.cwiseAbs().rowwise().maxCoeff().unaryExpr(factor),
                   c = scaled.cwiseAbs().colwise().maxCoeff().transpose().unaryExpr(factor);
      rows = rows.cwiseProduct(r), columns = columns.cwiseProduct(c);
      scaled = r.asDiagonal() * scaled * c.asDiagonal();
    }
  }
};

class GeneralLu final : public Factorisation {
public:
  explicit GeneralLu(std::span<const int> contact) : contact_(contact.begin(), contact.end()) {
    umfpack_dl_defaults(control_.data());
    control_[UMFPACK_SCALE] = UMFPACK_SCALE_NONE; // it is
    control_[UMFPACK_IRSTEP] = 0;                 // those who solve correct what they have to
    statistics_.ordering = "AMD or COLAMD";
  }
  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<GeneralLu>(contact_);
  }
  void analyse(const SparseMatrix& k);
  void factor(const SparseMatrix& k) override;
  void forward(RightHandSides y, Columns columns) override;
  void back(RightHandSides y, Columns columns) override;
  const DenseMatrix& schur() const override { return schur_; }
  const EliminationOrder& order() const override { return order_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void find_order(const ScaledMatrix& matrix);
  void factor_numbers();
  void check_pivots() const;
  void make_schur();
  void place(Eigen::Index size);
  void apply_inverse(const Vector& b, Vector& x, bool transposed);
  Vector moved_by(const Vector& c);

  std::vector<int> contact_;
  std::array<double, UMFPACK_CONTROL> control_{};
  std::unique_ptr<ScaledMatrix> matrix_;
  std::unique_ptr<void, FreeSymbolic> symbolic_;
  std::unique_ptr<void, FreeNumeric> numeric_;
  EliminationOrder order_; ///< UMFPACK has its own: the interior as it is numbered
  DenseMatrix schur_;
  FactorStatistics statistics_;
};

/// What a factorisation will take. In an order for a symmetric pattern UMFPACK counts the entries
/// of the factors; else it has a bound, of which a Stokes problem fills 0.38.
double bytes_to_come(std::span<const double> info) {
  constexpr double bytes_per_entry = 9.0, part_of_bound = 0.4;
  const double bound = info[UMFPACK_PEAK_MEMORY_ESTIMATE] * info[UMFPACK_SIZE_OF_UNIT];
  const double counted = info[UMFPACK_SYMMETRIC_LUNZ] * bytes_per_entry;
  return counted > 0.0 ? std::min(counted, bound) : part_of_bound * bound;
}

void GeneralLu::find_order(const ScaledMatrix& matrix) {
  if (symbolic_ && matrix_ && matrix.same_pattern(*matrix_)) return;
  const double start = cpu_seconds();
  std::array<double, UMFPACK_INFO> info{};
  void* symbolic = nullptr;
  const auto status =
      umfpack_dl_symbolic(matrix.size(), matrix.size(), matrix.start.data(), matrix.column.data(),
                          matrix.value.data(), &symbolic, control_.data(), info.data());
  symbolic_.reset(symbolic);
  if (status == UMFPACK_ERROR_out_of_memory)
    throw OutOfMemory("no memory to analyse a matrix of {} unknowns", matrix.size());
  if (status < 0) throw NotFactorable(-1, 0.0, "the matrix has an empty row");
  statistics_.bytes = bytes_to_come(info);
  ++statistics_.analyses;
  statistics_.seconds_analyse += cpu_seconds() - start;
}

/// The rows of K are UMFPACK's columns: it has the factors of the transpose.
void GeneralLu::factor_numbers() {
  std::array<double, UMFPACK_INFO> info{};
  void* numeric = nullptr;
  const auto status =
      umfpack_dl_numeric(matrix_->start.data(), matrix_->column.data(), matrix_->value.data(),
                         symbolic_.get(), &numeric, control_.data(), info.data());
  numeric_.reset(numeric);
  if (status < 0) throw OutOfMemory("no memory to factor a matrix of {} unknowns", matrix_->size());
  ++statistics_.factorisations;
  statistics_.flops = info[UMFPACK_FLOPS];
  statistics_.nonzeros = info[UMFPACK_LNZ] + info[UMFPACK_UNZ];
  statistics_.bytes = info[UMFPACK_NUMERIC_SIZE] * info[UMFPACK_SIZE_OF_UNIT];
}

/// A pivot that is rounding of the scaled entries: K has no inverse.
void GeneralLu::check_pivots() const {
  const auto n = static_cast<std::size_t>(matrix_->size());
  Vector pivots(matrix_->size());
  std::vector<Long> order(n);
  Long scaled = 0;
  if (umfpack_dl_get_numeric(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
                             order.data(), pivots.data(), &scaled, nullptr, numeric_.get()) < 0)
    throw OutOfMemory("no memory for a factor of {} unknowns", n);
  Eigen::Index at = 0;
  const double least = pivots.cwiseAbs().minCoeff(&at), most = pivots.cwiseAbs().maxCoeff();
  if (least > smallest_pivot * most) return; // false for NaN
  throw NotFactorable(static_cast<int>(order[static_cast<std::size_t>(at)]), least / most,
                      "the matrix is singular: the elimination breaks down");
}

void GeneralLu::make_schur() {
  const auto n = static_cast<Eigen::Index>(contact_.size());
  DenseMatrix inverse(n, n);
  Vector unit = Vector::Zero(matrix_->size()), x;
  for (Eigen::Index j = 0; j < n; ++j) {
    unit[contact_[static_cast<std::size_t>(j)]] = 1.0;
    apply_inverse(unit, x, false);
    unit[contact_[static_cast<std::size_t>(j)]] = 0.0;
    inverse.col(j) = x(contact_);
  }
  if (n == 0) return;
  // With a scaling of its own. That of K leaves the stiffness of a displacement as far below 1 as a
  // pressure in small units has large couplings, and its inverse as far above.
  const auto [rows, columns] = DenseScaling(inverse);
  const Eigen::PartialPivLU<DenseMatrix> lu(rows.asDiagonal() * inverse * columns.asDiagonal());
  if (!(lu.rcond() > smallest_condition))
    throw NotFactorable(-1, lu.rcond(), "the matrix is singular without its contact unknowns");
  schur_ = columns.asDiagonal() * lu.inverse() * rows.asDiagonal();
}

void GeneralLu::place(Eigen::Index size) {
  if (order_.size() == size) return;
  std::vector<char> of_contact(static_cast<std::size_t>(size), 0);
  for (const int i : contact_) of_contact[static_cast<std::size_t>(i)] = 1;
  order_.unknown.clear();
  for (int i = 0; i < size; ++i)
    if (of_contact[static_cast<std::size_t>(i)] == 0) order_.unknown.push_back(i);
  order_.interior = static_cast<int>(order_.unknown.size());
  order_.unknown.insert(order_.unknown.end(), contact_.begin(), contact_.end());
}

void GeneralLu::analyse(const SparseMatrix& k) {
  place(k.rows());
  auto matrix = std::make_unique<ScaledMatrix>(k);
  find_order(*matrix);
  matrix_ = std::move(matrix);
}

void GeneralLu::factor(const SparseMatrix& k) {
  const OneBlasThread one_thread;
  place(k.rows());
  auto matrix = std::make_unique<ScaledMatrix>(k);
  find_order(*matrix);
  matrix_ = std::move(matrix);
  const double start = cpu_seconds();
  factor_numbers();
  check_pivots();
  make_schur();
  statistics_.seconds_factor += cpu_seconds() - start;
}

void GeneralLu::apply_inverse(const Vector& b, Vector& x, bool transposed) {
  const Vector& in = transposed ? matrix_->column_scale : matrix_->row_scale;
  const Vector& out = transposed ? matrix_->row_scale : matrix_->column_scale;
  const Vector scaled = in.cwiseProduct(b);
  x.resize(matrix_->size());
  umfpack_dl_solve(transposed ? UMFPACK_A : UMFPACK_At, matrix_->start.data(),
                   matrix_->column.data(), matrix_->value.data(), x.data(), scaled.data(),
                   numeric_.get(), control_.data(), nullptr);
  x = out.cwiseProduct(x);
  statistics_.triangular_solves += 2;
  statistics_.bytes_read += statistics_.bytes;
}

/// x with x_c = c and nothing else that acts: K^-1 E_c S c.
Vector GeneralLu::moved_by(const Vector& c) {
  Vector force = Vector::Zero(matrix_->size()), out;
  force(contact_) = schur_ * c;
  apply_inverse(force, out, false);
  return out;
}

/// Of the interior: x for c = 0, and r = S x0_c.
void GeneralLu::forward(RightHandSides y, Columns columns) {
  Vector b(order_.size()), x;
  for (int k = 0; k < y.count; ++k) {
    for (int p = 0; p < order_.size(); ++p) b[order_.unknown[p]] = y.values[p * y.stride + k];
    apply_inverse(b, x, columns == Columns::transposed);
    if (columns == Columns::interior && !contact_.empty()) {
      const Vector at_contact = x(contact_);
      x -= moved_by(at_contact);
      x(contact_) = schur_ * at_contact;
    }
    for (int p = 0; p < order_.size(); ++p) y.values[p * y.stride + k] = x[order_.unknown[p]];
  }
}

void GeneralLu::back(RightHandSides y, Columns columns) {
  if (columns != Columns::interior || contact_.empty()) return;
  Vector c(order_.contacts());
  for (int k = 0; k < y.count; ++k) {
    for (int i = 0; i < c.size(); ++i) c[i] = y.values[(order_.interior + i) * y.stride + k];
    const Vector x = moved_by(c);
    for (int p = 0; p < order_.interior; ++p) y.values[p * y.stride + k] += x[order_.unknown[p]];
  }
}

} // namespace

std::unique_ptr<Factorisation> general_factor(const SparseMatrix& k, std::span<const int> contact) {
  auto out = std::make_unique<GeneralLu>(contact);
  out->analyse(k);
  return out;
}

} // namespace hvi::solver
