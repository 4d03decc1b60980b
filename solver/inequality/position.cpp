// Warm starts and the way to them (position.hpp).
#include "solver/inequality/position.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

Position::Position(const ContactPoints& points_, const ReducedOperator& s, double target)
    : points(points_), c(Vector::Zero(points_.unknowns)), z(Vector::Zero(points_.rows)), xi(z),
      places(points_), balance(points_, s, target), snap(points_), z_start(z) {}

void Position::update_arguments() {
  z.noalias() = points.g * c;
  z += points.problem.offset;
}

void Position::enter_states() {
  for (int p = 0; p < points.size(); ++p) places.enter(p, z, xi);
}

void Position::classify(double shrink) {
  for (int p = 0; p < points.size(); ++p) places.classify(p, z, xi, shrink);
}

namespace {

/// Neither iterations nor points whose values are imposed get rid of a slope that stands for
/// infinity: a search begins at the break before.
int bounded_state(const PreparedLaw& law, int state, double r) {
  if (state < 0 || state % 2 == 1) return state;
  const double s = law.on_component(law.component_of_piece(state / 2), r).s;
  if (std::abs(s) < unbounded_slope) return state;
  const int at_break = s > 0.0 ? state - 1 : state + 1;
  return law.valid_state(at_break) ? at_break : state;
}

} // namespace

/// A state that the point's graph has, else the one that its argument says.
void Position::take_state(int p, int state) {
  const PreparedLaw& law = points.law(p);
  if (!law.valid_state(state)) {
    const double r = size_of(law, points[p].of(z));
    state = law.radial() && r == 0.0 ? -1 : 2 * piece_of(law.graph(), r);
  }
  state = bounded_state(law, state, size_of(law, points[p].of(z)));
  places.state[p] = state;
  places.component[p] = law.component_of_piece(std::max(state, 0) / 2);
}

void Position::load(const InequalityState& from) {
  if (from.c.size() == points.unknowns)
    c = from.c;
  else
    c.setZero();
  if (from.xi.size() == points.rows)
    xi = from.xi;
  else
    xi.setZero();
  update_arguments();
  z_start = z;
  constexpr int no_state = -2;
  const bool given = static_cast<int>(from.state.size()) == points.size();
  for (int p = 0; p < points.size(); ++p) take_state(p, given ? from.state[p] : no_state);
  enter_states();
  if (from.c_guess.size() != points.unknowns || from.xi_guess.size() != points.rows) return;
  // The resolvents at the guess give the points their states, each on its component.
  c = from.c_guess, xi = from.xi_guess;
  if (from.s_c_guess.size() == points.unknowns) balance.product.take(c, from.s_c_guess);
  update_arguments();
  classify();
}

} // namespace hvi::solver
