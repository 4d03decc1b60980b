// See packed_factor.hpp.
#include "solver/linear/mixed/packed_factor.hpp"

#include "solver/linear/instruction_set.hpp"

#include <algorithm>
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

/// Entries of a block of `width` columns with `below` rows under its triangle.
std::size_t block_size(int width, int below) {
  return static_cast<std::size_t>(width * width + tiles_of(below) * lanes * width);
}

/// The data of a triangular solve.
struct PackedSolve {
  std::span<const Panel> panels;
  const int* below;
  const float* values;
  const std::int16_t* rests;
  const std::size_t* end;
  const double* inverse_square;
  double* work;
};

/// Where entries are written to.
struct Packing {
  float* values;
  std::int16_t* rests;
  double* inverse_square;
  bool finite = true;
};

// An entry is a float and the sixteen bits of the double that follow: bits of the double are those
// of the widened float plus rest << 21. They are counted from the nearest float, so that the float
// alone is as near as can be.
constexpr int rest_shift = 13;

/// Entries far below all others become zero: processors are slow with subnormal numbers.
constexpr double negligible = 1e-30;

void split(double v, float& value, std::int16_t& rest) {
  if (!(std::abs(v) >= negligible)) v = v == v ? 0.0 : v;
  value = static_cast<float>(v);
  const double widened = value;
  std::int64_t bits, near;
  std::memcpy(&bits, &v, sizeof bits);
  std::memcpy(&near, &widened, sizeof near);
  const std::int64_t units = (bits - near + (std::int64_t{1} << (rest_shift - 1))) >> rest_shift;
  rest = static_cast<std::int16_t>(std::clamp<std::int64_t>(units, -32768, 32767));
}

// Packs are never passed between functions compiled for different instruction sets.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace baseline {
#include "solver/linear/mixed/packed_kernels.hpp"
} // namespace baseline

#if defined(__x86_64__)
// All functions of a namespace for one instruction set, in the words of either compiler.
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx2,fma,prefer-vector-width=512")
#endif
#define HVI_PACKED_512
namespace avx512 {
#include "solver/linear/mixed/packed_kernels.hpp"
#undef HVI_PACKED_512
} // namespace avx512
#if defined(__clang__)
#pragma clang attribute pop
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
#define HVI_PACKED_256
namespace avx2 {
#include "solver/linear/mixed/packed_kernels.hpp"
#undef HVI_PACKED_256
} // namespace avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#else // one set of instructions
namespace avx512 = baseline;
namespace avx2 = baseline;
#endif

} // namespace

/// Finds where each panel's entries end; returns how many there are.
std::size_t PackedFactor::lay_out(const Supernodes& structure) {
  std::size_t size = 0;
  int tallest = 0, columns = 0;
  end_.clear();
  for (const Panel& panel : structure.panels()) {
    for (int j = 0, width; j < panel.columns; j += width) {
      width = width_of(panel.columns - j);
      size += block_size(width, panel.rows - j - width);
    }
    end_.push_back(size);
    tallest = std::max(tallest, panel.rows);
    columns += panel.columns;
  }
  inverse_square_.resize(static_cast<std::size_t>(columns));
  work_.assign(static_cast<std::size_t>(tallest + lanes), 0.0);
  return size;
}

bool PackedFactor::pack(const Supernodes& structure, const double* values) {
  const std::size_t size = lay_out(structure);
  values_.resize(size);
  rests_.resize(size);
  structure_ = &structure;
  Packing out{values_.data(), rests_.data(), inverse_square_.data()};
  switch (instruction_set()) {
  case InstructionSet::avx512:
    avx512::pack_panels(structure.panels(), values, out);
    break;
  case InstructionSet::avx2:
    avx2::pack_panels(structure.panels(), values, out);
    break;
  case InstructionSet::baseline:
    baseline::pack_panels(structure.panels(), values, out);
    break;
  }
  const bool finite = out.finite && std::all_of(inverse_square_.begin(), inverse_square_.end(),
                                                [](double v) { return std::isfinite(v); });
  if (!finite) clear();
  return finite;
}

double PackedFactor::bytes() const {
  return static_cast<double>(values_.size()) * (sizeof(float) + sizeof(std::int16_t)) +
         static_cast<double>(inverse_square_.size()) * sizeof(double);
}

double PackedFactor::bytes_read(bool fine) const {
  return static_cast<double>(values_.size()) *
         (sizeof(float) + (fine ? sizeof(std::int16_t) : std::size_t{0}));
}

void PackedFactor::forward(bool fine, double* y) {
  const PackedSolve solve{
      structure_->panels(), structure_->below().data(), values_.data(), rests_.data(),
      end_.data(),          inverse_square_.data(),     work_.data()};
  switch (instruction_set()) {
  case InstructionSet::avx512:
    return fine ? avx512::forward_solve<true>(solve, y) : avx512::forward_solve<false>(solve, y);
  case InstructionSet::avx2:
    return fine ? avx2::forward_solve<true>(solve, y) : avx2::forward_solve<false>(solve, y);
  case InstructionSet::baseline:
    return fine ? baseline::forward_solve<true>(solve, y)
                : baseline::forward_solve<false>(solve, y);
  }
}

void PackedFactor::backward(bool fine, double* x) {
  const PackedSolve solve{
      structure_->panels(), structure_->below().data(), values_.data(), rests_.data(),
      end_.data(),          inverse_square_.data(),     work_.data()};
  switch (instruction_set()) {
  case InstructionSet::avx512:
    return fine ? avx512::backward_solve<true>(solve, x) : avx512::backward_solve<false>(solve, x);
  case InstructionSet::avx2:
    return fine ? avx2::backward_solve<true>(solve, x) : avx2::backward_solve<false>(solve, x);
  case InstructionSet::baseline:
    return fine ? baseline::backward_solve<true>(solve, x)
                : baseline::backward_solve<false>(solve, x);
  }
}

} // namespace hvi::solver
