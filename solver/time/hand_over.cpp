// A run goes on as that of another plan: what does not depend on its matrices and laws is handed
// over, the rest is made anew. Or, where loads alone have changed, these. Called by
// SteppedRun::change.
#include "solver/discrete/discretisation.hpp"
#include "solver/linear/vector_stream.hpp"
#include "solver/step/work.hpp"
#include "solver/time/one_run.hpp"

#include <variant>

namespace hvi::solver {

void Stepper::hand_over(std::ostream& out) const {
  StateWriter w(out);
  state_.evolution.save(out);
  state_.solver.equations.laws.save(w);
}

std::optional<HorizonEnd> Stepper::take_over(std::istream& in) {
  StateReader r(in, {});
  auto same_end = state_.evolution.restore(in);
  if (auto* end = std::get_if<HorizonEnd>(&same_end)) return std::move(*end);
  state_.solver.equations.laws.take_over(r);
  state_.balance.load.note_multipliers(state_.xi());
  return std::nullopt;
}

void Stepper::take_loads(const Discretisation& d) {
  state_.formulation->take_loads(loads_on(plan_.problem, d, state_.formulation->layout()));
}

void OneRun::take_loads() {
  stepper_.take_loads(discretisation_);
  reporter_.take_loads();
}

void OneRun::hand_over(std::ostream& out) const {
  StateWriter w(out);
  stepper_.hand_over(out);
  save_findings(out);
  w.put(start_);
  w.put(result_.timing);
}

std::optional<HorizonEnd> OneRun::take_over(std::istream& in) {
  StateReader r(in, {});
  if (auto end = stepper_.take_over(in)) return end;
  restore_findings(in);
  start_ = r.get<double>();
  result_.timing = r.get<Timing>();
  told_ = state_.evolution.step();
  return std::nullopt;
}

} // namespace hvi::solver
