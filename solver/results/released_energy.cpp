// See released_energy.hpp. Used by the EnergyMonitor.
#include "solver/results/released_energy.hpp"

#include "solver/linear/vector_stream.hpp"

#include <algorithm>

namespace hvi::solver {

std::string monitor_column(const Problem& problem, const std::string& prefix, const LawTerm& term) {
  const std::string name = prefix + term.name;
  const auto same = std::ranges::count(problem.law_terms, term.name, &LawTerm::name);
  return same > 1 ? name + "_" + problem.parts[static_cast<std::size_t>(term.part)].name : name;
}

double potential_at(const Law& law, const LawGraph& graph, double r) {
  int piece = piece_of(graph, r);
  const double slope = law.slope(graph, piece, r);
  if (slope >= unbounded_slope) r = graph.breaks[static_cast<std::size_t>(--piece)];
  if (slope <= -unbounded_slope) r = graph.breaks[static_cast<std::size_t>(piece++)];
  return law.potential(graph, piece, r);
}

ReleasedEnergy::ReleasedEnergy(const Problem& problem, const RunState& run)
    : problem_(problem), states_(run.states()) {
  const auto& terms = run.contact().terms;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    if (terms[k].field != field_of_u(0)) continue;
    if (terms[k].first_states.empty() && !terms[k].offset_of_states) continue;
    terms_.push_back(static_cast<int>(k));
    const auto law_term = static_cast<std::size_t>(terms[k].points.law_term);
    names_.push_back(monitor_column(problem, "released_", problem.law_terms[law_term]));
  }
  of_forms_ = std::ranges::any_of(problem.forms, [](const FormTerm& form) {
    return form.field == field_of_u(0) && reads_states(form);
  });
  if (of_forms_) names_.emplace_back("released_forms");
  sums_.assign(names_.size(), 0.0);
}

bool ReleasedEnergy::of_mean_forces() const {
  return problem_.time.scheme == Scheme::newmark || problem_.time.scheme == Scheme::midpoint;
}

double ReleasedEnergy::released(const RunState& run, const ContactTerm& term,
                                const Vector& before) const {
  const Contact& contact = run.contact();
  Vector old_offsets;
  offsets_of(contact, problem_, term, run.evolution.t(), states_, old_offsets);
  const Vector moved = term.points.g * before;
  double sum = 0.0;
  for (int p = 0; p < term.n_points(); ++p) {
    const auto& point = contact.problem.points[static_cast<std::size_t>(term.first_point + p)];
    const Law& law = *contact.laws[static_cast<std::size_t>(point.law)];
    const LawGraph& now = contact.problem.graphs[static_cast<std::size_t>(point.graph)];
    LawTime t = now.t;
    for (std::size_t k = 0; k < term.first_states.size(); ++k)
      t.states[k] = states_[term.first_states[k] + p];
    const auto at = [&](const LawGraph& graph, const auto& offset) {
      const Vector z = moved.segment(p * point.rows, point.rows) + offset;
      return potential_at(law, graph, law.spec().radial ? z.norm() : z[0]);
    };
    const double old = at(term.first_states.empty() ? now : law.graph(term.points.x[p], t),
                          old_offsets.segment(p * point.rows, point.rows));
    sum += point.weight * (old - at(now, contact.offset.segment(point.first_row, point.rows)));
  }
  return sum;
}

void ReleasedEnergy::add_laws(const RunState& run, const Vector& before) {
  for (std::size_t k = 0; k < terms_.size(); ++k)
    sums_[k] += released(run, run.contact().terms[static_cast<std::size_t>(terms_[k])], before);
  states_ = run.states();
}

void ReleasedEnergy::save(StateWriter& w) const {
  w.put(sums_);
  if (!terms_.empty()) put_vector(w, states_);
}

void ReleasedEnergy::restore(StateReader& r) {
  sums_ = r.get_vector<double>(sums_.size());
  if (!terms_.empty()) get_vector(r, states_, states_.size());
}

} // namespace hvi::solver
