// See couplings.hpp.
#include "solver/plan/couplings.hpp"

#include <algorithm>

namespace hvi::solver {

Couplings couplings_of(const Problem& problem) {
  Couplings out{};
  for (const FormTerm& form : problem.forms)
    for (const FormTerm::Entry& entry : form.entries)
      out[slot::unknown_of(entry.test)][slot::unknown_of(entry.trial)] = true;
  return out;
}

bool couples_unknowns(const Couplings& couplings) {
  for (std::size_t a = 0; a < couplings.size(); ++a)
    for (std::size_t b = 0; b < couplings.size(); ++b)
      if (a != b && couplings[a][b]) return true;
  return false;
}

std::vector<char> unknowns_with_laws(const Problem& problem) {
  std::vector<char> out(unknowns_of(problem.space).size(), 0);
  for (const LawTerm& term : problem.law_terms) out[static_cast<std::size_t>(term.unknown)] = 1;
  return out;
}

std::vector<char> multipliers_of(const Problem& problem) {
  const Couplings couplings = couplings_of(problem);
  std::vector<char> out = unknowns_with_laws(problem);
  for (std::size_t b = 0; b < out.size(); ++b) out[b] = out[b] == 0 && !couplings[b][b] ? 1 : 0;
  return out;
}

std::vector<int> orders_in_time(const Problem& problem) {
  std::vector<int> out(unknowns_of(problem.space).size(), 0);
  for (const FormTerm& form : problem.forms)
    for (const FormTerm::Entry& entry : form.entries)
      if (int& order = out[static_cast<std::size_t>(slot::unknown_of(entry.trial))];
          is_rate(form.field))
        order = std::max(order, form.field);
  return out;
}

bool has_inertia(const Problem& problem, int unknown) {
  return std::ranges::any_of(problem.forms, [&](const FormTerm& form) {
    return form.field == field_of_u(2) &&
           std::ranges::any_of(form.entries, [&](const FormTerm::Entry& entry) {
             return slot::unknown_of(entry.trial) == unknown;
           });
  });
}

} // namespace hvi::solver
