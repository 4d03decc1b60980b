// Packing and the triangular solves of packed_factor.cpp, which includes this file once per
// instruction set: the arithmetic is compiled for the set that the pragma there names, in a
// namespace of its own.

typedef double Pack __attribute__((vector_size(lanes * sizeof(double))));
typedef float SinglePack __attribute__((vector_size(lanes * sizeof(float))));

HVI_INLINE Pack load(const double* from) {
  Pack to;
  std::memcpy(&to, from, sizeof to);
  return to;
}
HVI_INLINE void store(const Pack& from, double* to) { std::memcpy(to, &from, sizeof from); }

/// How many entries ahead of use memory is prefetched: processors foresee streams within a page
/// only.
constexpr int ahead = 1024;

/// A place in the streams.
template <bool Fine>
struct Entries {
  const float* values;
  const std::int16_t* rests;

  HVI_INLINE Entries operator+(std::ptrdiff_t by) const {
    if constexpr (Fine) return {values + by, rests + by};
    return {values + by, nullptr};
  }
  HVI_INLINE void prefetch(std::ptrdiff_t by) const { __builtin_prefetch(values + by); }
  template <int Count>
  HVI_INLINE void prefetch_rests(std::ptrdiff_t by) const {
    if constexpr (Fine)
#pragma GCC unroll 2
      for (int k = 0; k < Count; k += 32) __builtin_prefetch(rests + k + by);
  }
};

/// One entry as a double.
template <bool Fine>
HVI_INLINE double entry(const Entries<Fine>& at) {
  double v = *at.values;
  if constexpr (Fine) {
    std::int64_t bits;
    std::memcpy(&bits, &v, sizeof bits);
    bits += static_cast<std::int64_t>(*at.rests) * (std::int64_t{1} << rest_shift);
    std::memcpy(&v, &bits, sizeof v);
  }
  return v;
}

/// Eight entries as doubles. (GCC splits conversions of vectors at 16 bytes, hence intrinsics.)
template <bool Fine>
HVI_INLINE Pack widen(const Entries<Fine>& from) {
#if defined(HVI_PACKED_512)
  const auto v = _mm512_maskz_cvtps_pd(0xff, _mm256_loadu_ps(from.values)); // plain, GCC 12 warns
  if constexpr (!Fine) return Pack(v);
  const auto rest = _mm512_maskz_cvtepi16_epi64(
      0xff, _mm_loadu_si128(reinterpret_cast<const __m128i*>(from.rests)));
  return Pack(_mm512_castsi512_pd(
      _mm512_add_epi64(_mm512_castpd_si512(v), _mm512_maskz_slli_epi64(0xff, rest, rest_shift))));
#elif defined(HVI_PACKED_256)
  __m256d half[2];
#pragma GCC unroll 2
  for (int k = 0; k < 2; ++k) {
    half[k] = _mm256_cvtps_pd(_mm_loadu_ps(from.values + 4 * k));
    if constexpr (Fine) {
      const auto rest = _mm256_cvtepi16_epi64(
          _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from.rests + 4 * k)));
      half[k] = _mm256_castsi256_pd(
          _mm256_add_epi64(_mm256_castpd_si256(half[k]), _mm256_slli_epi64(rest, rest_shift)));
    }
  }
  Pack out;
  std::memcpy(&out, half, sizeof out);
  return out;
#else
  Pack out;
#pragma GCC unroll 8
  for (int k = 0; k < lanes; ++k) out[k] = entry(from + k);
  return out;
#endif
}

/// w[0 .. 8 tiles) -= tiles times t
template <int Width, bool Fine>
HVI_INLINE void subtract_tiles(Entries<Fine> tile, int count, const double* t, double* w) {
  for (; count > 0; --count, tile = tile + lanes * Width, w += lanes) {
    Pack sum[2] = {load(w), Pack{}};
#pragma GCC unroll 8
    for (int a = 0; a < Width; a += 2) tile.prefetch(lanes * a + ahead);
    tile.template prefetch_rests<lanes * Width>(ahead);
#pragma GCC unroll 8
    for (int a = 0; a < Width; ++a) sum[a % 2] -= widen(tile + lanes * a) * t[a];
    if constexpr (Width > 1) sum[0] += sum[1];
    store(sum[0], w);
  }
}

