// See indefinite.hpp. With D K symmetric and s its scaling, M = s D K s is factored but for the
// contact unknowns, of which MUMPS gives the Schur complement. A solve with the interior is
//   A_II^-1 b = s M_II^-1 s D b,   and   K_Ic c = D^-1 (D K_cI)^T c   needs the contact rows only.
#include "solver/linear/indefinite.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/open_module.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/linear/blas_threads.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/general_lu.hpp"
#include "solver/linear/mumps/bridge.h"
#include "solver/linear/ordering.hpp"
#include "solver/linear/scaling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace hvi::solver {
namespace {

constexpr ModuleFile mumps_module{"libhvi_mumps.so", "HVI_MUMPS_MODULE",
                                  "factors indefinite matrices with MUMPS",
                                  "it needs the package libmumps-seq-5.5"};

/// D K may differ from its transpose by this part, block by block: rounding of its assembly.
constexpr double as_symmetric = 1e-12;
/// A test solve leaves at most this, row by row.
constexpr double accurate = 1e-9;

/// The functions of the module; nothing where it is not there.
struct MumpsBridge {
  HviMumpsOpen open = module_function<HviMumpsOpen>(mumps_module, "hvi_mumps_open");
  HviMumpsFactor factor = module_function<HviMumpsFactor>(mumps_module, "hvi_mumps_factor");
  HviMumpsSolve solve = module_function<HviMumpsSolve>(mumps_module, "hvi_mumps_solve");
  HviMumpsClose close = module_function<HviMumpsClose>(mumps_module, "hvi_mumps_close");
};

std::optional<MumpsBridge> open_bridge() {
  try {
    return MumpsBridge();
  } catch (const Failure&) {
    return std::nullopt;
  }
}

/// The lower triangle of D K without its zeros, by entries.
struct LowerTriangle {
  std::vector<int> row, column;
  std::vector<double> value;

  LowerTriangle(const SparseMatrix& k, const Vector& d) {
    for (int i = 0; i < k.rows(); ++i)
      for (SparseMatrix::InnerIterator it(k, i); it && it.col() <= i; ++it)
        if (it.value() != 0.0) {
          row.push_back(i);
          column.push_back(static_cast<int>(it.col()));
          value.push_back(d[i] * it.value());
        }
  }
  bool same_pattern(const LowerTriangle& other) const {
    return row == other.row && column == other.column;
  }
  /// Factors s of rows and columns (scaling.hpp); the values become s_i v s_j.
  Vector scale(Eigen::Index n) {
    const auto for_each = [this](const auto& f) {
      for (std::size_t e = 0; e < value.size(); ++e) {
        f(row[e], column[e], value[e]);
        if (row[e] != column[e]) f(column[e], row[e], value[e]);
      }
    };
    Vector s = scaling_of(n, for_each).rows;
    for (std::size_t e = 0; e < value.size(); ++e) value[e] *= s[row[e]] * s[column[e]];
    return s;
  }
};

class Ldl final : public Factorisation {
public:
  Ldl(const MumpsBridge& bridge, std::span<const int> contact,
      std::span<const std::uint8_t> of_unknown)
      : bridge_(bridge), contact_(contact.begin(), contact.end()),
        of_unknown_(of_unknown.begin(), of_unknown.end()) {}
  ~Ldl() override { bridge_.close(solver_); }
  Ldl(const Ldl&) = delete;
  Ldl& operator=(const Ldl&) = delete;

  std::unique_ptr<Factorisation> another() const override {
    return std::make_unique<Ldl>(bridge_, contact_, of_unknown_);
  }
  /// Throws NotFactorable where K is not symmetric but for factors of its rows, has no factor, or
  /// an inaccurate one.
  void factor(const SparseMatrix& k) override;
  bool analyse(const SparseMatrix& k); ///< false: it is not
  void forward(RightHandSides y, Columns columns) override;
  void back(RightHandSides y, Columns columns) override;
  const DenseMatrix& schur() const override { return schur_; }
  const EliminationOrder& order() const override { return order_; }
  const FactorStatistics& statistics() const override { return statistics_; }

private:
  void place(Eigen::Index size);
  bool find_order(const SparseMatrix& k, const LowerTriangle& lower);
  void take_schur();
  bool is_accurate(const SparseMatrix& k);
  void solve_interior(Vector& x); ///< x_I = K_II^-1 x_I, x_c = 0
  Vector pulled_by(const Vector& c) const;

