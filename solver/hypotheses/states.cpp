// See states.hpp. Called by law_rows.cpp.
#include "solver/hypotheses/states.hpp"

#include "solver/law/switches.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

bool is_input(Slot s) { return s >= slot::first_field && s < slot::first_inside; }

/// Of places, times and states; of anything else what is up to `reach` in size.
class Ranges {
public:
  Ranges(const Problem& problem, const Mesh& mesh) : problem_(problem) {
    low_ = high_ = mesh.nodes.front();
    for (const Point& x : mesh.nodes)
      for (std::size_t i = 0; i < 3; ++i) {
        low_[i] = std::min(low_[i], x[i]);
        high_[i] = std::max(high_[i], x[i]);
      }
  }

  Bounds operator()(Slot s, double reach) const {
    if (s == slot::t)
      return problem_.time.is_static
                 ? Bounds{0.0, 0.0}
                 : Bounds{problem_.time.grid.front(), problem_.time.grid.back()};
    if (s >= slot::x(0) && s <= slot::x(2))
      return {low_[static_cast<std::size_t>(s)], high_[static_cast<std::size_t>(s)]};
    if (slot::is_state(s)) return of_state(s - slot::first_state, reach);
    return {-reach, reach};
  }

  Bounds of_state(int i, double reach) const {
    const auto& state = problem_.states[static_cast<std::size_t>(i)];
    return {std::max(state.low, -reach), std::min(state.high, reach)};
  }

private:
  const Problem& problem_;
  Point low_{}, high_{};
};

std::vector<Slot> those(const Expr& f, const std::function<bool(Slot)>& which) {
  std::vector<Slot> out;
  std::ranges::copy_if(f.slots(), std::back_inserter(out), which);
  return out;
}

} // namespace

RateConstants rate_constants(const Problem& problem, const Mesh& mesh, const StateTerm& state) {
  RateConstants out;
  const auto states = those(state.rate, slot::is_state), inputs = those(state.rate, is_input);
  out.other_states = std::ranges::any_of(states, [&](Slot s) {
    return &problem.states[static_cast<std::size_t>(s - slot::first_state)] != &state;
  });
  out.reads_inputs = !inputs.empty();
  const VariationSearch search(Ranges(problem, mesh), mesh.dim);
  out.by_states = search.of(state.rate, states);
  if (out.reads_inputs) out.by_inputs = search.of(state.rate, inputs);
  return out;
}

SlopeConstants slope_constants(const Problem& problem, const Mesh& mesh, const LawTerm& term,
                               double lipschitz) {
  const LawSpec& law = problem.laws[static_cast<std::size_t>(term.law)];
  const Ranges ranges(problem, mesh);
  const Expr exposed = expose_kinks(law.expression);
  const Expr slope = law.by_slope ? exposed : derivative(exposed, slot::r);
  const VariationSearch of_law(
      [&](Slot s, double reach) -> Bounds {
        if (s == slot::r && law.radial) return {0.0, reach};
        const auto k = static_cast<std::size_t>(s - slot::law_state(0));
        return s >= slot::law_state(0) && k < law.states.size()
                   ? ranges.of_state(law.states[k], reach)
                   : ranges(s, reach);
      },
      mesh.dim);
  const auto is_state = [](Slot s) {
    return s >= slot::law_state(0) && s < slot::law_state(slot::most_law_states);
  };
  const auto is_read = [](Slot s) {
    return s == slot::coupled || (s >= slot::reading(0) && s < slot::reading(slot::most_readings));
  };
  SlopeConstants out;
  out.reads_states = !law.states.empty();
  out.reads = !law.readings.empty() || !law.coupled.empty();
  if (out.reads_states) out.by_states = of_law.of(slope, those(slope, is_state));
  if (out.reads) out.by_readings = of_law.of(slope, those(slope, is_read));
  for (const auto& row : term.rows) {
    const auto beside = those(row.offset, slot::is_state);
    if (beside.empty()) continue;
    out.reads_states = true;
    out.by_states =
        out.by_states + lipschitz * VariationSearch(ranges, mesh.dim).of(row.offset, beside);
  }
  return out;
}

} // namespace hvi::solver
