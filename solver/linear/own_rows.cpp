// See own_rows.hpp.
#include "solver/linear/own_rows.hpp"

#include "solver/linear/double_double.hpp"
#include "solver/linear/same_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::solver {
namespace {

/// Has every row an entry on the diagonal?
bool has_diagonal(const SparseMatrix& a) {
  for (int i = 0; i < a.rows(); ++i) {
    const int* const begin = a.innerIndexPtr() + a.outerIndexPtr()[i];
    const int* const end = a.innerIndexPtr() + a.outerIndexPtr()[i + 1];
    if (!std::binary_search(begin, end, i)) return false;
  }
  return true;
}

/// Entries where any of them has one, and on the diagonal.
SparseMatrix pattern_of_all(const std::vector<SparseMatrix>& matrices) {
  SparseMatrix out = matrices.front();
  for (const SparseMatrix& one : matrices)
    if (!same_pattern(out, one)) out = SparseMatrix(out + one);
  if (has_diagonal(out)) return out;
  SparseMatrix diagonal(out.rows(), out.cols());
  for (int i = 0; i < out.rows(); ++i) diagonal.insert(i, i) = 0.0;
  return SparseMatrix(out + diagonal);
}

} // namespace

OwnRows::OwnRows(std::vector<SparseMatrix> bases, PlacedRows placed)
    : bases_(static_cast<int>(bases.size())), placed_(std::move(placed)) {
  const SparseMatrix pattern = pattern_of_all(bases);
  start_.assign(pattern.outerIndexPtr(), pattern.outerIndexPtr() + pattern.rows() + 1);
  column_.assign(pattern.innerIndexPtr(), pattern.innerIndexPtr() + pattern.nonZeros());
  for (int i = 0; i < rows(); ++i) {
    const auto begin = column_.begin() + start_[i], end = column_.begin() + start_[i + 1];
    own_.push_back(static_cast<int>(std::lower_bound(begin, end, i) - column_.begin()));
  }
  for (int b = 0; b < bases_; ++b) {
    SparseMatrix& base = bases[static_cast<std::size_t>(b)];
    values_[b] = values_of(base);
    SparseMatrix().swap(base);
  }
}

/// At the entries of the pattern, which has all of its.
std::vector<double> OwnRows::values_of(const SparseMatrix& matrix) const {
  std::vector<double> out(column_.size(), 0.0);
  for (int i = 0; i < matrix.rows(); ++i) {
    int at = start_[i];
    for (SparseMatrix::InnerIterator it(matrix, i); it; ++it, ++at) {
      while (column_[at] < it.col()) ++at;
      out[static_cast<std::size_t>(at)] = it.value();
    }
  }
  return out;
}

void OwnRows::replace(int b, const SparseMatrix& base) { values_[b] = values_of(base); }

/// Four sums at a time: one would wait for its own last addition.
void OwnRows::products(int a, std::span<const double> x, std::span<double> out) const {
  const double* const value = values(a).data();
  const int* const column = column_.data();
  double *product = out.data(), *whole = product + rows();
  for (int i = 0; i < rows(); ++i) {
    double sum[4] = {}, largest[4] = {};
    const int end = start_[i + 1];
    int e = start_[i];
    for (; e + 4 <= end; e += 4)
      for (int k = 0; k < 4; ++k) {
        const double of = x[column[e + k]];
        sum[k] += value[e + k] * of;
        largest[k] = std::max(largest[k], std::abs(of));
      }
    for (; e < end; ++e) {
      sum[0] += value[e] * x[column[e]];
      largest[0] = std::max(largest[0], std::abs(x[column[e]]));
    }
    product[i] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    whole[i] = std::abs(value[own_[i]]) *
               std::max(std::max(largest[0], largest[1]), std::max(largest[2], largest[3]));
  }
  if (!placed_.of_unknown.empty())
    whole_of_each(a, x, out.subspan(static_cast<std::size_t>(rows())));
}

/// Unknowns have units of their own.
void OwnRows::whole_of_each(int a, std::span<const double> x, std::span<double> whole) const {
  std::ranges::fill(whole, 0.0);
  for_entries(a, [&](int i, int j, double) {
    if (placed_.of_unknown[i] == placed_.of_unknown[j])
      whole[i] = std::max(whole[i], std::abs(x[j]));
  });
  for (int i = 0; i < rows(); ++i) whole[i] *= std::abs(values(a)[own_[i]]);
}

