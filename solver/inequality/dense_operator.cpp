// The dense operator of the reduced inequality, by LAPACK (inequality.hpp).
#include "solver/inequality/inequality.hpp"
#include "solver/linear/factorisation.hpp"
#include "solver/linear/instruction_set.hpp"
#include "solver/linear/lapack.hpp"
#include "solver/linear/rough_inverse.hpp"

#include <cblas.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace hvi::solver {

namespace {

/// sum += |A| x for a symmetric A by columns, of which the lower triangle is read, four columns at
/// a time.
HVI_INLINE void add_magnitudes_here(const double* a, int n, const double* x, double* sum) {
  int j = 0;
  for (; j + 4 <= n; j += 4) {
    const double* column[4];
    for (int k = 0; k < 4; ++k) column[k] = a + static_cast<std::ptrdiff_t>(j + k) * n;
    for (int k = 0; k < 4; ++k)
      for (int i = j + k; i < j + 4; ++i) {
        sum[i] += std::abs(column[k][i]) * x[j + k];
        if (i > j + k) sum[j + k] += std::abs(column[k][i]) * x[i];
      }
    Pack<8> mirrored[4] = {};
    int i = j + 4;
    for (; i + 8 <= n; i += 8) {
      Pack<8> total, entry, other;
      load<8>(sum + i, total);
      load<8>(x + i, other);
#pragma GCC unroll 4
      for (int k = 0; k < 4; ++k) {
        load<8>(column[k] + i, entry);
        entry = entry < 0.0 ? -entry : entry;
        total += entry * x[j + k];
        mirrored[k] += entry * other;
      }
      std::memcpy(sum + i, &total, sizeof total);
    }
    for (int k = 0; k < 4; ++k) {
      for (int lane = 0; lane < 8; ++lane) sum[j + k] += mirrored[k][lane];
      for (int rest = i; rest < n; ++rest) {
        sum[rest] += std::abs(column[k][rest]) * x[j + k];
        sum[j + k] += std::abs(column[k][rest]) * x[rest];
      }
    }
  }
  for (; j < n; ++j)
    for (int i = j; i < n; ++i) {
      const double entry = std::abs(a[static_cast<std::ptrdiff_t>(j) * n + i]);
      sum[i] += entry * x[j];
      if (i > j) sum[j] += entry * x[i];
    }
}
HVI_AVX2 void add_magnitudes_avx2(const double* a, int n, const double* x, double* sum) {
  add_magnitudes_here(a, n, x, sum);
}
HVI_AVX512 void add_magnitudes_avx512(const double* a, int n, const double* x, double* sum) {
  add_magnitudes_here(a, n, x, sum);
}
void add_magnitudes(const double* a, int n, const double* x, double* sum) {
  switch (instruction_set()) {
  case InstructionSet::avx512:
    return add_magnitudes_avx512(a, n, x, sum);
  case InstructionSet::avx2:
    return add_magnitudes_avx2(a, n, x, sum);
  case InstructionSet::baseline:
    return add_magnitudes_here(a, n, x, sum);
  }
}

/// S, of a factor or alone.
struct SharedSchur {
  std::shared_ptr<const Factorisation> factor;
  std::shared_ptr<const DenseMatrix> alone;
  const DenseMatrix& matrix() const { return factor ? factor->schur() : *alone; }
};

class DenseOperator final : public ReducedOperator {
public:
  DenseOperator(SharedSchur s, bool symmetric)
      : shared_(std::move(s)), s_(shared_.matrix()), symmetric_(symmetric),
        unit_(s_.rows() > 0 ? s_.diagonal().cwiseAbs().maxCoeff() : 1.0), pivots_(s_.rows()) {
    if (!(unit_ > 0.0)) unit_ = 1.0;
  }

