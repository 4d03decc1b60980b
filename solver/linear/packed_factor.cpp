// See packed_factor.hpp.
#include "solver/linear/packed_factor.hpp"

#include "solver/linear/instruction_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace hvi::solver {
namespace {

constexpr int lanes = 8;

int tiles_of(int rows) { return (rows + lanes - 1) / lanes; }

/// The width of the block of columns that begins with `left` columns to go.
int width_of(int left) { return left >= 8 ? 8 : left >= 4 ? 4 : left >= 2 ? 2 : 1; }

/// Floats of a block of `width` columns with `below` rows under its triangle.
std::size_t block_size(int width, int below) {
  return static_cast<std::size_t>(width * width + tiles_of(below) * lanes * width);
}

/// Rounded; what is far below all others becomes zero, as processors stumble over subnormal
/// numbers.
float rounded(double v) { return std::abs(v) < 1e-30 ? 0.0F : static_cast<float>(v); }

/// The inverse of the unit lower triangle of a block, by columns.
std::array<double, 64> inverse_of(const double* column, std::size_t stride, int width) {
  std::array<double, 64> inverse{};
  for (int a = 0; a < width; ++a) {
    inverse[a * width + a] = 1.0;
    for (int i = a + 1; i < width; ++i) {
      double sum = 0.0;
      for (int b = a; b < i; ++b)
        sum += column[b * stride + i] / column[b * stride + b] * inverse[a * width + b];
      inverse[a * width + i] = -sum;
    }
  }
  return inverse;
}

/// Writes one block; `column` points at the top of its triangle.
void pack_block(const double* column, std::size_t stride, int width, int below,
                std::vector<float>& out) {
  const auto inverse = inverse_of(column, stride, width);
  for (int at = 0; at < width * width; ++at) out.push_back(rounded(inverse[at]));
  for (int tile = 0; tile < tiles_of(below); ++tile)
    for (int a = 0; a < width; ++a)
      for (int lane = 0; lane < lanes; ++lane) {
        const int row = tile * lanes + lane;
        const double* of = column + a * stride;
        out.push_back(row < below ? rounded(of[width + row] / of[a]) : 0.0F);
      }
}

/// What a sweep works on.
struct Sweep {
  std::span<const Panel> panels;
  const int* below;
  const float* values;
  const std::size_t* end;
  const double* inverse_square;
  double* work;
};

// Packs are never passed between functions that are compiled apart.
#pragma GCC diagnostic ignored "-Wpsabi"

#pragma GCC push_options
#pragma GCC target("avx512f,avx2,fma,prefer-vector-width=512")
#define HVI_WIDEN_512
namespace avx512 {
#include "solver/linear/packed_kernels.hpp"
#undef HVI_WIDEN_512
} // namespace avx512
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx2,fma")
namespace avx2 {
#include "solver/linear/packed_kernels.hpp"
} // namespace avx2
#pragma GCC pop_options

namespace baseline {
#include "solver/linear/packed_kernels.hpp"
} // namespace baseline

} // namespace

bool PackedFactor::pack(const Supernodes& structure, const double* values) {
  clear();
  structure_ = &structure;
  std::size_t size = 0;
  int tallest = 0, columns = 0;
  for (const Panel& panel : structure.panels()) {
    for (int j = 0, width; j < panel.columns; j += width) {
      width = width_of(panel.columns - j);
      size += block_size(width, panel.rows - j - width);
    }
    tallest = std::max(tallest, panel.rows);
    columns += panel.columns;
  }
  values_.reserve(size);
  inverse_square_.reserve(static_cast<std::size_t>(columns));
  for (const Panel& panel : structure.panels()) {
    const auto stride = static_cast<std::size_t>(panel.stride);
    const double* top = values + panel.values;
    for (int j = 0, width; j < panel.columns; j += width) {
      width = width_of(panel.columns - j);
      pack_block(top + j * (stride + 1), stride, width, panel.rows - j - width, values_);
    }
    for (int j = 0; j < panel.columns; ++j) {
      const double entry = top[j * (stride + 1)];
      inverse_square_.push_back(1.0 / entry / entry);
    }
    end_.push_back(values_.size());
  }
  work_.assign(static_cast<std::size_t>(tallest + lanes), 0.0);
  const bool finite =
      std::all_of(values_.begin(), values_.end(), [](float v) { return std::isfinite(v); }) &&
      std::all_of(inverse_square_.begin(), inverse_square_.end(),
                  [](double v) { return std::isfinite(v); });
  if (!finite) clear();
  return finite;
}

double PackedFactor::bytes() const {
  return static_cast<double>(values_.size()) * sizeof(float) +
         static_cast<double>(inverse_square_.size()) * sizeof(double);
}

void PackedFactor::forward(double* y) {
  const Sweep sweep{structure_->panels(), structure_->below().data(), values_.data(),
                    end_.data(),          inverse_square_.data(),     work_.data()};
  switch (instruction_set()) {
  case InstructionSet::avx512:
    return avx512::forward_sweep(sweep, y);
  case InstructionSet::avx2:
    return avx2::forward_sweep(sweep, y);
  case InstructionSet::baseline:
    return baseline::forward_sweep(sweep, y);
  }
}

void PackedFactor::backward(const double* y, double* x) {
  const Sweep sweep{structure_->panels(), structure_->below().data(), values_.data(),
                    end_.data(),          inverse_square_.data(),     work_.data()};
  switch (instruction_set()) {
  case InstructionSet::avx512:
    return avx512::backward_sweep(sweep, y, x);
  case InstructionSet::avx2:
    return avx2::backward_sweep(sweep, y, x);
  case InstructionSet::baseline:
    return baseline::backward_sweep(sweep, y, x);
  }
}

} // namespace hvi::solver