  MumpsBridge bridge_;
  std::vector<int> contact_;
  std::vector<std::uint8_t> of_unknown_;
  void* solver_ = nullptr;
  std::optional<LowerTriangle> lower_; ///< as analysed
  Vector rows_, scale_;                ///< D, s
  SparseMatrix of_contact_;            ///< rows of K, without the contact columns
  EliminationOrder order_;
  DenseMatrix schur_;
  DenseLu schur_factor_;
  FactorStatistics statistics_;
};

void Ldl::place(Eigen::Index size) {
  if (order_.size() == size) return;
  std::vector<char> is_contact(static_cast<std::size_t>(size), 0);
  for (const int i : contact_) is_contact[static_cast<std::size_t>(i)] = 1;
  order_.unknown.clear();
  for (int i = 0; i < size; ++i)
    if (is_contact[static_cast<std::size_t>(i)] == 0) order_.unknown.push_back(i);
  order_.interior = static_cast<int>(order_.unknown.size());
  order_.unknown.insert(order_.unknown.end(), contact_.begin(), contact_.end());
}

/// The order is ours: MUMPS's own by SCOTCH differs from run to run and ends in the order of the
/// numbers where there is no memory.
bool Ldl::find_order(const SparseMatrix& k, const LowerTriangle& lower) {
  if (solver_ != nullptr && lower_ && lower_->same_pattern(lower)) return true;
  const double start = cpu_seconds();
  bridge_.close(std::exchange(solver_, nullptr));
  CholmodSession session;
  const ContactLastOrder found = order_contact_last(k, contact_, session);
  std::vector<int> position(found.permutation.size());
  for (std::size_t p = 0; p < position.size(); ++p)
    position[static_cast<std::size_t>(found.permutation[p])] = static_cast<int>(p);
  const HviMumpsPattern pattern{order_.size(),       lower.row.size(), lower.row.data(),
                                lower.column.data(), position.data(),  order_.contacts(),
                                contact_.data()};
  statistics_.ordering = found.name;
  HviMumpsCounts expected{};
  const int status = bridge_.open(&pattern, &solver_, &expected);
  // general_factor would need more.
  if (status == hvi_mumps_no_memory)
    throw OutOfMemory("no memory to analyse a matrix of {} unknowns", order_.size());
  lower_ = lower;
  statistics_.bytes = expected.bytes;
  ++statistics_.analyses;
  statistics_.seconds_analyse += cpu_seconds() - start;
  return status == hvi_mumps_ok;
}

bool Ldl::analyse(const SparseMatrix& k) {
  rows_ = symmetrising_rows(k, of_unknown_);
  if (rows_.size() != k.rows()) return false;
  place(k.rows());
  LowerTriangle lower(k, rows_);
  return find_order(k, lower);
}

void Ldl::factor(const SparseMatrix& k) {
  const OneBlasThread one_thread;
  const auto fail = [](const char* why) { throw NotFactorable(-1, 0.0, why); };
  rows_ = symmetrising_rows(k, of_unknown_);
  if (rows_.size() != k.rows()) fail("the matrix is not symmetric");
  place(k.rows());
  LowerTriangle lower(k, rows_);
  scale_ = lower.scale(k.rows());
  if (!find_order(k, lower)) fail("the matrix cannot be analysed");
  const double start = cpu_seconds();
  const auto contacts = static_cast<Eigen::Index>(contact_.size());
  schur_.resize(contacts, contacts);
  HviMumpsCounts counts{};
  const int status =
      bridge_.factor(solver_, lower.value.data(), smallest_pivot, schur_.data(), &counts);
  if (status == hvi_mumps_no_memory)
    throw OutOfMemory("no memory to factor a matrix of {} unknowns", k.rows());
  if (status != hvi_mumps_ok) fail("the matrix is singular: the elimination breaks down");
  ++statistics_.factorisations;
  statistics_.nonzeros = counts.nonzeros, statistics_.flops = counts.flops;
  statistics_.bytes = std::max(counts.bytes, sizeof(double) * counts.nonzeros);
  std::vector<char> is_contact(static_cast<std::size_t>(k.rows()), 0);
  for (const int i : contact_) is_contact[static_cast<std::size_t>(i)] = 1;
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < contacts; ++c)
    for (SparseMatrix::InnerIterator it(k, contact_[static_cast<std::size_t>(c)]); it; ++it)
      if (is_contact[static_cast<std::size_t>(it.col())] == 0)
        entries.emplace_back(c, static_cast<int>(it.col()), it.value());
  of_contact_.resize(contacts, k.rows());
  of_contact_.setFromTriplets(entries.begin(), entries.end());
  take_schur();
  if (!is_accurate(k)) fail("the factor is not accurate");
  statistics_.seconds_factor += cpu_seconds() - start;
}

