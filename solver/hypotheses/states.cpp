// See states.hpp. Called by law_rows.cpp.
#include "solver/hypotheses/states.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/largest.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr std::size_t most_variables = 6;
constexpr double far = 1e9;
/// A derivative that is so much larger far out than near grows without end.
constexpr double grows = 1e3;

bool is_input(Slot s) { return s >= slot::first_field && s < slot::first_inside; }

class Search {
public:
  Search(const Problem& problem, const Mesh& mesh) : problem_(problem), dim_(mesh.dim) {
    low_ = high_ = mesh.nodes.front();
    for (const Point& x : mesh.nodes)
      for (std::size_t i = 0; i < 3; ++i) {
        low_[i] = std::min(low_[i], x[i]);
        high_[i] = std::max(high_[i], x[i]);
      }
  }

  RateConstant of(const Expr& derivatives) const {
    RateConstant out{largest(derivatives, far), largest(derivatives, 1.0)};
    if (out.everywhere.low > grows * std::max(out.near.low, 1.0 / grows))
      out.everywhere = Bracket::exactly(infinity);
    return out;
  }

private:
  Bounds range(Slot s, double reach) const {
    if (s == slot::t) return {problem_.time.grid.front(), problem_.time.grid.back()};
    if (s <= slot::x(2))
      return {low_[static_cast<std::size_t>(s)], high_[static_cast<std::size_t>(s)]};
    if (!slot::is_state(s)) return {-reach, reach};
    const auto& state = problem_.states[static_cast<std::size_t>(s - slot::first_state)];
    return {std::max(state.low, -reach), std::min(state.high, reach)};
  }

  /// Over the axes as normals.
  Bracket largest(const Expr& f, double reach) const {
    if (!f.depends_on_any(slot::normal(0), slot::normal(2) + 1)) return with_normal(f, reach);
    Bracket out;
    for (int axis = 0; axis < dim_; ++axis) {
      std::vector<std::pair<Slot, Expr>> normal;
      for (int j = 0; j < 3; ++j) normal.emplace_back(slot::normal(j), Expr(j == axis ? 1.0 : 0.0));
      out = larger(out, with_normal(substitute(f, normal), reach));
    }
    return Bracket::at_least(out.low);
  }

  Bracket with_normal(const Expr& f, double reach) const {
    std::vector<Slot> variables;
    SearchBox box{};
    for (const Slot s : f.slots())
      if (variables.size() < most_variables) {
        box[variables.size()] = range(s, reach);
        variables.push_back(s);
      }
    if (variables.empty()) return Bracket::exactly(std::abs(evaluate(f, [](Slot) { return 0.0; })));
    SearchSpace space;
    space.boxes = {box};
    space.over_decades = true;
    space.fixed = [](Slot) { return Bounds{0.0, 0.0}; };
    const auto found = LargestSearch(f, variables)(space, {4000, 1e-6, 0.0});
    const bool all = f.slots().size() <= most_variables && std::isfinite(found.value.high);
    return all ? found.value : Bracket::at_least(std::max(found.value.low, 0.0));
  }

  const Problem& problem_;
  int dim_;
  Point low_{}, high_{};
};

} // namespace

RateConstants rate_constants(const Problem& problem, const Mesh& mesh, const StateTerm& state) {
  RateConstants out;
  Expr by_states = 0.0, by_inputs = 0.0;
  for (const Slot s : state.rate.slots()) {
    if (slot::is_state(s)) {
      by_states = by_states + abs(derivative(state.rate, s));
      const auto i = static_cast<std::size_t>(s - slot::first_state);
      out.other_states = out.other_states || &problem.states[i] != &state;
    } else if (is_input(s)) {
      by_inputs = by_inputs + abs(derivative(state.rate, s));
      out.reads_inputs = true;
    }
  }
  const Search search(problem, mesh);
  out.by_states = search.of(by_states);
  if (out.reads_inputs) out.by_inputs = search.of(by_inputs);
  return out;
}

} // namespace hvi::solver
