// See elimination.hpp.
#include "solver/linear/petsc/elimination.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace hvi::petsc_module {
namespace {

/// What decides about the order: of each unknown the components (of the first process), how much
/// its form has of a mass, what constants give by the diagonal (0 for derivatives), and which
/// others its rows read.
struct Traits {
  std::vector<int> components;
  std::vector<double> mass;
  std::vector<std::vector<char>> reads;
};

/// Sums of this process's rows become those of all.
void add_up(const Distribution& distribution, Traits& traits, std::vector<double>& diagonals) {
  const int count = static_cast<int>(diagonals.size());
  distribution.add_up(traits.mass.data(), count);
  distribution.add_up(diagonals.data(), count);
  for (auto& row : traits.reads)
    for (char& reads : row) reads = distribution.any(reads != 0) ? 1 : 0;
}

/// `unknown`: of each row of this process, -1: none. `rows_of_node`: of all processes.
Traits traits_of(const Distribution& distribution, Mat k, const std::vector<int>& unknown,
                 int rows_of_node, int unknowns) {
  Traits out;
  const auto count = static_cast<std::size_t>(unknowns);
  out.mass.assign(count, 0.0);
  out.reads.assign(count, std::vector<char>(count, 0));
  std::vector<double> diagonals(out.mass);
  NumbersOfColumns of(distribution, k);
  of.set({unknown.begin(), unknown.end()});
  for (int i = 0; i < distribution.rows(); ++i) {
    const int u = unknown[i], at = distribution.first_row() + i;
    if (u < 0) continue;
    const RowOf row(k, at);
    double sum = 0.0;
    for (int e = 0; e < row.size(); ++e) {
      const int j = row.column(e), other = static_cast<int>(of[j]);
      if (other == u && j % rows_of_node == at % rows_of_node) sum += row.value(e);
      if (other >= 0 && other != u && row.value(e) != 0.0) out.reads[u][other] = 1;
    }
    out.mass[u] += std::abs(sum);
    diagonals[u] += std::abs(row.entry(at));
  }
  add_up(distribution, out, diagonals);
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

UnknownRows order_of_unknowns(const Distribution& distribution, Mat k, const Numbering& numbering,
                              const std::vector<int>& first) {
  UnknownRows out;
  const int rows_of_node = distribution.of_first(numbering.components());
  out.count = distribution.of_first(static_cast<int>(first.size()) - 1);
  if (distribution.is_first()) out.turn_of_whole = unknown_of_rows(numbering, first);
  out.turn = distribution.deal(out.turn_of_whole);
  Traits traits = traits_of(distribution, k, out.turn, rows_of_node, out.count);
  for (std::size_t u = 0; u + 1 < first.size(); ++u)
    traits.components.push_back(first[u + 1] - first[u]);
  std::vector<int> turn(static_cast<std::size_t>(out.count));
  if (distribution.is_first()) {
    const std::vector<int> order = order_by(traits);
    for (std::size_t t = 0; t < order.size(); ++t) {
      turn[order[t]] = static_cast<int>(t);
      out.components.push_back(traits.components[order[t]]);
    }
  }
  for (int& t : turn) t = distribution.of_first(t);
  for (auto* const rows : {&out.turn, &out.turn_of_whole})
    for (int& t : *rows)
      if (t >= 0) t = turn[t];
  return out;
}

std::vector<double> eliminate(const Distribution& distribution, Mat k,
                              const UnknownRows& unknowns) {
  const std::vector<int>& turn = unknowns.turn;
  std::vector<double> out(turn.size(), 0.0);
  const MirrorImages mirrored(distribution, k);
  NumbersOfColumns turns(distribution, k), left(distribution, k);
  turns.set({turn.begin(), turn.end()});
  for (int t = 0; t < unknowns.count; ++t) {
    left.set(out);
    const auto before = [&](int j) { return turns[j] >= 0.0 && turns[j] < t && left[j] != 0.0; };
    for (int i = 0; i < distribution.rows(); ++i) {
      if (turn[i] != t) continue;
      const int row = distribution.first_row() + i;
      out[i] = RowOf(k, row).entry(row);
      mirrored.for_row(row, before, [&](int j, double value, double mirror) {
        out[i] -= value * mirror / left[j];
      });
    }
  }
  return out;
}

} // namespace hvi::petsc_module
