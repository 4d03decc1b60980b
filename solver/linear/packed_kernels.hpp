// The sweeps of packed_factor.cpp, which includes this file once per instruction set: the
// arithmetic is compiled for the set that the pragma there names, in a namespace of its own.

typedef double Pack __attribute__((vector_size(lanes * sizeof(double))));
typedef float SinglePack __attribute__((vector_size(lanes * sizeof(float))));

HVI_INLINE Pack load(const double* from) {
  Pack to;
  std::memcpy(&to, from, sizeof to);
  return to;
}
HVI_INLINE void store(const Pack& from, double* to) { std::memcpy(to, &from, sizeof from); }

/// Floats between what is used and what is asked for from memory: processors foresee streams within
/// a page only.
constexpr int ahead = 1024;

/// Eight floats as doubles. (GCC splits the conversion of vectors at 16 bytes.)
HVI_INLINE Pack widen(const float* from) {
#ifdef HVI_WIDEN_512
  return Pack(_mm512_maskz_cvtps_pd(0xff, _mm256_loadu_ps(from))); // plain, GCC 12 warns of it
#else
  SinglePack single;
  std::memcpy(&single, from, sizeof single);
  return __builtin_convertvector(single, Pack);
#endif
}

/// w[0 .. 8 tiles) -= tiles times t
template <int Width>
HVI_INLINE void subtract_tiles(const float* tile, int count, const double* t, double* w) {
  for (; count > 0; --count, tile += lanes * Width, w += lanes) {
    Pack sum[2] = {load(w), Pack{}};
#pragma GCC unroll 8
    for (int a = 0; a < Width; a += 2) __builtin_prefetch(tile + lanes * a + ahead);
#pragma GCC unroll 8
    for (int a = 0; a < Width; ++a) sum[a % 2] -= widen(tile + lanes * a) * t[a];
    if constexpr (Width > 1) sum[0] += sum[1];
    store(sum[0], w);
  }
}

/// t := triangle^-1 t
template <int Width>
HVI_INLINE void solve_triangle(const float* inverse, double* t) {
  if constexpr (Width == 8) {
    Pack sum[2] = {};
#pragma GCC unroll 8
    for (int a = 0; a < 8; ++a) sum[a % 2] += widen(inverse + 8 * a) * t[a];
    store(sum[0] + sum[1], t);
  } else {
#pragma GCC unroll 4
    for (int a = Width - 1; a > 0; --a)
#pragma GCC unroll 4
      for (int b = 0; b < a; ++b) t[a] += static_cast<double>(inverse[b * Width + a]) * t[b];
  }
}

/// Sums of the lanes of eight packs, one lane each.
HVI_INLINE Pack sum_lanes(const Pack* s) {
  Pack half[4], quarter[2];
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k)
    half[k] = __builtin_shufflevector(s[2 * k], s[2 * k + 1], 0, 1, 2, 3, 8, 9, 10, 11) +
              __builtin_shufflevector(s[2 * k], s[2 * k + 1], 4, 5, 6, 7, 12, 13, 14, 15);
#pragma GCC unroll 2
  for (int k = 0; k < 2; ++k)
    quarter[k] = __builtin_shufflevector(half[2 * k], half[2 * k + 1], 0, 1, 4, 5, 8, 9, 12, 13) +
                 __builtin_shufflevector(half[2 * k], half[2 * k + 1], 2, 3, 6, 7, 10, 11, 14, 15);
  return __builtin_shufflevector(quarter[0], quarter[1], 0, 2, 4, 6, 8, 10, 12, 14) +
         __builtin_shufflevector(quarter[0], quarter[1], 1, 3, 5, 7, 9, 11, 13, 15);
}

HVI_INLINE double sum_of(const Pack& s) {
  return ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]));
}

