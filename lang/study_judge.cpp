// What the runs of a study say together: distances to the finest one, extrapolated errors, orders
// between neighbours, the front. See study.hpp.
#include "lang/study.hpp"
#include "solver/study/ladder.hpp"

#include <cmath>
#include <stdexcept>

namespace hvi::lang {

namespace {

/// A ladder's rung as a number; words have none.
std::optional<double> number_of(const StudyLadder& ladder, int rung) {
  try {
    return std::stod(ladder.values[rung]);
  } catch (const std::logic_error&) { // no number, or beyond any
    return std::nullopt;
  }
}

/// Rows below the finest along the diagonal of the ladders, and their parameters relative to the
/// finest run's; empty where the first ladder has no numbers.
std::pair<std::vector<std::size_t>, std::vector<double>> diagonal_of(const Study& study) {
  std::pair<std::vector<std::size_t>, std::vector<double>> out;
  const auto finest_value = number_of(study.ladders[0], study.rows.back().rungs[0]);
  if (!finest_value) return out;
  for (std::size_t i = 0; i + 1 < study.rows.size(); ++i) {
    const StudyRow& row = study.rows[i];
    int lowered = study.rows.back().rungs[0] - row.rungs[0];
    for (std::size_t l = 0; l < row.rungs.size(); ++l)
      if (study.rows.back().rungs[l] - row.rungs[l] != lowered) lowered = 0;
    const auto value = number_of(study.ladders[0], row.rungs[0]);
    if (lowered == 0 || !row.error || !value) continue;
    out.first.push_back(i);
    out.second.push_back(*value / *finest_value);
  }
  return out;
}

/// Which of the errors of a row: the one it is judged by, or that of an unknown.
using Which = std::optional<std::size_t>;
solver::StudyError& error_of(StudyRow& row, Which unknown) {
  return unknown ? row.errors[*unknown] : *row.error;
}

/// Errors of a study against its finest run, extrapolated along the diagonal of the ladders.
void extrapolate(Study& study, Which unknown) {
  const auto [diagonal, scales] = diagonal_of(study);
  std::vector<double> distances;
  for (const std::size_t i : diagonal) distances.push_back(error_of(study.rows[i], unknown).v_max);
  const auto fit = solver::richardson(scales, distances);
  if (!fit) return;
  for (std::size_t k = 0; k < diagonal.size(); ++k) {
    auto& error = error_of(study.rows[diagonal[k]], unknown);
    const double factor = fit->errors[k] / error.v_max;
    error.v_final *= factor, error.l2_max *= factor, error.l2_final *= factor;
    error.v_max = fit->errors[k];
  }
  solver::StudyError last;
  last.v_max = last.v_final = fit->errors.back();
  last.l2_max = last.l2_final = std::nan("");
  last.size = error_of(study.rows[diagonal.back()], unknown).size;
  StudyRow& finest = study.rows.back();
  if (unknown)
    finest.errors[*unknown] = last;
  else
    finest.error = last;
}

/// Distances of the probes to the finest run's; with `richardson` the diagonal has errors.
void judge_probes(Study& study, bool richardson) {
  if (!study.finest) return;
  const StudyRow finest = study.rows[*study.finest];
  for (const auto& [name, value] : finest.probes) {
    for (std::size_t i = 0; i < study.rows.size(); ++i)
      if (const auto mine = study.rows[i].probes.find(name);
          i != *study.finest && mine != study.rows[i].probes.end())
        study.rows[i].probe_errors[name] = std::abs(mine->second - value);
    if (!richardson) continue;
    const auto [diagonal, scales] = diagonal_of(study);
    std::vector<double> distances;
    for (const std::size_t i : diagonal) distances.push_back(study.rows[i].probe_errors[name]);
    const auto fit = solver::richardson(scales, distances);
    if (!fit) continue;
    for (std::size_t k = 0; k < diagonal.size(); ++k)
      study.rows[diagonal[k]].probe_errors[name] = fit->errors[k];
    study.rows[*study.finest].probe_errors[name] = fit->errors.back();
  }
}

/// The row one rung lower on every ladder of numbers, the same on ladders of words (schemes,
/// elements), which refine nothing; -1 for none.
int coarser_row(const Study& study, std::size_t of) {
  std::vector<int> lower = study.rows[of].rungs;
  bool moved = false;
  for (std::size_t l = 0; l < lower.size(); ++l) {
    if (!number_of(study.ladders[l], 0)) continue;
    if (lower[l]-- == 0) return -1;
    moved = true;
  }
  for (std::size_t i = 0; moved && i < study.rows.size(); ++i)
    if (study.rows[i].rungs == lower) return static_cast<int>(i);
  return -1;
}

/// Orders between neighbours and the front.
void compare_neighbours(Study& study) {
  std::vector<double> cost, error;
  for (const StudyRow& row : study.rows) {
    cost.push_back(row.cpu);
    error.push_back(row.error ? row.error->v_max : std::nan(""));
  }
  const auto front = solver::pareto_front(cost, error);
  std::size_t first = 0; // the ladder whose numbers stand for the resolution
  while (first + 1 < study.ladders.size() && !number_of(study.ladders[first], 0)) ++first;
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    StudyRow& row = study.rows[i];
    row.front = front[i];
    const int before = coarser_row(study, i);
    if (before < 0) continue;
    const auto a = number_of(study.ladders[first], study.rows[before].rungs[first]);
    const auto b = number_of(study.ladders[first], row.rungs[first]);
    if (!a || !b) continue;
    row.order = solver::observed_order(error[before], error[i], *b / *a);
    const auto& coarser = study.rows[static_cast<std::size_t>(before)].errors;
    for (std::size_t u = 0; u < std::min(coarser.size(), row.errors.size()); ++u)
      row.orders.push_back(solver::observed_order(coarser[u].v_max, row.errors[u].v_max, *b / *a));
    for (const auto& [name, off] : row.probe_errors)
      if (const auto coarse = study.rows[before].probe_errors.find(name);
          coarse != study.rows[before].probe_errors.end())
        if (const auto p = solver::observed_order(coarse->second, off, *b / *a))
          row.probe_orders[name] = *p;
  }
}

} // namespace

void judge(Study& study, bool richardson) {
  judge_probes(study, richardson);
  if (richardson) {
    extrapolate(study, std::nullopt);
    const double none = std::nan(""); // where no order is seen
    study.rows.back().errors.assign(study.unknowns.size(), {none, none, none, none, none});
    for (std::size_t u = 0; u < study.unknowns.size(); ++u) extrapolate(study, u);
  }
  compare_neighbours(study);
}

} // namespace hvi::lang
