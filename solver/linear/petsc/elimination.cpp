// See elimination.hpp.
#include "solver/linear/petsc/elimination.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace hvi::petsc_module {
namespace {

/// What decides about the order: of each unknown the components, how much its form has of a mass,
/// what constants give by the diagonal (0 for derivatives), and which others its rows read.
struct Traits {
  std::vector<int> components;
  std::vector<double> mass;
  std::vector<std::vector<char>> reads;
};

/// `unknown`: of each row, -1: none.
Traits traits_of(const WholeMatrix& k, const std::vector<int>& unknown, int rows_of_node,
                 const std::vector<int>& first) {
  Traits out;
  const std::size_t count = first.size() - 1;
  for (std::size_t u = 0; u < count; ++u) out.components.push_back(first[u + 1] - first[u]);
  out.mass.assign(count, 0.0);
  out.reads.assign(count, std::vector<char>(count, 0));
  std::vector<double> diagonals(out.mass);
  WholeMatrix::Room room;
  for (int i = 0; i < k.rows(); ++i) {
    const int u = unknown[i];
    if (u < 0) continue;
    const WholeMatrix::Row row = k.row(i, room);
    double sum = 0.0;
    for (int e = 0; e < row.size; ++e) {
      const int j = row.column[e], other = unknown[j];
      if (other == u && j % rows_of_node == i % rows_of_node) sum += row.value[e];
      if (other >= 0 && other != u && row.value[e] != 0.0) out.reads[u][other] = 1;
    }
    out.mass[u] += std::abs(sum);
    diagonals[u] += std::abs(k.entry(i, i));
  }
  for (std::size_t u = 0; u < count; ++u)
    out.mass[u] =
        diagonals[u] > 0.0 ? out.mass[u] / diagonals[u] : std::numeric_limits<double>::infinity();
  return out;
}

/// By others or directly.
void close(std::vector<std::vector<char>>& reads) {
  for (std::size_t by = 0; by < reads.size(); ++by)
    for (auto& row : reads)
      for (std::size_t other = 0; other < row.size(); ++other)
        if (row[by] != 0 && reads[by][other] != 0) row[other] = 1;
}

/// First those that read no other one which does not read them, too; of these who has the most
/// components, then who has the least of a mass.
std::vector<int> order_by(Traits traits) {
  close(traits.reads);
  std::vector<int> left(traits.mass.size()), out;
  std::iota(left.begin(), left.end(), 0);
  const auto waits = [&](int u) {
    return std::any_of(left.begin(), left.end(),
                       [&](int v) { return traits.reads[u][v] != 0 && traits.reads[v][u] == 0; });
  };
  while (!left.empty()) {
    const auto next = std::min_element(left.begin(), left.end(), [&](int a, int b) {
      const auto rank = [&](int u) {
        return std::tuple(waits(u), -traits.components[u], traits.mass[u]);
      };
      return rank(a) < rank(b);
    });
    out.push_back(*next);
    left.erase(next);
  }
  return out;
}

/// Rows of the whole by unknown as they are given. A node that has no component of an unknown has
/// no row of it.
std::vector<int> unknown_of_rows(const Numbering& numbering, const std::vector<int>& first) {
  const int all = numbering.components(), count = static_cast<int>(first.size()) - 1;
  std::vector<int> of_component(static_cast<std::size_t>(all)), out;
  for (int u = 0; u < count; ++u)
    std::fill(of_component.begin() + first[u], of_component.begin() + first[u + 1], u);
  std::vector<char> there(static_cast<std::size_t>(numbering.size() / all * count), 0);
  for (int row = 0; row < numbering.size(); ++row)
    if (numbering.is_unknown(row)) there[row / all * count + of_component[row % all]] = 1;
  for (int row = 0; row < numbering.size(); ++row) {
    const int u = of_component[row % all];
    out.push_back(there[row / all * count + u] != 0 ? u : -1);
  }
  return out;
}

} // namespace

UnknownRows order_of_unknowns(const WholeMatrix& k, const Numbering& numbering,
                              const std::vector<int>& first) {
  UnknownRows out;
  const int rows_of_node = numbering.components();
  out.turn = unknown_of_rows(numbering, first);
  const std::vector<int> order = order_by(traits_of(k, out.turn, rows_of_node, first));
  std::vector<int> turn(order.size());
  for (std::size_t t = 0; t < order.size(); ++t) {
    turn[order[t]] = static_cast<int>(t);
    out.components.push_back(first[order[t] + 1] - first[order[t]]);
  }
  for (int& t : out.turn)
    if (t >= 0) t = turn[t];
  return out;
}

std::vector<double> eliminate(const WholeMatrix& k, const UnknownRows& unknowns) {
  const std::vector<int>& turn = unknowns.turn;
  std::vector<double> out(static_cast<std::size_t>(k.rows()), 0.0);
  WholeMatrix::Room room;
  for (int t = 0; t < static_cast<int>(unknowns.components.size()); ++t)
    for (int i = 0; i < k.rows(); ++i) {
      if (turn[i] != t) continue;
      const WholeMatrix::Row row = k.row(i, room);
      out[i] = k.entry(i, i);
      for (int e = 0; e < row.size; ++e) {
        const int j = row.column[e];
        if (turn[j] < 0 || turn[j] >= t || out[j] == 0.0) continue;
        out[i] -= row.value[e] * k.entry(j, i) / out[j];
      }
    }
  return out;
}

} // namespace hvi::petsc_module
