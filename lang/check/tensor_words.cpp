// See tensor_words.hpp.
#include "lang/check/tensor_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace hvi::lang {

namespace {

constexpr double rounding = 1e-10;

bool near(double a, double b, double size) { return std::abs(a - b) <= rounding * size; }

/// The entries as numbers, in the order of the field.
std::optional<std::vector<double>>
entries_at(const Field& kernel, const Symbol& factor,
           const std::function<double(solver::Slot)>& variables) {
  const double share = solver::evaluate(factor, variables);
  if (!std::isfinite(share) || share == 0.0) return std::nullopt;
  std::vector<double> out;
  for (const Symbol& entry : kernel.components) {
    if (entry.depends_on_any(solver::slot::x(0), solver::slot::x(2) + 1)) return std::nullopt;
    out.push_back(solver::evaluate(entry, variables) / share);
  }
  return out;
}

/// Lamé's constants, where all entries are made of them.
std::optional<std::pair<double, double>> isotropic(const std::vector<double>& c, int d,
                                                   double size) {
  const auto at = [&](int i, int j, int k, int l) {
    return c[static_cast<std::size_t>(((i * d + j) * d + k) * d + l)];
  };
  const double lambda = at(0, 0, 1, 1), mu = at(0, 1, 0, 1);
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      for (int k = 0; k < d; ++k)
        for (int l = 0; l < d; ++l) {
          const double sum = (i == j && k == l ? lambda : 0.0) + (i == k && j == l ? mu : 0.0) +
                             (i == l && j == k ? mu : 0.0);
          if (!near(at(i, j, k, l), sum, size)) return std::nullopt;
        }
  return std::pair(lambda, mu);
}

/// One of each group of entries that minor and major symmetry make equal, if it is not zero.
std::string by_places(const std::vector<double>& c, int rank, int d, double size) {
  std::string out;
  const auto name = [&](int pair) { return fmt::format("{}{}", "xyz"[pair / d], "xyz"[pair % d]); };
  const int pairs = d * d;
  for (int a = 0; a < (rank == 4 ? pairs : 1); ++a)
    for (int b = rank == 4 ? a : 0; b < pairs; ++b) {
      const bool again = a / d > a % d || b / d > b % d;
      const double value = c[static_cast<std::size_t>(a * pairs + b)];
      if (again || near(value, 0.0, size)) continue;
      out += fmt::format("{}{}{} = {:.4g}", out.empty() ? "" : ", ", rank == 4 ? name(a) : "",
                         name(b), value);
    }
  return "(" + out + ")";
}

} // namespace

std::string tensor_beside(const Field& kernel, const Symbol& factor,
                          const std::vector<std::function<double(solver::Slot)>>& variables) {
  if (kernel.rank != 2 && kernel.rank != 4) return {};
  std::optional<std::vector<double>> tensor;
  double size = 0.0;
  for (const auto& values : variables) {
    const auto here = entries_at(kernel, factor, values);
    if (!here) return {};
    if (!tensor) tensor = here;
    for (const double entry : *tensor) size = std::max(size, std::abs(entry));
    for (std::size_t i = 0; i < here->size(); ++i)
      if (!near((*here)[i], (*tensor)[i], size)) return {};
  }
  if (!tensor || size == 0.0) return {};
  const int d = kernel.rows;
  if (kernel.rank == 4 && d > 1)
    if (const auto lame = isotropic(*tensor, d, size))
      return fmt::format("isotropic(\u03bb = {:.4g}, \u03bc = {:.4g})", lame->first, lame->second);
  return by_places(*tensor, kernel.rank, d, size);
}

} // namespace hvi::lang