/// S = D_c^-1 s_c^-1 S_M s_c^-1. Throws NotFactorable where S is singular.
void Ldl::take_schur() {
  if (contact_.empty()) return;
  schur_factor_ = DenseLu(schur_);
  const Vector pivots = schur_factor_.pivots();
  // Entries of M are near 1: what is left of them may be rounding as a whole.
  const double left = schur_factor_.inverse_condition(),
               least = std::min(pivots.minCoeff() / std::max(1.0, pivots.maxCoeff()), left);
  const bool numbers = pivots.allFinite() && std::isfinite(left); // bounds pass over NaN
  if (!(numbers && least > smallest_pivot))
    throw NotFactorable(-1, least, "the matrix is singular");
  const Vector s = scale_(contact_).cwiseInverse(), d = rows_(contact_).cwiseInverse();
  schur_ = d.cwiseProduct(s).asDiagonal() * schur_ * s.asDiagonal();
}

void Ldl::solve_interior(Vector& x) {
  x = scale_.cwiseProduct(rows_).cwiseProduct(x);
  const int status = bridge_.solve(solver_, x.data());
  if (status == hvi_mumps_no_memory) throw OutOfMemory("no memory for a solve with the factor");
  if (status != hvi_mumps_ok) x.setConstant(std::numeric_limits<double>::quiet_NaN());
  x = scale_.cwiseProduct(x);
  statistics_.triangular_solves += 2;
  statistics_.bytes_read += statistics_.bytes;
}

/// K_Ic c
Vector Ldl::pulled_by(const Vector& c) const {
  const Vector weighted = rows_(contact_).cwiseProduct(c);
  return (of_contact_.transpose() * weighted).cwiseQuotient(rows_);
}

/// y_I = K_II^-1 b_I, y_c = r; with all columns y_c = S^-1 r. Transposed: K^-T = D K^-1 D^-1.
void Ldl::forward(RightHandSides y, Columns columns) {
  Vector x(order_.size());
  for (int k = 0; k < y.count; ++k) {
    const auto entry = [&](int p) -> double& { return y.values[p * y.stride + k]; };
    for (int p = 0; p < order_.size(); ++p) x[order_.unknown[p]] = entry(p);
    if (columns == Columns::transposed) x = x.cwiseQuotient(rows_);
    Vector r = x(contact_);
    solve_interior(x);
    r -= of_contact_ * x;
    if (columns != Columns::interior && r.size() > 0) {
      const Vector s = scale_(contact_), d = rows_(contact_);
      r = s.cwiseProduct(schur_factor_.solve(Vector(s.cwiseProduct(d).cwiseProduct(r))));
    }
    for (int p = 0; p < order_.interior; ++p) entry(p) = x[order_.unknown[p]];
    for (int c = 0; c < r.size(); ++c) entry(order_.interior + c) = r[c];
  }
}

void Ldl::back(RightHandSides y, Columns columns) {
  Vector c(order_.contacts()), x;
  for (int k = 0; k < y.count; ++k) {
    const auto entry = [&](int p) -> double& { return y.values[p * y.stride + k]; };
    for (int i = 0; i < c.size(); ++i) c[i] = entry(order_.interior + i);
    if (c.size() > 0) {
      x = pulled_by(c);
      solve_interior(x);
      for (int p = 0; p < order_.interior; ++p) entry(p) -= x[order_.unknown[p]];
    }
    if (columns != Columns::transposed) continue;
    for (int p = 0; p < order_.size(); ++p) entry(p) *= rows_[order_.unknown[p]];
  }
}

/// A solve with a known answer, of the size of the scaled unknowns.
bool Ldl::is_accurate(const SparseMatrix& k) {
  Vector wanted(k.rows()), found;
  for (int i = 0; i < k.rows(); ++i) wanted[i] = scale_[i] * (0.5 + 0.5 * ((7 * i) % 11) / 11.0);
  const Vector b = k * wanted;
  solve(*this, b, found);
  for (int i = 0; i < k.rows(); ++i) {
    double left = b[i], size = std::abs(b[i]);
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
      left -= it.value() * found[it.col()];
      size += std::abs(it.value() * found[it.col()]);
    }
    if (!(std::abs(left) <= accurate * size)) return false;
  }
  return true;
}

