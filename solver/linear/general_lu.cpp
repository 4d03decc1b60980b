// UMFPACK with pivots chosen by their size, on a matrix whose rows and columns have been scaled.
//
// Pivoting leaves no order with the contact unknowns last, so the interior alone is factored, and
//   S = K_cc - K_cI K_II^-1 K_Ic,   r = b_c - K_cI K_II^-1 b_I,   x_I = K_II^-1 (b_I - K_Ic c).
// (The factor of the whole of K would give S = ((K^-1)_cc)^-1; where springs or laws hold a body
// that is stiff itself, K^-1 is its rigid motion and the rest is lost in rounding.)
#include "solver/linear/general_lu.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/linear/blas_threads.hpp"
#include "solver/linear/cholmod_session.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/scaling.hpp"
#include "solver/linear/umfpack_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {
namespace {

/// The interior of K without its zeros, by rows, with R K C in place of K: the largest entries of
/// its rows and columns are near 1 whatever the units of the unknowns are.
struct ScaledMatrix {
  std::vector<Long> start, column;
  std::vector<double> value;
  Vector row_scale, column_scale;

  ScaledMatrix(const SparseMatrix& k, const EliminationOrder& order, std::span<const int> position);
  Long size() const { return static_cast<Long>(start.size()) - 1; }
  bool same_pattern(const ScaledMatrix& other) const {
    return start == other.start && column == other.column;
  }

private:
  void scale();
};

ScaledMatrix::ScaledMatrix(const SparseMatrix& k, const EliminationOrder& order,
                           std::span<const int> position)
    : start{0} {
  for (int row = 0; row < order.interior; ++row) {
    for (SparseMatrix::InnerIterator it(k, order.unknown[static_cast<std::size_t>(row)]); it; ++it)
      if (const int at = position[static_cast<std::size_t>(it.col())];
          at < order.interior && it.value() != 0.0) {
        column.push_back(at);
        value.push_back(it.value());
      }
    start.push_back(static_cast<Long>(column.size()));
  }
  scale();
}

void ScaledMatrix::scale() {
  const auto for_each = [this](const auto& f) {
    for (Long i = 0; i < size(); ++i)
      for (Long e = start[i]; e < start[i + 1]; ++e) f(i, column[e], value[e]);
  };
  auto [rows, columns] = scaling_of(size(), for_each);
  for (Long i = 0; i < size(); ++i)
    for (Long e = start[i]; e < start[i + 1]; ++e) value[e] *= rows[i] * columns[column[e]];
  row_scale = std::move(rows), column_scale = std::move(columns);
}

/// Below it the matrix of contact unknowns is rounding.
constexpr double smallest_condition = 1e-13;

Scaling dense_scaling(const DenseMatrix& m) {
  return scaling_of(m.rows(), [&m](const auto& f) {
    for (Eigen::Index j = 0; j < m.cols(); ++j)
      for (Eigen::Index i = 0; i < m.rows(); ++i) f(i, j, m(i, j));
  });
}

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
  void take_couplings(const SparseMatrix& k);
  void make_schur();
  void check_schur();
  void place(Eigen::Index size);
  void solve_interior(Vector& x, bool transposed);              ///< x = K_II^-1 x, or K_II^-T x
  Vector solve_contact(const Vector& r, bool transposed) const; ///< S^-1 r, or S^-T r

  std::vector<int> contact_;
  std::array<double, UMFPACK_CONTROL> control_{};
  std::unique_ptr<ScaledMatrix> matrix_;
  std::unique_ptr<void, FreeSymbolic> symbolic_;
  std::unique_ptr<void, FreeNumeric> numeric_;
  EliminationOrder order_;      ///< UMFPACK has its own: the interior as it is numbered
  std::vector<int> position_;   ///< by unknown, in that order
  SparseMatrix pulls_, pulled_; ///< K_cI, and the transpose of K_Ic
  DenseMatrix schur_;
  Vector schur_rows_, schur_columns_; ///< of its scaling
  DenseLu schur_factor_;
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
  if (matrix.size() == 0 || (symbolic_ && matrix_ && matrix.same_pattern(*matrix_))) return;
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
  if (pivots.allFinite() && least > smallest_pivot * most) return; // Eigen's bounds pass over NaN
  throw NotFactorable(order_.unknown[static_cast<std::size_t>(order[static_cast<std::size_t>(at)])],
                      least / most, "the matrix is singular: the elimination breaks down");
}

