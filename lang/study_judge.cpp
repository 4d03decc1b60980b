// What the runs of a study say together: distances to the finest one, extrapolated errors, orders
// between neighbours, the front. See study.hpp.
#include "lang/study.hpp"
#include "solver/study/ladder.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

namespace hvi::lang {

namespace {

using solver::Richardson;
using solver::StudyError;

/// A rung as a number; words have none.
std::optional<double> number_of(const std::string& rung) {
  try {
    return std::stod(rung);
  } catch (const std::logic_error&) { // no number, or beyond any
    return std::nullopt;
  }
}

/// Of a ladder: the values of its first parameter whose numbers change from rung to rung; null for
/// a ladder of words (schemes, elements), which refines nothing.
const std::vector<std::string>* numbers_of(const StudyLadder& ladder) {
  const auto refines = [](const std::vector<std::string>& values) {
    return number_of(values.front()) && values.front() != values.back();
  };
  if (refines(ladder.values)) return &ladder.values;
  for (const auto& [name, values] : ladder.more)
    if (refines(values)) return &values;
  return nullptr;
}

/// How much finer the second of two rows is than the first, by the first ladder of numbers; those
/// of mesh sizes and time steps fall.
std::optional<double> ratio_of(const Study& study, const StudyRow& coarse, const StudyRow& fine) {
  for (std::size_t l = 0; l < study.ladders.size(); ++l) {
    const auto* const values = numbers_of(study.ladders[l]);
    if (values == nullptr) continue;
    const auto at = [&](const StudyRow& row) {
      return number_of((*values)[static_cast<std::size_t>(row.rungs[l])]);
    };
    const auto a = at(coarse), b = at(fine);
    if (!a || !b) return std::nullopt;
    const bool falls = *number_of(values->back()) < *number_of(values->front());
    return falls ? *a / *b : *b / *a;
  }
  return std::nullopt;
}

/// By how many rungs a row is lower than another, the same number on every ladder of numbers, on
/// the same rungs of the others; 0 where it is not.
int rungs_below(const Study& study, const StudyRow& row, const StudyRow& other) {
  std::optional<int> out;
  for (std::size_t l = 0; l < row.rungs.size(); ++l) {
    const int lowered = other.rungs[l] - row.rungs[l];
    if (numbers_of(study.ladders[l]) == nullptr) {
      if (lowered != 0) return 0;
    } else if (out.value_or(lowered) != lowered) {
      return 0;
    } else {
      out = lowered;
    }
  }
  return out.value_or(0);
}

/// Rows below the finest along the diagonal of the ladders of numbers, and their resolutions
/// relative to the finest run's.
struct Diagonal {
  std::vector<std::size_t> rows;
  std::vector<double> scales;
};
Diagonal diagonal_of(const Study& study) {
  Diagonal out;
  const StudyRow& finest = study.rows.back();
  for (std::size_t i = 0; i + 1 < study.rows.size(); ++i) {
    const StudyRow& row = study.rows[i];
    if (!row.error || rungs_below(study, row, finest) <= 0) continue;
    const auto ratio = ratio_of(study, row, finest);
    if (!ratio) continue;
    out.rows.push_back(i);
    out.scales.push_back(1.0 / *ratio);
  }
  return out;
}

/// Which of the errors of a row: that of an unknown, or of the only one.
using Which = std::optional<std::size_t>;
StudyError& error_of(StudyRow& row, Which unknown) {
  return unknown ? row.errors[*unknown] : *row.error;
}

constexpr std::array norms = {&StudyError::v_max, &StudyError::v_final, &StudyError::l2_max,
                              &StudyError::l2_final};

/// Errors from the distances in one norm, of all rows; that of the finest is NaN where no order is
/// seen.
std::optional<Richardson> extrapolate_norm(Study& study, const Diagonal& diagonal, Which unknown,
                                           double StudyError::*norm) {
  const std::size_t u = unknown.value_or(0);
  std::vector<solver::RungDistance> distances;
  for (std::size_t k = 0; k < diagonal.rows.size(); ++k) {
    StudyRow& row = study.rows[diagonal.rows[k]];
    distances.push_back({diagonal.scales[k], 1.0, error_of(row, unknown).*norm});
    if (k > 0 && u < row.below.size())
      distances.push_back({diagonal.scales[k - 1], diagonal.scales[k], row.below[u].*norm});
  }
  const auto law = solver::richardson(distances, solver::Measured::norm);
  for (std::size_t i = 0; law && i + 1 < study.rows.size(); ++i)
    if (study.rows[i].error) {
      double& error = error_of(study.rows[i], unknown).*norm;
      // What a run beside the diagonal has in common with the finest one is not known.
      error =
          below_finest(study, study.rows[i]) ? law->error(error) : std::hypot(error, law->finest);
    }
  error_of(study.rows.back(), unknown).*norm = law ? law->finest : std::nan("");
  return law;
}

/// Errors of one unknown against the finest run, from the distances to it.
void extrapolate(Study& study, const Diagonal& diagonal, Which unknown) {
  if (!diagonal.rows.empty())
    error_of(study.rows.back(), unknown).size =
        error_of(study.rows[diagonal.rows.front()], unknown).size;
  for (const auto norm : norms) {
    const auto law = extrapolate_norm(study, diagonal, unknown, norm);
    const std::string of = unknown ? " of `" + study.unknowns[*unknown] + "`" : std::string();
    if (norm == &StudyError::v_max) study.extrapolated.push_back({"V error" + of, law});
    if (norm == &StudyError::l2_max) study.extrapolated.push_back({"L2 error" + of, law});
  }
}

/// Errors of a study against its finest run. What rows are judged by is made of the unknowns'.
void extrapolate_errors(Study& study) {
  const Diagonal diagonal = diagonal_of(study);
  StudyRow& finest = study.rows.back();
  finest.error = StudyError{};
  if (study.unknowns.empty()) return extrapolate(study, diagonal, std::nullopt);
  finest.errors.assign(study.unknowns.size(), {});
  for (std::size_t u = 0; u < study.unknowns.size(); ++u) extrapolate(study, diagonal, u);
  for (StudyRow& row : study.rows)
    if (row.error) row.error = study.in ? row.errors[*study.in] : solver::together(row.errors);
}

/// Where a probe's values on the diagonal go. They are numbers: the errors of all runs have one
/// sign where there is an order.
std::optional<Richardson> law_of_probe(const Study& study, const Diagonal& diagonal,
                                       const std::string& name, double finest) {
  std::vector<solver::RungDistance> distances;
  double side = 0.0;
  for (std::size_t k = 0; k < diagonal.rows.size(); ++k) {
    const StudyRow& row = study.rows[diagonal.rows[k]];
    const auto value = row.probes.find(name);
    if (value == row.probes.end()) return std::nullopt;
    const double off = value->second - finest;
    if (off * side < 0.0) return std::nullopt;
    side = off;
    distances.push_back({diagonal.scales[k], 1.0, std::abs(off)});
  }
  return solver::richardson(distances, solver::Measured::number);
}

/// How much larger a probe is in the coarsest run of the diagonal than in the finest.
double first_off(const Study& study, const Diagonal& diagonal, const std::string& name,
                 double finest) {
  return study.rows[diagonal.rows.front()].probes.at(name) - finest;
}

/// Distances of the probes to the finest run's; with `richardson` to where they go.
void judge_probes(Study& study, bool richardson) {
  if (!study.finest) return;
  const Diagonal diagonal = richardson ? diagonal_of(study) : Diagonal{};
  const StudyRow finest = study.rows[*study.finest];
  for (const auto& [name, value] : finest.probes) {
    const auto law =
        richardson ? law_of_probe(study, diagonal, name, value) : std::optional<Richardson>();
    const double limit =
        law ? value - std::copysign(law->finest, first_off(study, diagonal, name, value)) : value;
    for (std::size_t i = 0; i < study.rows.size(); ++i)
      if (const auto mine = study.rows[i].probes.find(name);
          mine != study.rows[i].probes.end() && (law || i != *study.finest))
        study.rows[i].probe_errors[name] = std::abs(mine->second - limit);
    if (richardson) study.extrapolated.push_back({"`" + name + "`", law});
  }
}

/// The row one rung lower on every ladder of numbers, the same on ladders of words; -1 for none.
int coarser_row(const Study& study, std::size_t of) {
  for (std::size_t i = 0; i < study.rows.size(); ++i)
    if (rungs_below(study, study.rows[i], study.rows[of]) == 1) return static_cast<int>(i);
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
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    StudyRow& row = study.rows[i];
    row.front = front[i];
    const int before = coarser_row(study, i);
    if (before < 0) continue;
    const auto ratio = ratio_of(study, study.rows[static_cast<std::size_t>(before)], row);
    if (!ratio) continue;
    row.order = solver::observed_order(error[before], error[i], *ratio);
    const auto& coarser = study.rows[static_cast<std::size_t>(before)].errors;
    for (std::size_t u = 0; u < std::min(coarser.size(), row.errors.size()); ++u)
      row.orders.push_back(solver::observed_order(coarser[u].v_max, row.errors[u].v_max, *ratio));
    for (const auto& [name, off] : row.probe_errors)
      if (const auto coarse = study.rows[before].probe_errors.find(name);
          coarse != study.rows[before].probe_errors.end())
        if (const auto p = solver::observed_order(coarse->second, off, *ratio))
          row.probe_orders[name] = *p;
  }
}

} // namespace

bool below_finest(const Study& study, const StudyRow& row) {
  return rungs_below(study, row, study.rows.back()) > 0;
}

void judge(Study& study, bool richardson) {
  if (richardson) extrapolate_errors(study);
  judge_probes(study, richardson);
  compare_neighbours(study);
}

} // namespace hvi::lang