  int size() const override { return static_cast<int>(s_.rows()); }
  bool symmetric() const override { return symmetric_; }
  Vector diagonal() const override { return s_.diagonal(); }
  void column(int j, double* out) const override {
    std::copy_n(s_.data() + static_cast<std::ptrdiff_t>(j) * size(), size(), out);
  }
  std::unique_ptr<ReducedOperator> unsymmetric() const override {
    return std::make_unique<DenseOperator>(shared_, false);
  }
  int determinant_sign() const override {
    if (symmetric_ || !exact_) return 0;
    int sign = 1;
    for (int i = 0; i < size(); ++i) {
      if (pivots_[i] != i + 1) sign = -sign;
      if (factor_(i, i) < 0.0) sign = -sign;
    }
    return sign;
  }
  int patience() const override { return 2 + size() / 100; }
  double bytes() const override {
    return static_cast<double>(factor_.size()) * sizeof(double) +
           static_cast<double>(rough_factor_.capacity() + rough_inverse_.capacity()) *
               sizeof(float);
  }
  void apply(const Vector& c, Vector& out) const override {
    if (!symmetric_ || size() == 0) {
      out.noalias() = s_ * c;
      return;
    }
    out.resize(size());
    const int n = size(); // half of the matrix is read: memory is what it costs
    cblas_dsymv(CblasColMajor, CblasLower, n, 1.0, s_.data(), n, c.data(), 1, 0.0, out.data(), 1);
  }
  void apply_magnitude(const Vector& c, Vector& out) const override {
    magnitudes_ = c.cwiseAbs();
    if (!symmetric_) {
      out.noalias() = s_.cwiseAbs() * magnitudes_;
      return;
    }
    out.setZero(size());
    add_magnitudes(s_.data(), size(), magnitudes_.data(), out.data());
  }

  bool factor(const SparseMatrix& h, std::span<const int> held) override {
    h_ = h;
    exact_ = rough_ = inverted_ = false;
    held_.assign(held.begin(), held.end());
    free_.clear();
    for (int i = 0, next = 0; i < size(); ++i)
      if (next < static_cast<int>(held.size()) && held[next] == i)
        ++next;
      else
        free_.push_back(i);
    if (size() == 0) return true;
    return (symmetric_ && size() >= rounded_from && factor_rounded()) || factor_exactly();
  }

  void solve(const Vector& b, Vector& x) const override {
    if (size() == 0) {
      x = b;
      return;
    }
    if (!exact_ && refine(b, x)) return;
    if (!exact_ && !factor_exactly()) {
      x.setConstant(b.size(), std::numeric_limits<double>::quiet_NaN());
      return;
    }
    x = b;
    const int n = size(), one = 1;
    int info = 0;
    if (!symmetric_) {
      dgetrs_("N", &n, &one, factor_.data(), &n, pivots_.data(), x.data(), &n, &info);
      return;
    }
    for (const auto transposed : {CblasNoTrans, CblasTrans})
      cblas_dtrsv(CblasColMajor, CblasLower, transposed, CblasNonUnit, n, factor_.data(), n,
                  x.data(), 1);
  }

