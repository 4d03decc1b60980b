// See common_points.hpp.
#include "lang/lower/common_points.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

/// Law terms in groups.
class Groups {
public:
  explicit Groups(std::size_t terms) : of_(terms) { std::iota(of_.begin(), of_.end(), 0); }
  void join(int a, int b) {
    const int from = of(b), to = of(a);
    std::ranges::replace(of_, from, to);
  }
  int of(int term) const { return of_[static_cast<std::size_t>(term)]; }

private:
  std::vector<int> of_;
};

bool reads_states(const solver::LawTerm& term, const solver::LawSpec& law) {
  return !law.states.empty() || std::ranges::any_of(term.rows, [](const auto& row) {
    return row.offset.depends_on_any(slot::first_state, slot::first_probe);
  });
}

/// With the laws whose multipliers a law reads.
void join_readings(const solver::Problem& problem, Groups& groups) {
  for (int l = 0; l < std::ssize(problem.law_terms); ++l) {
    const auto& term = problem.law_terms[static_cast<std::size_t>(l)];
    const auto& law = problem.laws[static_cast<std::size_t>(term.law)];
    for (const auto& reading : law.readings)
      for (const solver::Slot s : reading.slots())
        if (slot::is_multiplier(s)) groups.join(l, slot::term_of(s));
    for (int other = 0; other < std::ssize(problem.law_terms); ++other) {
      const auto& there = problem.law_terms[static_cast<std::size_t>(other)];
      if (!law.coupled.empty() && there.name == law.coupled && there.part == term.part)
        groups.join(l, other);
    }
  }
}

/// The terms that have to do with the states of their part.
void join_states(const solver::Problem& problem, Groups& groups) {
  for (const solver::StateTerm& state : problem.states) {
    int first = -1;
    for (int l = 0; l < std::ssize(problem.law_terms); ++l) {
      const auto& term = problem.law_terms[static_cast<std::size_t>(l)];
      if (term.part != state.part) continue;
      const solver::Slot xi = slot::multiplier(l, 0);
      const bool read = std::ranges::any_of(problem.states, [&](const solver::StateTerm& other) {
        return other.part == term.part && other.rate.depends_on_any(xi, xi + slot::most_arguments);
      });
      if (!read && !reads_states(term, problem.laws[static_cast<std::size_t>(term.law)])) continue;
      if (first < 0) first = l;
      groups.join(first, l);
    }
  }
}

} // namespace

void give_common_points(solver::Problem& problem) {
  const auto unknowns = solver::unknowns_of(problem.space);
  Groups groups(problem.law_terms.size());
  join_readings(problem, groups);
  join_states(problem, groups);
  const auto whose = [](const solver::LawTerm& term) {
    return term.rule_of.value_or(term.unknown);
  };
  const auto order_of = [&](int unknown) {
    return unknowns[static_cast<std::size_t>(unknown)].order;
  };
  for (int l = 0; l < std::ssize(problem.law_terms); ++l) {
    auto& term = problem.law_terms[static_cast<std::size_t>(l)];
    for (int other = 0; other < std::ssize(problem.law_terms); ++other) {
      const int theirs = whose(problem.law_terms[static_cast<std::size_t>(other)]);
      if (groups.of(l) == groups.of(other) && order_of(whose(term)) < order_of(theirs))
        term.rule_of = theirs;
    }
  }
}

} // namespace hvi::lang
