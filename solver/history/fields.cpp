// Loops over stored fields. Blocked over the points: `out` and `u` stay in the first-level cache
// while the states are read once.
#include "solver/history/fields.hpp"

#include <cblas.h>

#include <algorithm>

namespace hvi::solver {

namespace {

constexpr std::size_t values_at_once = 1024;

/// out += sum over W fields at stride n.
template <std::size_t W>
void add_some(const double* __restrict w, const double* __restrict f, std::size_t n,
              std::size_t count, double* __restrict out) {
  for (std::size_t i = 0; i < count; ++i) {
    double sum = out[i];
    for (std::size_t k = 0; k < W; ++k) sum += w[k] * f[k * n + i];
    out[i] = sum;
  }
}

struct Points {
  std::size_t from, count, n;
};

/// Scalar states, W at once: z = a z + b u [+ c u_before], out += r z.
template <std::size_t W, bool Affine>
void advance_scalars(const LinearGroup* groups, double* __restrict z, const Points& points,
                     const double* __restrict u, const double* __restrict v,
                     double* __restrict out) {
  double a[W], b[W], c[W], r[W];
  for (std::size_t k = 0; k < W; ++k) {
    a[k] = groups[k].transition[0];
    b[k] = groups[k].input[0];
    c[k] = Affine ? groups[k].input_before[0] : 0.0;
    r[k] = groups[k].readout[0];
  }
  const std::size_t n = points.n;
  for (std::size_t i = points.from; i < points.from + points.count; ++i) {
    double sum = out[i];
    for (std::size_t k = 0; k < W; ++k) {
      double value = a[k] * z[k * n + i] + b[k] * u[i];
      if constexpr (Affine) value += c[k] * v[i];
      z[k * n + i] = value;
      sum += r[k] * value;
    }
    out[i] = sum;
  }
}

/// A pair of states (a complex exponential).
template <bool Affine>
void advance_pair(const LinearGroup& g, double* __restrict z, double* __restrict y,
                  const Points& points, const double* __restrict u, const double* __restrict v,
                  double* __restrict out) {
  const double a = g.transition[0], b = g.transition[1], c = g.transition[2], d = g.transition[3];
  const double i0 = g.input[0], i1 = g.input[1], r0 = g.readout[0], r1 = g.readout[1];
  const double p0 = Affine ? g.input_before[0] : 0.0, p1 = Affine ? g.input_before[1] : 0.0;
  for (std::size_t i = points.from; i < points.from + points.count; ++i) {
    double first = a * z[i] + b * y[i] + i0 * u[i];
    double second = c * z[i] + d * y[i] + i1 * u[i];
    if constexpr (Affine) {
      first += p0 * v[i];
      second += p1 * v[i];
    }
    z[i] = first;
    y[i] = second;
    // One after the other, as read_states adds them: a repeated step gives the same bits.
    out[i] = (out[i] + r0 * first) + r1 * second;
  }
}

/// Any dimension (polynomials times exponentials).
void advance_any(const LinearGroup& g, double* z, const Points& points, const double* u,
                 const double* v, double* out) {
  const std::size_t d = g.dimension;
  std::vector<double> old(d);
  for (std::size_t i = points.from; i < points.from + points.count; ++i) {
    for (std::size_t k = 0; k < d; ++k) old[k] = z[k * points.n + i];
    double sum = out[i];
    for (std::size_t k = 0; k < d; ++k) {
      double value = g.input[k] * u[i] + (v ? g.input_before[k] * v[i] : 0.0);
      for (std::size_t l = 0; l < d; ++l) value += g.transition[k * d + l] * old[l];
      z[k * points.n + i] = value;
      sum += g.readout[k] * value;
    }
    out[i] = sum;
  }
}

template <bool Affine>
void advance_block(std::span<const LinearGroup> groups, double* states, const Points& points,
                   const double* u, const double* v, double* out) {
  const std::size_t n = points.n;
  for (std::size_t g = 0; g < groups.size();) {
    const std::size_t d = groups[g].dimension;
    const auto scalars = [&](std::size_t count) {
      return g + count <= groups.size() &&
             std::all_of(groups.begin() + g, groups.begin() + g + count,
                         [](const LinearGroup& group) { return group.dimension == 1; });
    };
    std::size_t used = 1;
    if (scalars(4)) {
      advance_scalars<4, Affine>(&groups[g], states, points, u, v, out);
      used = 4;
    } else if (d == 1) {
      advance_scalars<1, Affine>(&groups[g], states, points, u, v, out);
    } else if (d == 2) {
      advance_pair<Affine>(groups[g], states, states + n, points, u, v, out);
    } else {
      advance_any(groups[g], states, points, u, v, out);
    }
    for (std::size_t k = 0; k < used; ++k) states += groups[g + k].dimension * n;
    g += used;
  }
}

} // namespace

void FieldQueue::push(std::span<const double> field) {
  values_.insert(values_.end(), field.begin(), field.end());
  ++count_;
}

void FieldQueue::drop(std::size_t count) {
  first_ += count;
  count_ -= count;
  if (first_ > count_ + 1) {
    values_.erase(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(first_ * n_));
    first_ = 0;
  }
}

void FieldQueue::clear() {
  values_ = {};
  first_ = count_ = 0;
}

std::vector<double> FieldQueue::packed() const { return {data(), data() + count_ * n_}; }

void FieldQueue::unpack(std::vector<double> values) {
  values_ = std::move(values);
  first_ = 0;
  count_ = n_ == 0 ? 0 : values_.size() / n_;
}

void add_combinations(std::span<const Combination> parts, std::span<double> out) {
  const std::size_t n = out.size();
  for (std::size_t from = 0; from < n; from += values_at_once) {
    const std::size_t points = std::min(values_at_once, n - from);
    double* target = out.data() + from;
    for (const Combination& part : parts) {
      const double* source = part.fields + from;
      const std::size_t count = part.weights.size();
      std::size_t f = 0;
      for (; f + 8 <= count; f += 8)
        add_some<8>(&part.weights[f], source + f * n, n, points, target);
      for (; f < count; ++f) add_some<1>(&part.weights[f], source + f * n, n, points, target);
    }
  }
}

void add_combination(std::span<const double> weights, const double* fields, std::span<double> out) {
  const Combination part{weights, fields};
  add_combinations({&part, 1}, out);
}

void add_columns(std::span<const double> weights, const double* fields, std::size_t count,
                 std::size_t n, std::span<double> out) {
  if (n == 0 || count == 0) return;
  const auto whole = [](std::size_t value) { return static_cast<blasint>(value); };
  const std::size_t columns = out.size() / n;
  // Rows in blocks: those of `out` stay in the second-level cache.
  for (std::size_t from = 0; from < n; from += values_at_once / 2) {
    const std::size_t rows = std::min(values_at_once / 2, n - from);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, whole(rows), whole(columns),
                whole(count), 1.0, fields + from, whole(n), weights.data(), whole(count), 1.0,
                out.data() + from, whole(n));
  }
}

void set_scaled(double w, std::span<const double> a, std::span<double> out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = w * a[i];
}

void advance_and_read(std::span<const LinearGroup> groups, std::span<double> states,
                      std::span<const double> u, std::span<const double> u_before,
                      std::span<double> out) {
  const std::size_t n = out.size();
  for (std::size_t from = 0; from < n; from += values_at_once) {
    const Points points{from, std::min(values_at_once, n - from), n};
    if (u_before.empty()) {
      advance_block<false>(groups, states.data(), points, u.data(), nullptr, out.data());
    } else {
      advance_block<true>(groups, states.data(), points, u.data(), u_before.data(), out.data());
    }
  }
}

void read_states(std::span<const LinearGroup> groups, std::span<const double> states,
                 std::span<double> out) {
  std::vector<double> weights;
  for (const LinearGroup& g : groups) {
    weights.insert(weights.end(), g.readout.begin(), g.readout.end());
  }
  add_combination(weights, states.data(), out);
}

} // namespace hvi::solver