  bool estimate_alone(const SparseMatrix& zero, DenseMatrix& columns) override {
    if (symmetric_ && shared_.factor && shared_.factor->solve_schur(columns)) return true;
    return ReducedOperator::estimate_alone(zero, columns);
  }
  bool rounded() const override { return rough_ && !exact_; }
  void solve_rough(const Vector& b, Vector& x) const override {
    if (!symmetric_ || size() == 0) return solve(b, x);
    round_factor();
    const int n = static_cast<int>(free_.size());
    x.resize(size());
    for (const int i : held_) x[i] = b[i] / held_stiffness(i);
    double largest = 0.0;
    for (const int i : free_) largest = std::max(largest, std::abs(b[i]));
    const double inverse = largest > 0.0 ? 1.0 / largest : 0.0;
    rough_x_.resize(free_.size());
    for (int k = 0; k < n; ++k) rough_x_[k] = static_cast<float>(b[free_[k]] * inverse);
    if (inverted_) {
      rough_b_.swap(rough_x_);
      rough_x_.resize(free_.size());
      cblas_ssymv(CblasColMajor, CblasLower, n, 1.0F, rough_inverse_.data(), n, rough_b_.data(), 1,
                  0.0F, rough_x_.data(), 1);
    } else {
      for (const auto transposed : {CblasNoTrans, CblasTrans})
        cblas_strsv(CblasColMajor, CblasLower, transposed, CblasNonUnit, n, rough_factor_.data(), n,
                    rough_x_.data(), 1);
    }
    for (int k = 0; k < n; ++k) x[free_[k]] = static_cast<double>(rough_x_[k]) * (largest / unit());
  }
  void solve_rough(DenseMatrix& columns) const override {
    if (!symmetric_ || size() == 0) return ReducedOperator::solve_rough(columns);
    round_factor();
    const int n = static_cast<int>(free_.size()), count = static_cast<int>(columns.cols());
    const Vector scale = columns.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-300);
    Eigen::MatrixXf x(n, count);
    for (int j = 0; j < count; ++j)
      for (int k = 0; k < n; ++k) x(k, j) = static_cast<float>(columns(free_[k], j) / scale[j]);
    for (const auto transposed : {CblasNoTrans, CblasTrans})
      cblas_strsm(CblasColMajor, CblasLeft, CblasLower, transposed, CblasNonUnit, n, count, 1.0F,
                  rough_factor_.data(), n, x.data(), n);
    for (int j = 0; j < count; ++j) {
      for (int k = 0; k < n; ++k)
        columns(free_[k], j) = static_cast<double>(x(k, j)) * (scale[j] / unit());
      for (const int i : held_) columns(i, j) /= held_stiffness(i);
    }
  }

  bool inverse(const SparseMatrix& h, DenseMatrix& out) const override {
    if (!symmetric_ || size() == 0) return false;
    out = s_;
    for (int i = 0; i < h.outerSize(); ++i)
      for (SparseMatrix::InnerIterator it(h, i); it; ++it) out(i, it.col()) += it.value();
    const int n = size();
    int info = 0;
    dpotrf_("L", &n, out.data(), &n, &info);
    if (info == 0) dpotri_("L", &n, out.data(), &n, &info);
    return info == 0 && out.diagonal().allFinite(); // the diagonal bounds the rest
  }

