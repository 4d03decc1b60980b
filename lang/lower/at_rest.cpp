// See at_rest.hpp.
#include "lang/lower/at_rest.hpp"

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

/// Every rate and memory, and its gradient, becomes zero.
std::vector<std::pair<solver::Slot, Symbol>> nothing_moves(const Model& model) {
  std::vector<std::pair<solver::Slot, Symbol>> out;
  const int n_fields = solver::field_of_memory(static_cast<int>(model.histories.size()));
  for (int field = solver::field_of_u(1); field < n_fields; ++field)
    for (int k = 0; k < slot::n_derivatives; ++k) out.emplace_back(slot::field(field, k), 0.0);
  return out;
}

/// Of the sum that a row of a law sees, how many times u.
double times_u(const std::vector<solver::SeenField>& seen) {
  double out = 0.0;
  for (const solver::SeenField& one : seen)
    if (one.field == solver::field_of_u(0)) out += one.times;
  return out;
}

/// The law sees u alone, or is dropped.
void let_rest(LawUse& use) {
  if (use.seen.empty()) {
    if (use.field != solver::field_of_u(0)) use.factor = 0.0;
    use.field = solver::field_of_u(0);
    return;
  }
  bool any = false, once = true;
  for (std::size_t c = 0; c < use.rows.size(); ++c) {
    const double times = times_u(use.seen[c]);
    any = any || times != 0.0;
    once = once && (times == 0.0 || times == 1.0);
    use.seen[c] = {{solver::field_of_u(0), times != 0.0 ? times : 1.0}};
    if (times == 0.0) // its force, too: the row's coefficients are the force's direction
      for (Symbol& coefficient : use.rows[c].u) coefficient = Symbol(0.0);
  }
  if (!any) use.factor = 0.0;
  if (!any || once) use.seen.clear();
  use.field = solver::field_of_u(0);
}

} // namespace

Model at_rest(Model model) {
  const auto still = nothing_moves(model);
  for (ModelTerm& term : model.terms) {
    for (Symbol& c : term.integrand.components) c = substitute(c, still);
    std::erase_if(term.integrand.materials, [](const MaterialUse& use) {
      return use.of && *use.of != solver::field_of_u(0);
    });
    for (LawUse& use : term.integrand.laws) let_rest(use);
  }
  for (ModelLaw& law : model.laws)
    for (Symbol& reading : law.spec.readings) reading = substitute(reading, still);
  for (ModelState& state : model.states) state.spec.rate = 0.0;
  model.report = {};
  model.expectations.clear();
  solver::TimeSpec& time = model.time;
  if (time.grid.size() > 1) time.grid = {2.0 * time.grid[0] - time.grid[1], time.grid[0]};
  time.scheme = solver::Scheme::backward_euler;
  time.sampling = solver::LoadSampling::endpoint;
  time.initial.clear();
  time.velocity.reset();
  return model;
}

} // namespace hvi::lang