void GeneralLu::take_couplings(const SparseMatrix& k) {
  std::vector<Eigen::Triplet<double>> pulls, pulled;
  schur_.setZero(order_.contacts(), order_.contacts());
  for (int i = 0; i < k.rows(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
      const int row = position_[static_cast<std::size_t>(i)] - order_.interior,
                column = position_[static_cast<std::size_t>(it.col())] - order_.interior;
      if (row >= 0 && column >= 0) schur_(row, column) = it.value();
      if (row >= 0 && column < 0) pulls.emplace_back(row, column + order_.interior, it.value());
      if (row < 0 && column >= 0) pulled.emplace_back(column, row + order_.interior, it.value());
    }
  for (auto [to, entries] : {std::pair(&pulls_, &pulls), std::pair(&pulled_, &pulled)}) {
    to->resize(order_.contacts(), order_.interior);
    to->setFromTriplets(entries->begin(), entries->end());
  }
}

/// A row that is rounding of what it was subtracted from has no pivot, whatever its scaling.
void GeneralLu::make_schur() {
  Vector x;
  const SparseMatrix sizes = pulls_.cwiseAbs();
  DenseMatrix terms = schur_.cwiseAbs();
  for (Eigen::Index j = 0; j < schur_.cols(); ++j) {
    x = pulled_.row(j).transpose();
    solve_interior(x, false);
    schur_.col(j) -= pulls_ * x;
    terms.col(j) += sizes * x.cwiseAbs();
  }
  for (Eigen::Index i = 0; i < schur_.rows(); ++i) {
    const double left = schur_.row(i).cwiseAbs().maxCoeff() / terms.row(i).maxCoeff();
    if (left <= smallest_condition)
      throw NotFactorable(contact_[static_cast<std::size_t>(i)], left,
                          "the matrix is singular: the elimination breaks down");
  }
  if (schur_.cols() > 0) check_schur();
}

/// With a scaling of its own: that of K leaves the stiffness of a displacement as far below 1 as a
/// pressure in small units has large couplings, and its inverse as far above.
void GeneralLu::check_schur() {
  auto [rows, columns] = dense_scaling(schur_);
  schur_factor_ = DenseLu(rows.asDiagonal() * schur_ * columns.asDiagonal());
  schur_rows_ = std::move(rows), schur_columns_ = std::move(columns);
  const double condition = schur_factor_.inverse_condition();
  if (condition > smallest_condition) return;
  Eigen::Index at = 0;
  schur_factor_.pivots().minCoeff(&at);
  throw NotFactorable(contact_[static_cast<std::size_t>(at)], condition,
                      "the matrix is singular: the elimination breaks down");
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
  position_.resize(order_.unknown.size());
  for (std::size_t p = 0; p < position_.size(); ++p)
    position_[static_cast<std::size_t>(order_.unknown[p])] = static_cast<int>(p);
}

void GeneralLu::analyse(const SparseMatrix& k) {
  place(k.rows());
  auto matrix = std::make_unique<ScaledMatrix>(k, order_, position_);
  find_order(*matrix);
  matrix_ = std::move(matrix);
}

void GeneralLu::factor(const SparseMatrix& k) {
  const OneBlasThread one_thread;
  place(k.rows());
  auto matrix = std::make_unique<ScaledMatrix>(k, order_, position_);
  find_order(*matrix);
  matrix_ = std::move(matrix);
  const double start = cpu_seconds();
  take_couplings(k);
  if (order_.interior > 0) {
    factor_numbers();
    check_pivots();
  }
  make_schur();
  statistics_.seconds_factor += cpu_seconds() - start;
}

void GeneralLu::solve_interior(Vector& x, bool transposed) {
  if (x.size() == 0) return;
  const Vector& in = transposed ? matrix_->column_scale : matrix_->row_scale;
  const Vector& out = transposed ? matrix_->row_scale : matrix_->column_scale;
  const Vector scaled = in.cwiseProduct(x);
  umfpack_dl_solve(transposed ? UMFPACK_A : UMFPACK_At, matrix_->start.data(),
                   matrix_->column.data(), matrix_->value.data(), x.data(), scaled.data(),
                   numeric_.get(), control_.data(), nullptr);
  x = out.cwiseProduct(x);
  statistics_.triangular_solves += 2;
  statistics_.bytes_read += statistics_.bytes;
}

Vector GeneralLu::solve_contact(const Vector& r, bool transposed) const {
  const Vector& in = transposed ? schur_columns_ : schur_rows_;
  const Vector& out = transposed ? schur_rows_ : schur_columns_;
  return out.cwiseProduct(schur_factor_.solve(Vector(in.cwiseProduct(r)), transposed));
}

/// y_I = K_II^-1 b_I, y_c = r; with all columns y_c = S^-1 r. Transposed: of K^T.
void GeneralLu::forward(RightHandSides y, Columns columns) {
  const bool transposed = columns == Columns::transposed;
  Vector x(order_.interior), r(order_.contacts());
  for (int k = 0; k < y.count; ++k) {
    const auto entry = [&](int p) -> double& { return y.values[p * y.stride + k]; };
    for (int p = 0; p < order_.interior; ++p) x[p] = entry(p);
    for (int c = 0; c < order_.contacts(); ++c) r[c] = entry(order_.interior + c);
    solve_interior(x, transposed);
    r -= (transposed ? pulled_ : pulls_) * x;
    if (columns != Columns::interior && r.size() > 0) r = solve_contact(r, transposed);
    for (int p = 0; p < order_.interior; ++p) entry(p) = x[p];
    for (int c = 0; c < order_.contacts(); ++c) entry(order_.interior + c) = r[c];
  }
}

void GeneralLu::back(RightHandSides y, Columns columns) {
  if (contact_.empty()) return;
  const bool transposed = columns == Columns::transposed;
  Vector c(order_.contacts()), x;
  for (int k = 0; k < y.count; ++k) {
    const auto entry = [&](int p) -> double& { return y.values[p * y.stride + k]; };
    for (int i = 0; i < order_.contacts(); ++i) c[i] = entry(order_.interior + i);
    x = (transposed ? pulls_ : pulled_).transpose() * c;
    solve_interior(x, transposed);
    for (int p = 0; p < order_.interior; ++p) entry(p) -= x[p];
  }
}

} // namespace

std::unique_ptr<Factorisation> general_factor(const SparseMatrix& k, std::span<const int> contact) {
  auto out = std::make_unique<GeneralLu>(contact);
  out->analyse(k);
  return out;
}

} // namespace hvi::solver
