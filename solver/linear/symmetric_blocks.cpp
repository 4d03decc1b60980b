// See symmetric_blocks.hpp.
#include "solver/linear/symmetric_blocks.hpp"

#include "solver/linear/instruction_set.hpp"
#include "solver/linear/mirror_pairs.hpp"

#include <cblas.h>

#include <algorithm>
#include <cmath>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace hvi::solver {
namespace {

/// Entries that differ from their mirror image by more than this part of the row's and column's
/// diagonal are no rounding.
constexpr double rounding = 1e-13;

bool is_symmetric(const SparseMatrix& a) {
  if (a.rows() != a.cols() || !a.isCompressed()) return false;
  const Vector size = a.diagonal().cwiseAbs().cwiseSqrt();
  return all_mirror_pairs(a, [&](int i, int j, double left, double right) {
    return std::abs(left - right) <= rounding * size[i] * size[j];
  });
}

/// Does the pattern consist of full blocks of this size?
bool has_blocks(const SparseMatrix& a, int block) {
  if (a.rows() % block != 0) return false;
  const int* start = a.outerIndexPtr();
  const int* column = a.innerIndexPtr();
  for (int i = 0; i < a.rows(); i += block) {
    const int count = start[i + 1] - start[i];
    if (count % block != 0) return false;
    for (int r = 0; r < block; ++r) {
      if (start[i + r + 1] - start[i + r] != count) return false;
      for (int e = 0; e < count; ++e)
        if (column[start[i + r] + e] != column[start[i] + e - e % block] + e % block) return false;
    }
    for (int e = 0; e < count; e += block)
      if (column[start[i] + e] % block != 0) return false;
  }
  return true;
}

/// What a product works on.
struct Blocks {
  int rows;
  const int *start, *column;
  const double *diagonal, *upper;
};

template <int Size>
void multiply_blocks(const Blocks& a, const double* x, double* y) {
  for (int i = 0; i < a.rows; ++i) {
    const double* v = a.diagonal + Size * Size * i;
    const double* xi = x + Size * i;
    double sum[Size];
    for (int r = 0; r < Size; ++r) {
      sum[r] = y[Size * i + r];
      for (int c = 0; c < Size; ++c) sum[r] += v[Size * r + c] * xi[c];
    }
    for (int at = a.start[i]; at < a.start[i + 1]; ++at) {
      v = a.upper + static_cast<std::ptrdiff_t>(Size * Size) * at;
      const double* xj = x + Size * a.column[at];
      double* yj = y + Size * a.column[at];
      for (int r = 0; r < Size; ++r)
        for (int c = 0; c < Size; ++c) {
          sum[r] += v[Size * r + c] * xj[c];
          yj[c] += v[Size * r + c] * xi[r];
        }
    }
    for (int r = 0; r < Size; ++r) y[Size * i + r] = sum[r];
  }
}

template <int Size>
double energy_of_blocks(const Blocks& a, const double* x) {
  double total = 0;
  for (int i = 0; i < a.rows; ++i) {
    double on[Size] = {}, above[Size] = {};
    const double* v = a.diagonal + Size * Size * i;
    for (int r = 0; r < Size; ++r)
      for (int c = 0; c < Size; ++c) on[r] += v[Size * r + c] * x[Size * i + c];
    for (int at = a.start[i]; at < a.start[i + 1]; ++at) {
      v = a.upper + static_cast<std::ptrdiff_t>(Size * Size) * at;
      const double* xj = x + Size * a.column[at];
      for (int r = 0; r < Size; ++r)
        for (int c = 0; c < Size; ++c) above[r] += v[Size * r + c] * xj[c];
    }
    for (int r = 0; r < Size; ++r) total += (on[r] + 2.0 * above[r]) * x[Size * i + r];
  }
  return total;
}

#if defined(__x86_64__)

/// Blocks of 2 as packs (v00 v01 v10 v11).
HVI_AVX2 void multiply_pairs(const Blocks& a, const double* x, double* y) {
  for (int i = 0; i < a.rows; ++i) {
    const auto both = _mm256_broadcast_pd(reinterpret_cast<const __m128d*>(x + 2 * i));
    const auto each = _mm256_permute4x64_pd(both, 0b01010000);
    auto sum = _mm256_mul_pd(_mm256_loadu_pd(a.diagonal + 4 * i), both);
    for (int at = a.start[i]; at < a.start[i + 1]; ++at) {
      const auto v = _mm256_loadu_pd(a.upper + 4 * static_cast<std::ptrdiff_t>(at));
      const int j = 2 * a.column[at];
      sum = _mm256_fmadd_pd(v, _mm256_broadcast_pd(reinterpret_cast<const __m128d*>(x + j)), sum);
      const auto mirrored = _mm256_mul_pd(v, each);
      const auto added =
          _mm_add_pd(_mm256_castpd256_pd128(mirrored), _mm256_extractf128_pd(mirrored, 1));
      _mm_storeu_pd(y + j, _mm_add_pd(_mm_loadu_pd(y + j), added));
    }
    const auto halves = _mm_hadd_pd(_mm256_castpd256_pd128(sum), _mm256_extractf128_pd(sum, 1));
    _mm_storeu_pd(y + 2 * i, _mm_add_pd(_mm_loadu_pd(y + 2 * i), halves));
  }
}

/// x^T A x for blocks of 2: every block above the diagonal counts twice.
HVI_AVX2 double energy_of_pairs(const Blocks& a, const double* x) {
  auto total = _mm256_setzero_pd();
  for (int i = 0; i < a.rows; ++i) {
    const auto both = _mm256_broadcast_pd(reinterpret_cast<const __m128d*>(x + 2 * i));
    auto above = _mm256_setzero_pd();
    for (int at = a.start[i]; at < a.start[i + 1]; ++at) {
      const auto v = _mm256_loadu_pd(a.upper + 4 * static_cast<std::ptrdiff_t>(at));
      const auto* xj = reinterpret_cast<const __m128d*>(x + 2 * a.column[at]);
      above = _mm256_fmadd_pd(v, _mm256_broadcast_pd(xj), above);
    }
    const auto on = _mm256_mul_pd(_mm256_loadu_pd(a.diagonal + 4 * i), both);
    const auto row = _mm256_add_pd(on, _mm256_add_pd(above, above));
    total = _mm256_fmadd_pd(row, _mm256_permute4x64_pd(both, 0b01010000), total);
  }
  const auto halves = _mm_add_pd(_mm256_castpd256_pd128(total), _mm256_extractf128_pd(total, 1));
  return halves[0] + halves[1];
}

/// Blocks of 3; x and y with four places a node, the last of no meaning. Reads one double behind
/// the last block.
HVI_AVX2 void multiply_triples(const Blocks& a, const double* x, double* y) {
  for (int i = 0; i < a.rows; ++i) {
    const double* v = a.diagonal + 9 * i;
    const auto xi = _mm256_loadu_pd(x + 4 * i);
    auto sum0 = _mm256_mul_pd(_mm256_loadu_pd(v), xi);
    auto sum1 = _mm256_mul_pd(_mm256_loadu_pd(v + 3), xi);
    auto sum2 = _mm256_mul_pd(_mm256_loadu_pd(v + 6), xi);
    const auto x0 = _mm256_broadcast_sd(x + 4 * i), x1 = _mm256_broadcast_sd(x + 4 * i + 1),
               x2 = _mm256_broadcast_sd(x + 4 * i + 2);
    for (int at = a.start[i]; at < a.start[i + 1]; ++at) {
      v = a.upper + 9 * static_cast<std::ptrdiff_t>(at);
      const int j = 4 * a.column[at];
      const auto row0 = _mm256_loadu_pd(v), row1 = _mm256_loadu_pd(v + 3),
                 row2 = _mm256_loadu_pd(v + 6);
      const auto xj = _mm256_loadu_pd(x + j);
      sum0 = _mm256_fmadd_pd(row0, xj, sum0);
      sum1 = _mm256_fmadd_pd(row1, xj, sum1);
      sum2 = _mm256_fmadd_pd(row2, xj, sum2);
      auto yj = _mm256_fmadd_pd(row0, x0, _mm256_loadu_pd(y + j));
      yj = _mm256_fmadd_pd(row1, x1, yj);
      _mm256_storeu_pd(y + j, _mm256_fmadd_pd(row2, x2, yj));
    }
    double* yi = y + 4 * i; // the fourth places of the sums hold what x's fourth places, 0, made
    const auto s01 = _mm256_hadd_pd(sum0, sum1), s22 = _mm256_hadd_pd(sum2, sum2);
    const auto first = _mm_add_pd(_mm256_castpd256_pd128(s01), _mm256_extractf128_pd(s01, 1));
    const auto third = _mm_add_pd(_mm256_castpd256_pd128(s22), _mm256_extractf128_pd(s22, 1));
    _mm_storeu_pd(yi, _mm_add_pd(_mm_loadu_pd(yi), first));
    yi[2] += _mm_cvtsd_f64(third);
  }
}

#endif

Blocks view(const BlockRows& a) {
  return {a.rows, a.start.data(), a.column.data(), a.diagonal.data(), a.upper.data()};
}

/// The blocks of this size of a symmetric matrix.
BlockRows upper_blocks(const SparseMatrix& a, int size) {
  BlockRows out;
  out.size = size, out.rows = static_cast<int>(a.rows()) / size;
  const int* start = a.outerIndexPtr();
  const int* column = a.innerIndexPtr();
  const auto area = static_cast<std::size_t>(size * size);
  const std::size_t half = static_cast<std::size_t>(a.nonZeros()) / 2 / area;
  out.diagonal.reserve(area * static_cast<std::size_t>(out.rows) + 1);
  out.upper.reserve(area * half + 1);
  out.column.reserve(half);
  out.start.assign(1, 0);
  for (int i = 0; i < out.rows; ++i) {
    const int row = size * i;
    bool on_diagonal = false;
    for (int e = 0; e < start[row + 1] - start[row]; e += size) {
      const int j = column[start[row] + e] / size;
      if (j < i) continue;
      auto& into = j == i ? out.diagonal : out.upper;
      on_diagonal = on_diagonal || j == i;
      if (j > i) out.column.push_back(j);
      for (int r = 0; r < size; ++r)
        for (int c = 0; c < size; ++c) into.push_back(a.valuePtr()[start[row + r] + e + c]);
    }
    if (!on_diagonal) out.diagonal.insert(out.diagonal.end(), area, 0.0);
    out.start.push_back(static_cast<int>(out.column.size()));
  }
  out.diagonal.push_back(0.0), out.upper.push_back(0.0); // blocks of 3 are read as four doubles
  return out;
}

/// Where the rows of the whole matrix begin; those of a block have one length.
std::vector<int> starts_of_rows(const BlockRows& a) {
  std::vector<int> length(static_cast<std::size_t>(a.rows), a.size); // with the diagonal block
  for (int i = 0; i < a.rows; ++i)
    for (int at = a.start[i]; at < a.start[i + 1]; ++at)
      length[i] += a.size, length[a.column[at]] += a.size;
  std::vector<int> out{0};
  out.reserve(static_cast<std::size_t>(a.size) * length.size() + 1);
  for (const int one : length)
    for (int r = 0; r < a.size; ++r) out.push_back(out.back() + one);
  return out;
}

/// Blocks on both sides of the diagonal. Rows are filled from above, so that the mirror images of
/// the blocks of the rows before come first, in their order.
SparseMatrix both_triangles(const BlockRows& a) {
  const int size = a.size, n = a.rows * size;
  const std::vector<int> start = starts_of_rows(a);
  SparseMatrix out(n, n);
  out.resizeNonZeros(start.back());
  std::copy(start.begin(), start.end(), out.outerIndexPtr());
  std::vector<int> next(static_cast<std::size_t>(a.rows), 0); // within a row
  const auto put = [&](int i, int j, const double* block, int down, int right) {
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) {
        const int at = start[size * i + r] + next[i] + c;
        out.innerIndexPtr()[at] = size * j + c;
        out.valuePtr()[at] = block[down * r + right * c];
      }
    next[i] += size;
  };
  for (int i = 0; i < a.rows; ++i) {
    put(i, i, a.diagonal.data() + size * size * i, size, 1);
    for (int at = a.start[i]; at < a.start[i + 1]; ++at) {
      const double* block = a.upper.data() + static_cast<std::ptrdiff_t>(size * size) * at;
      put(i, a.column[at], block, size, 1);
      put(a.column[at], i, block, 1, size);
    }
  }
  return out;
}

