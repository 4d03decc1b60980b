// The kernels of supernodes.cpp: one right-hand side, or several that are interleaved, through the
// panels of a factor, whose entries are doubles or singles; the arithmetic is double. They take
// four columns of a panel at a time, so that the right-hand side, which stays in the first cache,
// is read once for four columns of L from memory.
#pragma once

#include "solver/linear/instruction_set.hpp"
#include "solver/linear/supernodes.hpp"

#include <algorithm>
#include <cstring>
#include <span>

namespace hvi::solver::supernode_kernels {

constexpr int width = 4;

/// How many entries ahead of use memory is prefetched, as processors foresee streams within a page
/// only: the same rows of the next columns, which follow in memory. Less than that would fetch what
/// the columns at hand have read already.
constexpr std::size_t least_ahead = 1024;
HVI_INLINE std::ptrdiff_t ahead(std::size_t stride) {
  return static_cast<std::ptrdiff_t>(std::max(least_ahead, width * stride));
}

/// Into the second cache: the first one waits for few lines at a time, and with all of them taken
/// by what comes later a solve takes a third longer.
template <int Width, class Entry>
HVI_INLINE void prefetch(const Entry* column, std::size_t stride) {
  constexpr int read = 0, second_cache = 2;
#pragma GCC unroll 4
  for (int a = 0; a < Width; ++a) __builtin_prefetch(column + a * stride, read, second_cache);
}

/// What a prefetch gets.
template <class Entry>
constexpr int line = 64 / sizeof(Entry);

/// w[0..Lanes) -= sum_a column_a[0..Lanes) t[a]
template <int Width, int Lanes, class Entry>
HVI_INLINE void subtract_pack(const Entry* column, std::size_t stride, const double* t, double* w) {
  Pack<Lanes> sum, entry;
  load<Lanes>(w, sum);
#pragma GCC unroll 4
  for (int a = 0; a < Width; ++a) {
    load<Lanes>(column + a * stride, entry);
    sum -= entry * t[a];
  }
  std::memcpy(w, &sum, sizeof sum);
}

/// w[0..count) -= sum_a column_a[0..count) t[a]
template <int Width, int Lanes, class Entry>
HVI_INLINE void subtract_columns(const Entry* column, std::size_t stride, int count,
                                 const double* t, double* w) {
  const Entry* const later = column + ahead(stride);
  int i = 0;
  for (; i + line<Entry> <= count; i += line<Entry>) {
    prefetch<Width>(later + i, stride);
#pragma GCC unroll 4
    for (int k = 0; k < line<Entry>; k += Lanes)
      subtract_pack<Width, Lanes>(column + i + k, stride, t, w + i + k);
  }
  for (; i + Lanes <= count; i += Lanes) subtract_pack<Width, Lanes>(column + i, stride, t, w + i);
  if constexpr (Lanes > 4)
    for (; i + 4 <= count; i += 4) subtract_pack<Width, 4>(column + i, stride, t, w + i);
  for (; i < count; ++i)
    for (int a = 0; a < Width; ++a) w[i] -= column[a * stride + i] * t[a];
}

/// sum_a += column_a[0..Lanes) w[0..Lanes), lane by lane
template <int Width, int Lanes, class Entry>
HVI_INLINE void add_products(const Entry* column, std::size_t stride, const double* w,
                             Pack<Lanes>* sum) {
  Pack<Lanes> other, entry;
  load<Lanes>(w, other);
#pragma GCC unroll 4
  for (int a = 0; a < Width; ++a) {
    load<Lanes>(column + a * stride, entry);
    sum[a] += entry * other;
  }
}

HVI_INLINE void fold(const Pack<8>& sum, Pack<4>& out) {
  out =
      __builtin_shufflevector(sum, sum, 0, 1, 2, 3) + __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
}
HVI_INLINE void fold(const Pack<4>& sum, Pack<4>& out) { out = sum; }

/// t[a] -= column_a[0..count) . w[0..count)
template <int Width, int Lanes, class Entry>
HVI_INLINE void subtract_products(const Entry* column, std::size_t stride, int count,
                                  const double* w, double* t) {
  const Entry* const later = column - ahead(stride);
  Pack<Lanes> sum[Width] = {};
  int i = 0;
  for (; i + line<Entry> <= count; i += line<Entry>) {
    prefetch<Width>(later + i, stride);
#pragma GCC unroll 4
    for (int k = 0; k < line<Entry>; k += Lanes)
      add_products<Width, Lanes>(column + i + k, stride, w + i + k, sum);
  }
  for (; i + Lanes <= count; i += Lanes) add_products<Width, Lanes>(column + i, stride, w + i, sum);
  Pack<4> four[Width];
  for (int a = 0; a < Width; ++a) fold(sum[a], four[a]);
  for (; i + 4 <= count; i += 4) add_products<Width, 4>(column + i, stride, w + i, four);
  for (int a = 0; a < Width; ++a) {
    double total = (four[a][0] + four[a][1]) + (four[a][2] + four[a][3]);
    for (int rest = i; rest < count; ++rest) total += column[a * stride + rest] * w[rest];
    t[a] -= total;
  }
}

/// One block of `Width` columns from `j` on: solves with its triangle, updates the rows below.
template <int Width, int Lanes, class Entry>
HVI_INLINE void forward_block(const Entry* l, std::size_t stride, int j, int rows,
                              const double* inverse, double* w) {
  const Entry* column = l + static_cast<std::size_t>(j) * stride;
  double t[Width];
  for (int a = 0; a < Width; ++a) {
    double value = w[j + a];
    for (int b = 0; b < a; ++b) value -= column[b * stride + j + a] * t[b];
    t[a] = value * inverse[j + a];
    w[j + a] = t[a];
  }
  subtract_columns<Width, Lanes>(column + j + Width, stride, rows - j - Width, t, w + j + Width);
}

template <int Width, int Lanes, class Entry>
HVI_INLINE void backward_block(const Entry* l, std::size_t stride, int j, int rows,
                               const double* inverse, double* w) {
  const Entry* column = l + static_cast<std::size_t>(j) * stride;
  double* t = w + j;
  subtract_products<Width, Lanes>(column + j + Width, stride, rows - j - Width, w + j + Width, t);
  for (int a = Width - 1; a >= 0; --a) {
    for (int b = a + 1; b < Width; ++b) t[a] -= column[a * stride + j + b] * t[b];
    t[a] *= inverse[j + a];
  }
}

/// Forward through one panel; w is its part of the right-hand side with zeros below.
template <int Lanes, class Entry>
HVI_INLINE void forward_panel(const Entry* l, const Panel& panel, const double* inverse,
                              double* w) {
  const auto stride = static_cast<std::size_t>(panel.stride);
  int j = 0;
  for (; j + width <= panel.columns; j += width)
    forward_block<width, Lanes>(l, stride, j, panel.rows, inverse, w);
  for (; j < panel.columns; ++j) forward_block<1, Lanes>(l, stride, j, panel.rows, inverse, w);
}

template <int Lanes, class Entry>
HVI_INLINE void backward_panel(const Entry* l, const Panel& panel, const double* inverse,
                               double* w) {
  const auto stride = static_cast<std::size_t>(panel.stride);
  int j = panel.columns;
  for (; j % width != 0; --j) backward_block<1, Lanes>(l, stride, j - 1, panel.rows, inverse, w);
  for (; j > 0; j -= width)
    backward_block<width, Lanes>(l, stride, j - width, panel.rows, inverse, w);
}

/// The data of a triangular solve.
template <class Entry>
struct TriangularSolve {
  std::span<const Panel> panels;
  const int* below;
  const Entry* values;
  const double* inverse_diagonal;
  double* work;
};

template <int Lanes, class Entry>
HVI_INLINE void forward_solve(const TriangularSolve<Entry>& solve, double* y) {
  for (const Panel& panel : solve.panels) {
    double* w = solve.work;
    const int beneath = panel.rows - panel.columns;
    const int* row = solve.below + panel.below;
    const double* own = y + panel.first;
    // With a load at a few points most panels have a right-hand side of zeros.
    if (std::all_of(own, own + panel.columns, [](double v) { return v == 0.0; })) continue;
    std::memcpy(w, own, sizeof(double) * static_cast<std::size_t>(panel.columns));
    std::memset(w + panel.columns, 0, sizeof(double) * static_cast<std::size_t>(beneath));
    forward_panel<Lanes>(solve.values + panel.values, panel, solve.inverse_diagonal + panel.first,
                         w);
    std::memcpy(y + panel.first, w, sizeof(double) * static_cast<std::size_t>(panel.columns));
    for (int i = 0; i < beneath; ++i) y[row[i]] += w[panel.columns + i];
  }
}

template <int Lanes, class Entry>
HVI_INLINE void backward_solve(const TriangularSolve<Entry>& solve, double* x) {
  for (auto panel = solve.panels.rbegin(); panel != solve.panels.rend(); ++panel) {
    double* w = solve.work;
    const int beneath = panel->rows - panel->columns;
    const int* row = solve.below + panel->below;
    std::memcpy(w, x + panel->first, sizeof(double) * static_cast<std::size_t>(panel->columns));
    for (int i = 0; i < beneath; ++i) w[panel->columns + i] = x[row[i]];
    backward_panel<Lanes>(solve.values + panel->values, *panel,
                          solve.inverse_diagonal + panel->first, w);
    std::memcpy(x + panel->first, w, sizeof(double) * static_cast<std::size_t>(panel->columns));
  }
}

/// t[a][g] -= sum_i column_a[i] w[i][g] for Packs packs g of rows that are `row` numbers wide.
template <int Width, int Packs, int Lanes, class Entry>
HVI_INLINE void subtract_all(const Entry* column, std::size_t stride, int count, const double* w,
                             int row, double* t) {
  Pack<Lanes> sum[Width][Packs];
#pragma GCC unroll 4
  for (int a = 0; a < Width; ++a)
#pragma GCC unroll 2
    for (int g = 0; g < Packs; ++g) load<Lanes>(t + a * row + g * Lanes, sum[a][g]);
  for (int i = 0; i < count; ++i) {
    if (i % line<Entry> == 0) prefetch<Width>(column + i - ahead(stride), stride);
    Pack<Lanes> other[Packs];
#pragma GCC unroll 2
    for (int g = 0; g < Packs; ++g) load<Lanes>(w + i * row + g * Lanes, other[g]);
#pragma GCC unroll 4
    for (int a = 0; a < Width; ++a)
#pragma GCC unroll 2
      for (int g = 0; g < Packs; ++g)
        sum[a][g] -= static_cast<double>(column[a * stride + i]) * other[g];
  }
#pragma GCC unroll 4
  for (int a = 0; a < Width; ++a)
#pragma GCC unroll 2
    for (int g = 0; g < Packs; ++g)
      std::memcpy(t + a * row + g * Lanes, &sum[a][g], sizeof sum[a][g]);
}

/// w[i][g] -= sum_a column_a[i] t[a][g], shaped like that.
template <int Width, int Packs, int Lanes, class Entry>
HVI_INLINE void subtract_from_all(const Entry* column, std::size_t stride, int count,
                                  const double* t, int row, double* w) {
  Pack<Lanes> known[Width][Packs];
#pragma GCC unroll 4
  for (int a = 0; a < Width; ++a)
#pragma GCC unroll 2
    for (int g = 0; g < Packs; ++g) load<Lanes>(t + a * row + g * Lanes, known[a][g]);
  for (int i = 0; i < count; ++i) {
    if (i % line<Entry> == 0) prefetch<Width>(column + i + ahead(stride), stride);
#pragma GCC unroll 2
    for (int g = 0; g < Packs; ++g) {
      Pack<Lanes> sum;
      load<Lanes>(w + i * row + g * Lanes, sum);
#pragma GCC unroll 4
      for (int a = 0; a < Width; ++a)
        sum -= static_cast<double>(column[a * stride + i]) * known[a][g];
      std::memcpy(w + i * row + g * Lanes, &sum, sizeof sum);
    }
  }
}

template <int Width, int Packs, int Lanes, class Entry>
HVI_INLINE void forward_block_all(const Entry* l, std::size_t stride, int j, int rows,
                                  const double* inverse, int row, double* w) {
  const Entry* column = l + static_cast<std::size_t>(j) * stride;
  double* t = w + j * row;
  for (int a = 0; a < Width; ++a)
    for (int g = 0; g < Packs; ++g) {
      Pack<Lanes> own, other;
      load<Lanes>(t + a * row + g * Lanes, own);
      for (int b = 0; b < a; ++b) {
        load<Lanes>(t + b * row + g * Lanes, other);
        own -= static_cast<double>(column[b * stride + j + a]) * other;
      }
      own *= inverse[j + a];
      std::memcpy(t + a * row + g * Lanes, &own, sizeof own);
    }
  subtract_from_all<Width, Packs, Lanes>(column + j + Width, stride, rows - j - Width, t, row,
                                         t + Width * row);
}

template <int Packs, int Lanes, class Entry>
HVI_INLINE void forward_panel_all(const Entry* l, const Panel& panel, const double* inverse,
                                  int row, double* w) {
  const auto stride = static_cast<std::size_t>(panel.stride);
  int j = 0;
  for (; j + width <= panel.columns; j += width)
    forward_block_all<width, Packs, Lanes>(l, stride, j, panel.rows, inverse, row, w);
  for (; j < panel.columns; ++j)
    forward_block_all<1, Packs, Lanes>(l, stride, j, panel.rows, inverse, row, w);
}

/// `Packs` of `Lanes` are what the registers hold; a panel is in the cache when the next ones come.
template <int Packs, int Lanes, class Entry>
HVI_INLINE void forward_solve_all(const TriangularSolve<Entry>& solve, int row, double* y) {
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(row);
  for (const Panel& panel : solve.panels) {
    double* w = solve.work;
    double* own = y + static_cast<std::ptrdiff_t>(panel.first) * row;
    const int beneath = panel.rows - panel.columns;
    const int* place = solve.below + panel.below;
    const Entry* l = solve.values + panel.values;
    const double* inverse = solve.inverse_diagonal + panel.first;
    std::memcpy(w, own, bytes * static_cast<std::size_t>(panel.columns));
    std::memset(w + panel.columns * row, 0, bytes * static_cast<std::size_t>(beneath));
    int r = 0;
    for (; r + Packs * Lanes <= row; r += Packs * Lanes)
      forward_panel_all<Packs, Lanes>(l, panel, inverse, row, w + r);
    for (; r < row; r += Lanes) forward_panel_all<1, Lanes>(l, panel, inverse, row, w + r);
    std::memcpy(own, w, bytes * static_cast<std::size_t>(panel.columns));
    for (int i = 0; i < beneath; ++i) {
      const double* from = w + (panel.columns + i) * row;
      double* to = y + static_cast<std::ptrdiff_t>(place[i]) * row;
      for (int k = 0; k < row; k += Lanes) {
        Pack<Lanes> sum, more;
        load<Lanes>(to + k, sum);
        load<Lanes>(from + k, more);
        sum += more;
        std::memcpy(to + k, &sum, sizeof sum);
      }
    }
  }
}

template <int Width, int Packs, int Lanes, class Entry>
HVI_INLINE void backward_block_all(const Entry* l, std::size_t stride, int j, int rows,
                                   const double* inverse, int row, double* w) {
  const Entry* column = l + static_cast<std::size_t>(j) * stride;
  double* t = w + j * row;
  subtract_all<Width, Packs, Lanes>(column + j + Width, stride, rows - j - Width, t + Width * row,
                                    row, t);
  for (int a = Width - 1; a >= 0; --a)
    for (int g = 0; g < Packs; ++g) {
      Pack<Lanes> own, other;
      load<Lanes>(t + a * row + g * Lanes, own);
      for (int b = a + 1; b < Width; ++b) {
        load<Lanes>(t + b * row + g * Lanes, other);
        own -= static_cast<double>(column[a * stride + j + b]) * other;
      }
      own *= inverse[j + a];
      std::memcpy(t + a * row + g * Lanes, &own, sizeof own);
    }
}

/// Through one panel, `Packs` packs of the right-hand sides.
template <int Packs, int Lanes, class Entry>
HVI_INLINE void backward_panel_all(const Entry* l, const Panel& panel, const double* inverse,
                                   int row, double* w) {
  const auto stride = static_cast<std::size_t>(panel.stride);
  int j = panel.columns;
  for (; j % width != 0; --j)
    backward_block_all<1, Packs, Lanes>(l, stride, j - 1, panel.rows, inverse, row, w);
  for (; j > 0; j -= width)
    backward_block_all<width, Packs, Lanes>(l, stride, j - width, panel.rows, inverse, row, w);
}

/// `Packs` of `Lanes` are what the registers hold; a panel is in the cache when the next ones come.
template <int Packs, int Lanes, class Entry>
HVI_INLINE void backward_solve_all(const TriangularSolve<Entry>& solve, int row, double* x) {
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(row);
  for (auto panel = solve.panels.rbegin(); panel != solve.panels.rend(); ++panel) {
    double* w = solve.work;
    double* own = x + static_cast<std::ptrdiff_t>(panel->first) * row;
    const int beneath = panel->rows - panel->columns;
    const int* place = solve.below + panel->below;
    const Entry* l = solve.values + panel->values;
    const double* inverse = solve.inverse_diagonal + panel->first;
    std::memcpy(w, own, bytes * static_cast<std::size_t>(panel->columns));
    for (int i = 0; i < beneath; ++i) {
      const double* from = x + static_cast<std::ptrdiff_t>(place[i]) * row;
      double* to = w + (panel->columns + i) * row;
      for (int r = 0; r < row; r += Lanes) {
        Pack<Lanes> pack;
        load<Lanes>(from + r, pack);
        std::memcpy(to + r, &pack, sizeof pack);
      }
    }
    int r = 0;
    for (; r + Packs * Lanes <= row; r += Packs * Lanes)
      backward_panel_all<Packs, Lanes>(l, *panel, inverse, row, w + r);
    for (; r < row; r += Lanes) backward_panel_all<1, Lanes>(l, *panel, inverse, row, w + r);
    std::memcpy(own, w, bytes * static_cast<std::size_t>(panel->columns));
  }
}

/// One right-hand side, or several with packs of 4, or of 8.
template <int Lanes, class Entry>
HVI_INLINE void forward_any(const TriangularSolve<Entry>& s, int stride, double* y) {
  if (stride == 1) return forward_solve<Lanes>(s, y);
  forward_solve_all<2, Lanes>(s, stride, y);
}
template <int Lanes, class Entry>
HVI_INLINE void backward_any(const TriangularSolve<Entry>& s, int stride, double* x) {
  if (stride == 1) return backward_solve<Lanes>(s, x);
  backward_solve_all<2, Lanes>(s, stride, x);
}

} // namespace hvi::solver::supernode_kernels