  /// A product with the inverse takes a sixth of the time of two triangular solves, which wait for
  /// their own results.
  void expect_rough_solves() override {
    if (!symmetric_ || size() == 0) return;
    round_factor();
    const int n = static_cast<int>(free_.size());
    if (n == 0 || n > largest_inverted) return;
    rough_inverse_ = rough_factor_;
    inverted_ = invert_from_factor(rough_inverse_, n);
    for (int k = 0; k < n; ++k) // the diagonal bounds the rest
      inverted_ = inverted_ && std::isfinite(rough_inverse_[static_cast<std::size_t>(k) * (n + 1)]);
  }

private:
  /// Sizes are taken by the largest diagonal entry, so that no unit system leaves single precision.
  double unit() const { return unit_; }
  double held_stiffness(int i) const { return s_(i, i) + h_.coeff(i, i); }
  void round_factor() const {
    if (rough_) return;
    held_.clear(); // an exact factor has them all
    free_.resize(static_cast<std::size_t>(size()));
    std::iota(free_.begin(), free_.end(), 0);
    rough_factor_.resize(static_cast<std::size_t>(size()) * size());
    const double inverse = 1.0 / std::sqrt(unit());
    for (std::size_t k = 0; k < rough_factor_.size(); ++k)
      rough_factor_[k] = static_cast<float>(factor_.data()[k] * inverse);
    rough_ = true;
  }
  bool factor_exactly() const {
    factor_ = s_;
    for (int i = 0; i < h_.outerSize(); ++i)
      for (SparseMatrix::InnerIterator it(h_, i); it; ++it) factor_(i, it.col()) += it.value();
    const int n = size();
    int info = 0;
    if (symmetric_)
      dpotrf_("L", &n, factor_.data(), &n, &info);
    else
      dgetrf_(&n, &n, factor_.data(), &n, pivots_.data(), &info);
    return exact_ = info == 0;
  }
  /// A factor in single precision takes half the time. False where its pivots leave it open whether
  /// the matrix is positive definite.
  bool factor_rounded() const {
    const int n = static_cast<int>(free_.size());
    if (n == 0) return false; // LAPACK takes no matrix without rows
    gather_free();
    const auto stride = static_cast<std::size_t>(n) + 1;
    before_.resize(free_.size());
    for (std::size_t k = 0; k < free_.size(); ++k) before_[k] = rough_factor_[k * stride];
    int info = 0;
    spotrf_("L", &n, rough_factor_.data(), &n, &info);
    if (info != 0) return false;
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const float pivot = rough_factor_[k * stride] * rough_factor_[k * stride] / before_[k];
      if (!(std::isfinite(pivot) && pivot > smallest_rounded_pivot)) return false;
    }
    return rough_ = true;
  }
  /// The lower triangle of S + H without the held unknowns, rounded.
  void gather_free() const {
    const int n = static_cast<int>(free_.size());
    rough_factor_.resize(free_.size() * free_.size());
    const double inverse = 1.0 / unit();
    place_.assign(static_cast<std::size_t>(size()), -1);
    for (int k = 0; k < n; ++k) place_[free_[k]] = k;
    for (int j = 0; j < n; ++j) {
      const double* from = s_.data() + static_cast<std::ptrdiff_t>(free_[j]) * size();
      float* to = rough_factor_.data() + static_cast<std::ptrdiff_t>(j) * n;
      for (int i = j; i < n; ++i) to[i] = static_cast<float>(from[free_[i]] * inverse);
      for (SparseMatrix::InnerIterator it(h_, free_[j]); it; ++it)
        if (const int i = place_[it.col()]; i >= j)
          to[i] += static_cast<float>(it.value() * inverse);
    }
  }
  /// x = (S + H)^-1 b by iterative refinement: the rounded factor, residuals in double precision.
  /// False where the residual does not fall to rounding.
  bool refine(const Vector& b, Vector& x) const {
    Vector r = b, dx, product;
    x = Vector::Zero(size());
    double last = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 8; ++k) {
      solve_rough(r, dx);
      x += dx;
      apply(x, product);
      r = b - product - h_ * x;
      const double size_of_r = r.lpNorm<Eigen::Infinity>();
      if (!(size_of_r <= 0.1 * last)) break; // at rounding, or not converging
      last = size_of_r;
    }
    return last <= 1e-12 * b.lpNorm<Eigen::Infinity>();
  }
  /// From this size on the factor is made in single precision and solves are refined.
  static constexpr int rounded_from = 400;
  /// While the inverse stays in the second cache.
  static constexpr int largest_inverted = 600;
  static constexpr float smallest_rounded_pivot = 1e-4F;

  SharedSchur shared_;
  const DenseMatrix& s_; ///< of it
  mutable Vector magnitudes_;
  SparseMatrix h_;
  mutable DenseMatrix factor_;
  bool symmetric_;
  double unit_;
  mutable std::vector<int> pivots_;
  mutable std::vector<int> free_, held_; ///< which unknowns the rough factor has and leaves out
  mutable std::vector<float> rough_factor_, before_, rough_x_; ///< the factor by columns
  mutable std::vector<float> rough_inverse_, rough_b_;         ///< see expect_rough_solves
  mutable std::vector<int> place_;
  mutable bool exact_ = false, rough_ = false,
               inverted_ = false; ///< which factors there are: room is kept
};

} // namespace

std::unique_ptr<ReducedOperator> dense_operator(std::shared_ptr<const Factorisation> of,
                                                bool symmetric) {
  return std::make_unique<DenseOperator>(SharedSchur{std::move(of), nullptr}, symmetric);
}

std::unique_ptr<ReducedOperator> dense_operator(DenseMatrix s, bool symmetric) {
  auto alone = std::make_shared<const DenseMatrix>(std::move(s));
  return std::make_unique<DenseOperator>(SharedSchur{nullptr, std::move(alone)}, symmetric);
}

} // namespace hvi::solver