/// Ldl while it can, then general_factor.
class Coupled final : public Factorisation {
public:
  Coupled(std::span<const int> contact, std::span<const std::uint8_t> of_unknown)
      : contact_(contact.begin(), contact.end()),
        of_unknown_(of_unknown.begin(), of_unknown.end()) {}

  void analyse(const SparseMatrix& k) {
    if (const auto bridge = open_bridge()) {
      auto ldl = std::make_unique<Ldl>(*bridge, contact_, of_unknown_);
      if (ldl->analyse(k)) {
        symmetric_ = true;
        factor_ = std::move(ldl);
        return;
      }
    }
    factor_ = general_factor(k, contact_);
  }
  std::unique_ptr<Factorisation> another() const override {
    auto out = std::make_unique<Coupled>(contact_, of_unknown_);
    out->symmetric_ = symmetric_;
    out->factor_ = factor_->another();
    return out;
  }
  void factor(const SparseMatrix& k) override {
    if (symmetric_) {
      try {
        return factor_->factor(k);
      } catch (const NotFactorable&) {
        symmetric_ = false;
        factor_ = general_factor(k, contact_);
      }
    }
    factor_->factor(k);
  }
  void forward(RightHandSides y, Columns columns) override { factor_->forward(y, columns); }
  void back(RightHandSides y, Columns columns) override { factor_->back(y, columns); }
  const DenseMatrix& schur() const override { return factor_->schur(); }
  const EliminationOrder& order() const override { return factor_->order(); }
  const FactorStatistics& statistics() const override { return factor_->statistics(); }

private:
  std::vector<int> contact_;
  std::vector<std::uint8_t> of_unknown_;
  bool symmetric_ = false;
  std::unique_ptr<Factorisation> factor_;
};

} // namespace

Vector symmetrising_rows(const SparseMatrix& k, std::span<const std::uint8_t> of_unknown) {
  const auto block_of = [&](Eigen::Index i) -> Eigen::Index {
    return of_unknown.empty() ? 0 : of_unknown[static_cast<std::size_t>(i)];
  };
  const Eigen::Index n = of_unknown.empty() ? 1 : *std::ranges::max_element(of_unknown) + 1;
  const auto sums = [&](const SparseMatrix& of) {
    DenseMatrix out = DenseMatrix::Zero(n, n);
    for (int i = 0; i < of.rows(); ++i)
      for (SparseMatrix::InnerIterator it(of, i); it; ++it)
        out(block_of(i), block_of(it.col())) += it.value();
    return out;
  };
  // K_bc = rho K_cb^T, from the largest entries of each: sums of many would round.
  const SparseMatrix transposed = k.transpose();
  DenseMatrix largest = DenseMatrix::Zero(n, n), rho = largest;
  for (int i = 0; i < k.rows(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it) {
      const Eigen::Index b = block_of(i), c = block_of(it.col());
      if (!(std::abs(it.value()) > largest(b, c))) continue;
      const double other = transposed.coeff(i, it.col());
      largest(b, c) = std::abs(it.value());
      rho(b, c) = other != 0.0 ? it.value() / other : 0.0;
    }
  Vector of_block = Vector::Zero(n);
  for (Eigen::Index first = 0; first < n; ++first) {
    if (of_block[first] == 0.0) of_block[first] = 1.0;
    for (Eigen::Index pass = 0; pass < n; ++pass)
      for (Eigen::Index b = 0; b < n; ++b)
        for (Eigen::Index c = 0; c < n; ++c)
          if (of_block[b] != 0.0 && of_block[c] == 0.0 && rho(b, c) != 0.0)
            of_block[c] = of_block[b] * rho(b, c);
  }
  Vector d(k.rows());
  for (Eigen::Index i = 0; i < d.size(); ++i) d[i] = of_block[block_of(i)];
  const SparseMatrix scaled = d.asDiagonal() * k;
  const SparseMatrix skew = scaled - SparseMatrix(scaled.transpose());
  const DenseMatrix off = sums(skew.cwiseProduct(skew)), size = sums(scaled.cwiseProduct(scaled));
  const bool symmetric =
      (off.array() <= as_symmetric * as_symmetric * size.array()).all(); // false for NaN
  return symmetric ? d : Vector();
}

std::unique_ptr<Factorisation> coupled_factor(const SparseMatrix& k, std::span<const int> contact,
                                              std::span<const std::uint8_t> of_unknown) {
  auto out = std::make_unique<Coupled>(contact, of_unknown);
  out->analyse(k);
  return out;
}

} // namespace hvi::solver