/// t := triangle^-1 t
template <int Width, bool Fine>
HVI_INLINE void solve_triangle(const Entries<Fine>& inverse, double* t) {
  if constexpr (Width == 8) {
    Pack sum[2] = {};
#pragma GCC unroll 8
    for (int a = 0; a < 8; ++a) sum[a % 2] += widen(inverse + 8 * a) * t[a];
    store(sum[0] + sum[1], t);
  } else {
#pragma GCC unroll 4
    for (int a = Width - 1; a > 0; --a)
#pragma GCC unroll 4
      for (int b = 0; b < a; ++b) t[a] += entry(inverse + (b * Width + a)) * t[b];
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

/// t := triangle^-T (t - tiles^T w); from the last tile to the first: the backward solve reads the
/// stream backward.
template <int Width, bool Fine>
HVI_INLINE void solve_block_back(const Entries<Fine>& block, int count, double* t) {
  Pack sum[Width] = {};
  for (int tile = count - 1; tile >= 0; --tile) {
    const auto from = block + (Width * Width + tile * lanes * Width);
    const Pack other = load(t + Width + tile * lanes);
#pragma GCC unroll 8
    for (int a = 0; a < Width; a += 2) from.prefetch(lanes * a - ahead);
    from.template prefetch_rests<lanes * Width>(-ahead);
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
      for (int b = a + 1; b < Width; ++b) t[a] += entry(block + (a * Width + b)) * t[b];
  }
}

template <int Width, bool Fine>
HVI_INLINE Entries<Fine> forward_block(const Entries<Fine>& block, int below, double* t) {
  const int tiles = (below + lanes - 1) / lanes;
  solve_triangle<Width>(block, t);
  subtract_tiles<Width>(block + Width * Width, tiles, t, t + Width);
  return block + (Width * Width + tiles * lanes * Width);
}

template <bool Fine>
HVI_INLINE void forward_panel(Entries<Fine> block, const Panel& panel, double* w) {
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

template <int Width, bool Fine>
HVI_INLINE Entries<Fine> backward_block(const Entries<Fine>& end, int below, double* t) {
  const int tiles = (below + lanes - 1) / lanes;
  const auto block = end + -(Width * Width + tiles * lanes * Width);
  solve_block_back<Width>(block, tiles, t);
  return block;
}

/// `end`: behind the panel's values.
template <bool Fine>
HVI_INLINE void backward_panel(Entries<Fine> end, const Panel& panel, double* w) {
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

template <bool Fine>
void forward_solve(const PackedSolve& solve, double* y) {
  Entries<Fine> first{solve.values, solve.rests}, block = first;
  double* w = solve.work;
  for (std::size_t p = 0; p < solve.panels.size(); ++p) {
    const Panel& panel = solve.panels[p];
    const int beneath = panel.rows - panel.columns;
    const int* row = solve.below + panel.below;
    for (int j = 0; j < panel.columns; ++j) w[j] = y[panel.first + j];
    for (int i = 0; i < beneath + lanes; ++i) w[panel.columns + i] = 0.0;
    forward_panel(block, panel, w);
    block = first + static_cast<std::ptrdiff_t>(solve.end[p]);
    const double* scale = solve.inverse_square + panel.first;
    for (int j = 0; j < panel.columns; ++j) y[panel.first + j] = w[j] * scale[j];
    for (int i = 0; i < beneath; ++i) y[row[i]] += w[panel.columns + i];
  }
}

template <bool Fine>
void backward_solve(const PackedSolve& solve, double* x) {
  const Entries<Fine> first{solve.values, solve.rests};
  double* w = solve.work;
  for (std::size_t p = solve.panels.size(); p-- > 0;) {
    const Panel& panel = solve.panels[p];
    const int beneath = panel.rows - panel.columns;
    const int* row = solve.below + panel.below;
    for (int j = 0; j < panel.columns; ++j) w[j] = x[panel.first + j];
    for (int i = 0; i < beneath; ++i) w[panel.columns + i] = x[row[i]];
    for (int i = 0; i < lanes; ++i) w[panel.rows + i] = 0.0;
    backward_panel(first + static_cast<std::ptrdiff_t>(solve.end[p]), panel, w);
    for (int j = 0; j < panel.columns; ++j) x[panel.first + j] = w[j];
  }
}

/// Writes eight entries; `sound` stays zero while they are finite.
HVI_INLINE void write(Pack v, float* values, std::int16_t* rests, Pack& sound) {
#if defined(HVI_PACKED_512)
  auto in = __m512d(v);
  const auto small = _mm512_cmp_pd_mask(_mm512_abs_pd(in), _mm512_set1_pd(negligible), _CMP_LT_OQ);
  in = _mm512_mask_mov_pd(in, small, _mm512_setzero_pd());
  const auto value = _mm512_maskz_cvtpd_ps(0xff, in);
  _mm256_storeu_ps(values, value);
  const auto widened = _mm512_maskz_cvtps_pd(0xff, value);
  sound += Pack(widened) * 0.0;
  auto bits = _mm512_sub_epi64(_mm512_castpd_si512(in), _mm512_castpd_si512(widened));
  bits = _mm512_add_epi64(bits, _mm512_set1_epi64(std::int64_t{1} << (rest_shift - 1)));
  bits = _mm512_maskz_srai_epi64(0xff, bits, rest_shift);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(rests), _mm512_maskz_cvtsepi64_epi16(0xff, bits));
#else
  for (int k = 0; k < lanes; ++k) {
    split(v[k], values[k], rests[k]);
    sound[k] += static_cast<double>(values[k]) * 0.0;
  }
#endif
}

/// The inverse of the unit lower triangle of a block, by columns; `scale`: over the diagonal.
template <int Width>
HVI_INLINE void invert_triangle(const double* column, std::size_t stride, const double* scale,
                                double* inverse) {
  for (int a = 0; a < Width; ++a) {
    for (int i = 0; i < a; ++i) inverse[a * Width + i] = 0.0;
    inverse[a * Width + a] = 1.0;
    for (int i = a + 1; i < Width; ++i) {
      double sum = 0.0;
      for (int b = a; b < i; ++b) sum += column[b * stride + i] * scale[b] * inverse[a * Width + b];
      inverse[a * Width + i] = -sum;
    }
  }
}

/// Writes one block; `column` points at the top of its triangle.
template <int Width>
HVI_INLINE void pack_block(const double* column, std::size_t stride, int below, Packing& out,
                           Pack& sound) {
  double scale[Width], inverse[Width * Width];
  for (int a = 0; a < Width; ++a) {
    scale[a] = 1.0 / column[a * (stride + 1)];
    *out.inverse_square++ = scale[a] * scale[a];
  }
  invert_triangle<Width>(column, stride, scale, inverse);
  for (int at = 0; at < Width * Width; ++at) {
    split(inverse[at], *out.values, *out.rests++);
    sound[0] += static_cast<double>(*out.values++) * 0.0;
  }
  const double* from = column + Width;
  for (; below >= lanes; below -= lanes, from += lanes)
#pragma GCC unroll 8
    for (int a = 0; a < Width; ++a) {
      write(load(from + a * stride) * scale[a], out.values, out.rests, sound);
      out.values += lanes, out.rests += lanes;
    }
  for (int a = 0; below > 0 && a < Width; ++a) {
    double last[lanes] = {};
    for (int i = 0; i < below; ++i) last[i] = from[a * stride + i] * scale[a];
    write(load(last), out.values, out.rests, sound);
    out.values += lanes, out.rests += lanes;
  }
}

void pack_panels(std::span<const Panel> panels, const double* values, Packing& out) {
  Pack sound = {};
  for (const Panel& panel : panels) {
    const auto stride = static_cast<std::size_t>(panel.stride);
    const double* top = values + panel.values;
    int j = 0;
    for (; j + 8 <= panel.columns; j += 8)
      pack_block<8>(top + j * (stride + 1), stride, panel.rows - j - 8, out, sound);
    if (panel.columns - j >= 4) {
      pack_block<4>(top + j * (stride + 1), stride, panel.rows - j - 4, out, sound);
      j += 4;
    }
    if (panel.columns - j >= 2) {
      pack_block<2>(top + j * (stride + 1), stride, panel.rows - j - 2, out, sound);
      j += 2;
    }
    if (panel.columns - j >= 1)
      pack_block<1>(top + j * (stride + 1), stride, panel.rows - j - 1, out, sound);
  }
  out.finite = sum_of(sound) == 0.0;
}