void OwnRows::precisely(int a, std::span<const double> x, std::span<double> out) const {
  const auto n = static_cast<std::size_t>(rows());
  std::vector<DoubleDouble> sums(n);
  const auto sizes = out.subspan(2 * n);
  std::ranges::fill(sizes, 0.0);
  for_entries(a, [&](int i, int j, double value) {
    sums[i].add_product(value, x[j]);
    sizes[i] += std::abs(value * x[j]);
  });
  for (std::size_t i = 0; i < n; ++i) out[i] = sums[i].high, out[n + i] = sums[i].low;
}

void OwnRows::magnitudes(int a, std::span<const double> x, std::span<double> out) const {
  std::ranges::fill(out, 0.0);
  for_entries(a, [&](int i, int j, double value) { out[i] += std::abs(value * x[j]); });
}

void OwnRows::diagonal(int a, std::span<double> out) const {
  for (int i = 0; i < rows(); ++i) out[i] = values(a)[own_[i]];
}

void OwnRows::transposed(int a, std::span<const double> x, std::span<double> out) const {
  std::ranges::fill(out, 0.0);
  const auto sizes = out.subspan(static_cast<std::size_t>(columns()));
  for_entries(a, [&](int i, int j, double value) {
    out[j] += value * x[i];
    sizes[j] += std::abs(value * x[i]);
  });
}

std::vector<double> OwnRows::asymmetry(int a) const {
  std::vector<double> out(2, 0.0);
  const auto mirrored = [&](int i, int j) {
    const auto begin = column_.begin() + start_[j], end = column_.begin() + start_[j + 1];
    const auto at = std::lower_bound(begin, end, i);
    return at != end && *at == i ? values(a)[static_cast<std::size_t>(at - column_.begin())] : 0.0;
  };
  for_entries(a, [&](int i, int j, double value) {
    out[1] = std::max(out[1], std::abs(value));
    if (j < rows())
      out[0] = std::max(out[0], std::abs(value - mirrored(i, j)));
    else if (placed_.column[j] >= 0)
      out.insert(out.end(), {static_cast<double>(i), static_cast<double>(j), value});
  });
  return out;
}

void OwnRows::combine(int a, std::span<const double> gamma) {
  std::vector<double>& sum = values_[a];
  sum.assign(column_.size(), 0.0);
  for (int b = 0; b < bases_; ++b) {
    const std::vector<double>& of = values(b);
    for (std::size_t e = 0; e < sum.size(); ++e) sum[e] += gamma[b] * of[e];
  }
}

void OwnRows::stiffen(int a, std::span<const double> more) {
  std::vector<double>& of = values_[a];
  for (int i = 0; i < rows(); ++i) of[own_[i]] += more[i];
}

void OwnRows::place(int a, double alone) {
  std::vector<int> row_here(static_cast<std::size_t>(placed_.count), -1);
  for (int i = 0; i < rows(); ++i) row_here[placed_.column[i] - placed_.first] = i;
  Placed& to = placed_arrays_[a];
  to = {};
  to.start.reserve(row_here.size() + 1);
  to.column.reserve(column_.size() + row_here.size());
  to.value.reserve(column_.size() + row_here.size());
  to.start.push_back(0);
  std::vector<std::pair<int, double>> row;
  const double* const value = values(a).data();
  for (int p = 0; p < placed_.count; ++p) {
    row.clear();
    const int i = row_here[p];
    if (i < 0)
      row.emplace_back(placed_.first + p, alone);
    else
      for (int e = start_[i]; e < start_[i + 1]; ++e)
        if (const int there = placed_.column[column_[e]]; there >= 0)
          row.emplace_back(there, value[e]);
    std::sort(row.begin(), row.end());
    for (const auto& [column, entry] : row) {
      to.column.push_back(column);
      to.value.push_back(entry);
    }
    to.start.push_back(static_cast<int>(to.column.size()));
  }
}

RowArrays OwnRows::placed(int a) const {
  const Placed& of = placed_arrays_.at(a);
  return {placed_.count, of.start.data(), of.column.data(), of.value.data()};
}

void OwnRows::forget(int a) {
  values_.erase(a);
  placed_arrays_.erase(a);
}

double OwnRows::bytes() const {
  const auto entries = static_cast<double>(column_.size());
  double out = entries * (sizeof(int) + sizeof(double) * static_cast<double>(values_.size()));
  for (const auto& [a, arrays] : placed_arrays_)
    out += static_cast<double>(arrays.column.size()) * (sizeof(double) + sizeof(int));
  return out;
}

} // namespace hvi::solver
