// Piecewise Chebyshev polynomials of an expensive function; see function_table.hpp.
#include "solver/history/function_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hvi::solver {

namespace {

constexpr double agreement = 5e-14; ///< relative: a few roundings of a special function
constexpr std::size_t most_in_octave = 64;

double node(int i, int count) { return std::cos(std::numbers::pi * (i + 0.5) / count); }

} // namespace

FunctionTable::FunctionTable(std::function<double(double)> function)
    : function_(std::move(function)) {}

double FunctionTable::operator()(double x) {
  int exponent = 0;
  std::frexp(x, &exponent);
  if (!std::isfinite(x) || x == 0 || exponent <= -exponents / 2 || exponent > exponents / 2)
    return function_(x);
  const Octave& o = octave(x);
  const auto at = static_cast<std::size_t>(std::max(0.0, (x - o.low) * o.per_length));
  const Piece& p = o.pieces[std::min(at, o.pieces.size() - 1)];
  return p.resolved ? p.value(x) : function_(x);
}

/// C. W. Clenshaw, A note on the summation of Chebyshev series, Math. Tables Aids Comput. 9 (1955)
/// 118-120.
double FunctionTable::Piece::value(double x) const {
  const double y = (x - middle) / half;
  double next = 0, current = 0;
  for (std::size_t k = count - 1; k > 0; --k) {
    const double before = 2 * y * current - next + coefficients[k];
    next = current;
    current = before;
  }
  return y * current - next + coefficients[0];
}

const FunctionTable::Octave& FunctionTable::octave(double x) {
  int exponent = 0;
  std::frexp(x, &exponent); // 2^(exponent - 1) <= |x| < 2^exponent
  Octave& o = octaves_[x < 0 ? 1 : 0][static_cast<std::size_t>(exponent + exponents / 2 - 1)];
  if (!o.pieces.empty()) return o;
  const double low = std::ldexp(1.0, exponent - 1);
  const double from = x < 0 ? -2 * low : low;
  const auto open = [](const Octave& tried) {
    return static_cast<std::size_t>(std::count_if(tried.pieces.begin(), tried.pieces.end(),
                                                  [](const Piece& p) { return !p.resolved; }));
  };
  o = cut(from, from + low, 1);
  for (std::size_t n = 2; n <= most_in_octave && open(o) > 0; n *= 2) o = cut(from, from + low, n);
  pieces_ += o.pieces.size();
  unresolved_ += open(o);
  return o;
}

FunctionTable::Octave FunctionTable::cut(double from, double to, std::size_t pieces) const {
  Octave o{from, static_cast<double>(pieces) / (to - from), {}};
  const double length = (to - from) / static_cast<double>(pieces);
  for (std::size_t i = 0; i < pieces; ++i) {
    const double low = from + static_cast<double>(i) * length;
    o.pieces.push_back(piece(low, low + length));
  }
  return o;
}

FunctionTable::Piece FunctionTable::piece(double from, double to) const {
  Piece p;
  p.middle = 0.5 * (from + to);
  p.half = 0.5 * (to - from);
  for (int i = 0; i < count; ++i) {
    const double value = function_(p.middle + p.half * node(i, count));
    for (int k = 0; k < count; ++k)
      p.coefficients[static_cast<std::size_t>(k)] +=
          (k == 0 ? 1.0 : 2.0) / count * value * std::cos(std::numbers::pi * k * (i + 0.5) / count);
  }
  p.resolved = true;
  for (int i = 0; i <= count && p.resolved; ++i) { // ends included
    const double x = p.middle + p.half * std::cos(std::numbers::pi * i / count);
    const double exact = function_(x);
    p.resolved = std::abs(p.value(x) - exact) <= agreement * std::abs(exact);
  }
  return p;
}

} // namespace hvi::solver
