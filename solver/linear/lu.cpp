// The unsymmetric factorisation. UMFPACK gives no access to a trailing block, so it factors the
// interior alone: S = K_cc - K_cI K_II^-1 K_Ic takes n_c solves, and a step takes two.
#include "solver/linear/lu.hpp"

#include "solver/linear/cholmod_session.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <umfpack.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>

namespace hvi::solver {
namespace {

/// UMFPACK scales the rows to sum 1; a pivot below this is rounding.
constexpr double smallest_pivot = 1e-13;

/// UMFPACK's two opaque objects, freed by it.
struct FreeSymbolic {
  void operator()(void* object) const { umfpack_dl_free_symbolic(&object); }
};
struct FreeNumeric {
  void operator()(void* object) const { umfpack_dl_free_numeric(&object); }
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The interior block by rows, with the 64-bit indices of UMFPACK. UMFPACK wants columns: it sees
/// the transpose, and every solve is one with the transpose of that.
struct InteriorMatrix {
  std::vector<Long> start, column;
  std::vector<double> value;
  Long size() const { return static_cast<Long>(start.size()) - 1; }
};

class Lu final : public Factorisation {
public:
  Lu(const SparseMatrix& k, std::span<const int> contact);
  void factor(const SparseMatrix& k) override;
  void reduce(const Vector& b, Vector& r) override;
  void back(const Vector& c, Vector& x) override;
  void solve(const Vector& b, Vector& x) override;
  const DenseMatrix& schur() const override;
  const DenseMatrix& schur_factor() const override { return no_factor_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void split(const SparseMatrix& k);
  void check_pivots(double nonzero_pivots) const;
  [[noreturn]] void fail(int unknown, double pivot) const;
  /// x = K_II^-1 b for interior vectors; no allocation.
  void solve_interior(const Vector& b, Vector& x) const;

  std::vector<int> contact_, interior_, local_; ///< local: number within interior or contact
  std::vector<char> is_contact_;
  std::vector<int> pattern_; ///< column indices of K, to recognise a foreign matrix
  InteriorMatrix k_ii_;
  SparseMatrix k_ic_, k_ci_;
  DenseMatrix k_cc_, no_factor_;
  std::array<double, UMFPACK_CONTROL> control_{};
  std::unique_ptr<void, FreeSymbolic> symbolic_;
  std::unique_ptr<void, FreeNumeric> numeric_;
  Vector b_interior_, y_, shifted_, reduced_;
  mutable std::vector<Long> integer_work_;
  mutable std::vector<double> work_;
  mutable DenseMatrix schur_;
  mutable bool schur_ready_ = false;
  std::optional<Eigen::PartialPivLU<DenseMatrix>> schur_lu_;
  bool factored_ = false;
  FactorStatistics statistics_;
};

Lu::Lu(const SparseMatrix& k, std::span<const int> contact)
    : contact_(contact.begin(), contact.end()), local_(static_cast<std::size_t>(k.rows())),
      is_contact_(static_cast<std::size_t>(k.rows()), 0),
      pattern_(k.innerIndexPtr(), k.innerIndexPtr() + k.nonZeros()) {
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < contact_.size(); ++i) {
    is_contact_[contact_[i]] = 1;
    local_[contact_[i]] = static_cast<int>(i);
  }
  for (int unknown = 0; unknown < k.rows(); ++unknown) {
    if (is_contact_[unknown] != 0) continue;
    local_[unknown] = static_cast<int>(interior_.size());
    interior_.push_back(unknown);
  }
  split(k);
  umfpack_dl_defaults(control_.data());
  control_[UMFPACK_ORDERING] = UMFPACK_ORDERING_CHOLMOD;
  control_[UMFPACK_IRSTEP] = 0; // the certificate of a step sees the residual anyway
  if (!interior_.empty()) {
    void* symbolic = nullptr;
    const auto status =
        umfpack_dl_symbolic(k_ii_.size(), k_ii_.size(), k_ii_.start.data(), k_ii_.column.data(),
                            nullptr, &symbolic, control_.data(), nullptr);
    symbolic_.reset(symbolic);
    if (status < 0)
      throw Failure(FailureKind::limit, {},
                    fmt::format("no memory to analyse a matrix of {} unknowns", k.rows()));
  }
  integer_work_.resize(interior_.size());
  work_.resize(5 * interior_.size());
  for (Vector* v : {&b_interior_, &y_, &shifted_}) v->setZero(k_ii_.size());
  statistics_.analyses = 1;
  statistics_.ordering = "UMFPACK";
  statistics_.seconds_analyse = seconds_since(start);
}

/// Fills the four blocks from K.
void Lu::split(const SparseMatrix& k) {
  const auto contacts = static_cast<Eigen::Index>(contact_.size());
  std::vector<Eigen::Triplet<double>> interior_contact, contact_interior;
  k_ii_ = {{0}, {}, {}};
  k_cc_.setZero(contacts, contacts);
  for (const int row : interior_) {
    for (SparseMatrix::InnerIterator entry(k, row); entry; ++entry) {
      const int column = local_[entry.col()];
      if (is_contact_[entry.col()] != 0) {
        interior_contact.emplace_back(local_[row], column, entry.value());
        continue;
      }
      k_ii_.column.push_back(column);
      k_ii_.value.push_back(entry.value());
    }
    k_ii_.start.push_back(static_cast<Long>(k_ii_.column.size()));
  }
  for (const int row : contact_)
    for (SparseMatrix::InnerIterator entry(k, row); entry; ++entry) {
      const int column = local_[entry.col()];
      if (is_contact_[entry.col()] != 0)
        k_cc_(local_[row], column) = entry.value();
      else
        contact_interior.emplace_back(local_[row], column, entry.value());
    }
  k_ic_.resize(k_ii_.size(), contacts);
  k_ci_.resize(contacts, k_ii_.size());
  k_ic_.setFromTriplets(interior_contact.begin(), interior_contact.end());
  k_ci_.setFromTriplets(contact_interior.begin(), contact_interior.end());
}

void Lu::factor(const SparseMatrix& k) {
  const auto start = std::chrono::steady_clock::now();
  const OneBlasThread one_thread;
  factored_ = schur_ready_ = false;
  schur_lu_.reset();
  if (!k.isCompressed() || k.rows() != static_cast<Eigen::Index>(local_.size()) ||
      !std::equal(pattern_.begin(), pattern_.end(), k.innerIndexPtr(),
                  k.innerIndexPtr() + k.nonZeros()))
    throw Failure(FailureKind::bad_value, {},
                  "the matrix to factor does not have the pattern that was analysed");
  split(k);
  if (!interior_.empty()) {
    std::array<double, UMFPACK_INFO> info{};
    void* numeric = nullptr;
    const auto status =
        umfpack_dl_numeric(k_ii_.start.data(), k_ii_.column.data(), k_ii_.value.data(),
                           symbolic_.get(), &numeric, control_.data(), info.data());
    numeric_.reset(numeric);
    if (status < 0)
      throw Failure(FailureKind::limit, {},
                    fmt::format("no memory to factor a matrix of {} unknowns", k.rows()));
    check_pivots(info[UMFPACK_UDIAG_NZ]);
    statistics_.nonzeros = info[UMFPACK_LNZ] + info[UMFPACK_UNZ];
    statistics_.flops = info[UMFPACK_FLOPS];
    statistics_.bytes = info[UMFPACK_NUMERIC_SIZE] * info[UMFPACK_SIZE_OF_UNIT];
    statistics_.reciprocal_condition = info[UMFPACK_RCOND];
  }
  ++statistics_.factorisations;
  statistics_.seconds_factor = seconds_since(start);
  factored_ = true;
}

/// Names the unknown of the worst pivot when the interior block is singular to rounding.
void Lu::check_pivots(double nonzero_pivots) const {
  const auto n = static_cast<std::size_t>(k_ii_.size());
  std::vector<double> pivot(n);
  std::vector<Long> column_order(n);
  umfpack_dl_get_numeric(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
                         column_order.data(), pivot.data(), nullptr, nullptr, numeric_.get());
  const auto least = std::ranges::min_element(
      pivot, [](double a, double b) { return !(std::abs(a) >= std::abs(b)); });
  const double size = std::abs(*least);
  if (nonzero_pivots == static_cast<double>(n) && std::isfinite(size) && size >= smallest_pivot)
    return;
  fail(interior_[column_order[least - pivot.begin()]], size);
}

void Lu::fail(int unknown, double pivot) const {
  throw NotFactorable(unknown, pivot, "the matrix is singular: the elimination breaks down");
}

void Lu::solve_interior(const Vector& b, Vector& x) const {
  if (interior_.empty()) return;
  umfpack_dl_wsolve(UMFPACK_At, k_ii_.start.data(), k_ii_.column.data(), k_ii_.value.data(),
                    x.data(), b.data(), numeric_.get(), control_.data(), nullptr,
                    integer_work_.data(), work_.data());
}

const DenseMatrix& Lu::schur() const {
  if (schur_ready_) return schur_;
  const OneBlasThread one_thread;
  const Eigen::SparseMatrix<double> columns = k_ic_;
  Vector b = Vector::Zero(k_ii_.size()), x(k_ii_.size());
  schur_ = k_cc_;
  for (Eigen::Index j = 0; j < schur_.cols(); ++j) {
    b = columns.col(j);
    solve_interior(b, x);
    schur_.col(j).noalias() -= k_ci_ * x;
  }
  schur_ready_ = true;
  return schur_;
}

void Lu::reduce(const Vector& b, Vector& r) {
  if (!factored_) throw std::logic_error("reduce before a successful factorisation");
  for (std::size_t i = 0; i < interior_.size(); ++i) b_interior_[i] = b[interior_[i]];
  solve_interior(b_interior_, y_);
  r.resize(static_cast<Eigen::Index>(contact_.size()));
  for (std::size_t i = 0; i < contact_.size(); ++i) r[i] = b[contact_[i]];
  r.noalias() -= k_ci_ * y_;
  ++statistics_.sweeps;
}

void Lu::back(const Vector& c, Vector& x) {
  if (!factored_) throw std::logic_error("back before a successful factorisation");
  shifted_ = b_interior_;
  shifted_.noalias() -= k_ic_ * c;
  solve_interior(shifted_, y_);
  x.resize(static_cast<Eigen::Index>(local_.size()));
  for (std::size_t i = 0; i < interior_.size(); ++i) x[interior_[i]] = y_[i];
  for (std::size_t i = 0; i < contact_.size(); ++i) x[contact_[i]] = c[i];
  ++statistics_.sweeps;
}

void Lu::solve(const Vector& b, Vector& x) {
  reduce(b, reduced_);
  if (!contact_.empty()) {
    if (!schur_lu_) schur_lu_.emplace(schur());
    reduced_ = schur_lu_->solve(reduced_);
  }
  back(reduced_, x);
}

} // namespace

std::unique_ptr<Factorisation> analyse_lu(const SparseMatrix& k, std::span<const int> contact) {
  return std::make_unique<Lu>(k, contact);
}

} // namespace hvi::solver