bool same_pattern(const BlockRows& a, const BlockRows& b) {
  return a.size == b.size && a.rows == b.rows && a.start == b.start && a.column == b.column;
}

} // namespace

SymmetricBlocks::SymmetricBlocks(const SparseMatrix& a, bool known) {
  if (a.rows() == 0 || !(known || is_symmetric(a))) return;
  diagonal_entries_ = a.diagonal();
  if (2.0 * static_cast<double>(a.nonZeros()) > std::pow(static_cast<double>(a.rows()), 2)) {
    blocks_.size = static_cast<int>(a.rows()), blocks_.rows = 1;
    dense_ = a;
    return;
  }
  blocks_ = upper_blocks(a, has_blocks(a, 3) ? 3 : has_blocks(a, 2) ? 2 : 1);
  if (blocks_.size != 3) return;
  x_.assign(4 * static_cast<std::size_t>(blocks_.rows), 0.0);
  y_ = x_;
}

SymmetricBlocks SymmetricBlocks::sum(std::span<const SymmetricBlocks> parts,
                                     const Vector& factors) {
  SymmetricBlocks out = parts.front();
  const auto scale = [&](std::vector<double>& values) {
    for (double& v : values) v *= factors[0];
  };
  scale(out.blocks_.diagonal), scale(out.blocks_.upper);
  out.diagonal_entries_ *= factors[0];
  out.dense_ *= factors[0];
  for (std::size_t b = 1; b < parts.size(); ++b) {
    const SymmetricBlocks& part = parts[b];
    if (!same_pattern(out.blocks_, part.blocks_)) return {};
    const double factor = factors[static_cast<Eigen::Index>(b)];
    const auto add = [&](std::vector<double>& values, const std::vector<double>& more) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] += factor * more[i];
    };
    add(out.blocks_.diagonal, part.blocks_.diagonal), add(out.blocks_.upper, part.blocks_.upper);
    out.diagonal_entries_ += factor * part.diagonal_entries_;
    out.dense_ += factor * part.dense_;
  }
  return out;
}