/// t := triangle^-T (t - tiles^T w); from the last tile to the first, as the sweep reads backward.
template <int Width>
HVI_INLINE void solve_block_back(const float* block, int count, double* t) {
  Pack sum[Width] = {};
  for (int tile = count - 1; tile >= 0; --tile) {
    const float* from = block + Width * Width + tile * lanes * Width;
    const Pack other = load(t + Width + tile * lanes);
#pragma GCC unroll 8
    for (int a = 0; a < Width; a += 2) __builtin_prefetch(from + lanes * a - ahead);
#pragma GCC unroll 8
    for (int a = 0; a < Width; ++a) sum[a] += widen(from + lanes * a) * other;
  }
  if constexpr (Width == 8) {
    const Pack value = load(t) - sum_lanes(sum);
#pragma GCC unroll 8
    for (int a = 0; a < 8; ++a) sum[a] = widen(block + 8 * a) * value;
    store(sum_lanes(sum), t);
  } else {
    for (int a = 0; a < Width; ++a) t[a] -= sum_of(sum[a]);
    for (int a = 0; a < Width; ++a) // row b of the triangle's inverse is below row a
      for (int b = a + 1; b < Width; ++b) t[a] += static_cast<double>(block[a * Width + b]) * t[b];
  }
}

template <int Width>
HVI_INLINE const float* forward_block(const float* block, int below, double* t) {
  const int tiles = (below + lanes - 1) / lanes;
  solve_triangle<Width>(block, t);
  subtract_tiles<Width>(block + Width * Width, tiles, t, t + Width);
  return block + Width * Width + tiles * lanes * Width;
}

HVI_INLINE void forward_panel(const float* block, const Panel& panel, double* w) {
  int j = 0;
  for (; j + 8 <= panel.columns; j += 8) block = forward_block<8>(block, panel.rows - j - 8, w + j);
  if (panel.columns - j >= 4) {
    block = forward_block<4>(block, panel.rows - j - 4, w + j);
    j += 4;
  }
  if (panel.columns - j >= 2) {
    block = forward_block<2>(block, panel.rows - j - 2, w + j);
    j += 2;
  }
  if (panel.columns - j >= 1) forward_block<1>(block, panel.rows - j - 1, w + j);
}

template <int Width>
HVI_INLINE const float* backward_block(const float* end, int below, double* t) {
  const int tiles = (below + lanes - 1) / lanes;
  const float* block = end - (Width * Width + tiles * lanes * Width);
  solve_block_back<Width>(block, tiles, t);
  return block;
}

/// `end`: behind the panel's values.
HVI_INLINE void backward_panel(const float* end, const Panel& panel, double* w) {
  int j = panel.columns;
  if (j % 2 != 0) {
    end = backward_block<1>(end, panel.rows - j, w + j - 1);
    j -= 1;
  }
  if (j % 4 != 0) {
    end = backward_block<2>(end, panel.rows - j, w + j - 2);
    j -= 2;
  }
  if (j % 8 != 0) {
    end = backward_block<4>(end, panel.rows - j, w + j - 4);
    j -= 4;
  }
  for (; j > 0; j -= 8) end = backward_block<8>(end, panel.rows - j, w + j - 8);
}

void forward_sweep(const Sweep& sweep, double* y) {
  const float* block = sweep.values;
  double* w = sweep.work;
  for (std::size_t p = 0; p < sweep.panels.size(); ++p) {
    const Panel& panel = sweep.panels[p];
    const int beneath = panel.rows - panel.columns;
    const int* row = sweep.below + panel.below;
    for (int j = 0; j < panel.columns; ++j) w[j] = y[panel.first + j];
    for (int i = 0; i < beneath + lanes; ++i) w[panel.columns + i] = 0.0;
    forward_panel(block, panel, w);
    block = sweep.values + sweep.end[p];
    const double* scale = sweep.inverse_square + panel.first;
    for (int j = 0; j < panel.columns; ++j) y[panel.first + j] = w[j] * scale[j];
    for (int i = 0; i < beneath; ++i) y[row[i]] += w[panel.columns + i];
  }
}

void backward_sweep(const Sweep& sweep, const double* y, double* x) {
  double* w = sweep.work;
  for (std::size_t p = sweep.panels.size(); p-- > 0;) {
    const Panel& panel = sweep.panels[p];
    const int beneath = panel.rows - panel.columns;
    const int* row = sweep.below + panel.below;
    for (int j = 0; j < panel.columns; ++j) w[j] = y[panel.first + j];
    for (int i = 0; i < beneath; ++i) w[panel.columns + i] = x[row[i]];
    for (int i = 0; i < lanes; ++i) w[panel.rows + i] = 0.0;
    backward_panel(sweep.values + sweep.end[p], panel, w);
    for (int j = 0; j < panel.columns; ++j) x[panel.first + j] = w[j];
  }
}