double SymmetricBlocks::energy(const Vector& x) const {
  if (dense_.size() > 0) return x.dot(dense_.selfadjointView<Eigen::Lower>() * x);
  const Blocks a = view(blocks_);
#if defined(__x86_64__)
  if (blocks_.size == 2 && instruction_set() != InstructionSet::baseline)
    return energy_of_pairs(a, x.data());
#endif
  if (blocks_.size == 1) return energy_of_blocks<1>(a, x.data());
  if (blocks_.size == 2) return energy_of_blocks<2>(a, x.data());
  return energy_of_blocks<3>(a, x.data());
}

SparseMatrix SymmetricBlocks::by_rows() const {
  if (dense_.size() == 0) return both_triangles(blocks_);
  SparseMatrix out(dense_.rows(), dense_.cols());
  out.reserve(Eigen::VectorXi::Constant(dense_.rows(), static_cast<int>(dense_.cols())));
  for (int i = 0; i < dense_.rows(); ++i)
    for (int j = 0; j < dense_.cols(); ++j)
      out.insert(i, j) = dense_(std::max(i, j), std::min(i, j)); // the half that products read
  out.makeCompressed();
  return out;
}

double SymmetricBlocks::bytes() const {
  return static_cast<double>(blocks_.diagonal.size() + blocks_.upper.size() + dense_.size()) *
             sizeof(double) +
         static_cast<double>(blocks_.start.size() + blocks_.column.size()) * sizeof(int);
}

void SymmetricBlocks::add_product(const Vector& x, Vector& y) const {
  if (dense_.size() > 0) {
    cblas_dsymv(CblasColMajor, CblasLower, blocks_.size, 1.0, dense_.data(), blocks_.size, x.data(),
                1, 1.0, y.data(), 1);
    return;
  }
  const Blocks a = view(blocks_);
#if defined(__x86_64__)
  if (blocks_.size == 2 && instruction_set() != InstructionSet::baseline)
    return multiply_pairs(a, x.data(), y.data());
  if (blocks_.size == 3 && instruction_set() != InstructionSet::baseline) {
    for (int i = 0; i < blocks_.rows; ++i)
      for (int k = 0; k < 3; ++k) x_[4 * i + k] = x[3 * i + k], y_[4 * i + k] = y[3 * i + k];
    multiply_triples(a, x_.data(), y_.data());
    for (int i = 0; i < blocks_.rows; ++i)
      for (int k = 0; k < 3; ++k) y[3 * i + k] = y_[4 * i + k];
    return;
  }
#endif
  if (blocks_.size == 1) multiply_blocks<1>(a, x.data(), y.data());
  if (blocks_.size == 2) multiply_blocks<2>(a, x.data(), y.data());
  if (blocks_.size == 3) multiply_blocks<3>(a, x.data(), y.data());
}

} // namespace hvi::solver
