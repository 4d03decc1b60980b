// See state_tangent.hpp. Called by couple_states.
#include "solver/step/state_tangent.hpp"

#include "solver/linear/sparse_lu.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// The stiffness that holds a resting point in a linear step, over the body's own at the point.
constexpr double holding_factor = 1e8;
/// Of difference quotients.
constexpr double relative_change = 1e-6;

using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, slot::most_arguments,
                            slot::most_arguments>;
using Direction = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, slot::most_arguments, 1>;

/// Where a point is on its graph: 2 i in piece i, 2 i + 1 at break i, -1 at a radial law's origin.
struct Place {
  int state = 0;
  double r = 0.0; ///< argument, of a radial law its norm
  Direction e;    ///< its direction; a scalar law: 1
  bool at_break() const { return state >= 0 && state % 2 == 1; }
  int index() const { return state / 2; }
};

Place place_of(const Law& law, const ContactPoint& point, int state, const Vector& z) {
  Place out;
  const auto argument = z.segment(point.first_row, point.rows);
  out.state = state;
  out.e = Direction::Ones(1);
  out.r = argument[0];
  if (!law.spec().radial) return out;
  out.r = argument.norm();
  out.e = out.r > 0.0 ? Direction(argument / out.r) : Direction::Zero(point.rows);
  return out;
}

/// d xi / d z with the place held.
Block slope_at(const Law& law, const LawGraph& graph, const Place& place, int rows, double hold) {
  if (place.state < 0) return hold * Block::Identity(rows, rows);
  double slope = 0.0, curvature = hold;
  if (place.at_break()) {
    slope = graph.right[static_cast<std::size_t>(place.index())];
  } else {
    law.slope_and_curvature(graph, place.index(), place.r, slope, curvature);
  }
  if (!law.spec().radial) return Block::Constant(1, 1, curvature);
  const Block along = place.e * place.e.transpose();
  const double across = place.r > 0.0 ? slope / place.r : 0.0;
  return curvature * along + across * (Block::Identity(rows, rows) - along);
}

/// By how much the radial multiplier at a place changes when its graph becomes `other`.
double moved_multiplier(const Law& law, const LawGraph& graph, const LawGraph& other,
                        const Place& place, double hold) {
  if (place.state < 0 || other.pieces() != graph.pieces()) return 0.0;
  const auto i = static_cast<std::size_t>(place.index());
  const double out = place.at_break() ? -hold * (other.breaks[i] - graph.breaks[i])
                                      : law.slope(other, place.index(), place.r) -
                                            law.slope(graph, place.index(), place.r);
  return std::isfinite(out) ? out : 0.0;
}

std::optional<LawGraph> graph_at(const Law& law, const LawGraph& graph, const LawTime& t) {
  try {
    return law.graph(graph.x, t);
  } catch (const Failure&) { // outside what the law is defined for
    return std::nullopt;
  }
}

} // namespace

StateTangent::StateTangent(const Problem& problem, const Contact& contact,
                           const PointStates& states, const StepMatrix& matrix)
    : problem_(problem), contact_(contact), states_(states), matrix_(matrix),
      lu_(matrix.reduced()->unsymmetric()) {
  Vector weights(contact.n_rows());
  for (const auto& point : contact.problem.points)
    weights.segment(point.first_row, point.rows).setConstant(point.weight);
  force_ = SparseMatrix(contact.problem.g.transpose()) * weights.asDiagonal();
}

double StateTangent::factor_of(const ContactTerm& term, int row) const {
  const auto& factors = matrix_.law_factors();
  return factors.empty()
             ? 1.0
             : factors[static_cast<std::size_t>(slot::most_arguments * term.points.law_term + row)];
}

double StateTangent::holding(const ContactPoint& point, double factor) const {
  double stiffness = 0.0, size = 0.0;
  for (int row = point.first_row; row < point.first_row + point.rows; ++row)
    for (SparseMatrix::InnerIterator it(contact_.problem.g, row); it; ++it) {
      stiffness = std::max(stiffness, std::abs(matrix_.contact_diagonal()[it.col()]));
      size = std::max(size, it.value() * it.value());
    }
  return size > 0.0 ? holding_factor * stiffness / (point.weight * factor * size) : 0.0;
}

/// A small one, into the range of the state.
double StateTangent::change_of_state(int state, int p) const {
  const auto& spec = problem_.states[static_cast<std::size_t>(state)];
  const double value = contact_.state_values[contact_.first_state[state] + p];
  const double size =
      std::max({std::abs(value), 1e-3 * contact_.state_values.lpNorm<Eigen::Infinity>(), 1e-12});
  const double step = relative_change * size;
  return value + step <= spec.high ? step : -step;
}

void StateTangent::add_point(const ContactTerm& term, int p, const StatePass& pass) {
  const auto index = static_cast<std::size_t>(term.first_point + p);
  const auto& point = contact_.problem.points[index];
  const Law& law = *contact_.laws[point.law];
  const LawGraph& graph = contact_.problem.graphs[point.graph];
  const double hold = holding(point, factor_of(term, 0));
  const Place place = place_of(law, point, pass.laws.state[index], pass.z);
  const Block slope = slope_at(law, graph, place, point.rows, hold);
  for (int a = 0; a < point.rows; ++a)
    for (int b = 0; b < point.rows; ++b) {
      if (slope(a, b) == 0.0) continue;
      const int row = point.first_row + b;
      for (SparseMatrix::InnerIterator it(contact_.problem.g, row); it; ++it)
        stiffness_.emplace_back(point.first_row + a, static_cast<int>(it.col()),
                                slope(a, b) * factor_of(term, b) * it.value());
      for (const auto& offset : offsets_)
        if (offset.row() == row)
          by_state_.emplace_back(point.first_row + a, offset.col(), slope(a, b) * offset.value());
    }
  const auto add = [&](auto& entries, int column, double change, const LawTime& t) {
    const auto other = graph_at(law, graph, t);
    if (!other) return;
    const double rate = moved_multiplier(law, graph, *other, place, hold) / change;
    for (int a = 0; a < point.rows && rate != 0.0; ++a)
      entries.emplace_back(point.first_row + a, column, rate * place.e[a]);
  };
  const auto& states = law.spec().states;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const double change = change_of_state(states[k], p);
    LawTime t = graph.t;
    t.states[k] += change;
    add(by_state_, term.first_states[k] + p, change, t);
  }
  if (term.coupled_row < 0) return;
  LawTime t = graph.t;
  const double size =
      std::max(std::abs(t.coupled), relative_change * pass.laws.xi.lpNorm<Eigen::Infinity>());
  const double change = std::copysign(relative_change * std::max(size, 1e-300), t.coupled);
  t.coupled += change;
  add(by_multiplier_, term.coupled_row + p, change, t);
}

/// d offset / d state at all points of a term.
void StateTangent::add_offsets(const ContactTerm& term) {
  offsets_.clear();
  if (!term.offset_of_states) return;
  Vector base, moved;
  offsets_of(contact_, problem_, term, states_.t(), contact_.state_values, base);
  const auto& spec = problem_.law_terms[term.points.law_term];
  for (std::size_t i = 0; i < problem_.states.size(); ++i) {
    const Slot s = slot::state(static_cast<int>(i));
    if (std::ranges::none_of(spec.rows, [&](const auto& row) { return row.offset.depends_on(s); }))
      continue;
    Vector values = contact_.state_values;
    const int first = contact_.first_state[i];
    for (int p = 0; p < term.n_points(); ++p)
      values[first + p] += change_of_state(static_cast<int>(i), p);
    offsets_of(contact_, problem_, term, states_.t(), values, moved);
    for (int p = 0; p < term.n_points(); ++p)
      for (int r = p * term.points.rows; r < (p + 1) * term.points.rows; ++r) {
        const double rate = (moved[r] - base[r]) / change_of_state(static_cast<int>(i), p);
        if (rate != 0.0) offsets_.emplace_back(term.first_row + r, first + p, rate);
      }
  }
}

/// A and X, those of laws that read others' multipliers with what these change.
void StateTangent::assemble(const StatePass& pass) {
  stiffness_.clear(), by_state_.clear(), by_multiplier_.clear();
  for (const auto& term : contact_.terms) {
    add_offsets(term);
    for (int p = 0; p < term.n_points(); ++p) add_point(term, p, pass);
  }
  a_.resize(contact_.n_rows(), contact_.problem.g.cols());
  a_.setFromTriplets(stiffness_.begin(), stiffness_.end());
  x_.resize(contact_.n_rows(), contact_.state_values.size());
  x_.setFromTriplets(by_state_.begin(), by_state_.end());
  if (by_multiplier_.empty()) return;
  SparseMatrix coupling(contact_.n_rows(), contact_.n_rows());
  coupling.setFromTriplets(by_multiplier_.begin(), by_multiplier_.end());
  a_ = SparseMatrix(a_ + SparseMatrix(coupling * a_));
  x_ = SparseMatrix(x_ + SparseMatrix(coupling * x_));
}

bool StateTangent::step(const StatePass& pass, Vector& change) {
  if (pass.laws.state.size() != contact_.problem.points.size()) return false;
  assemble(pass);
  const SparseMatrix s = states_.slopes(pass.inputs, pass.share, pass.solution);
  const SparseMatrix r = states_.by_unknowns(), phi = states_.by_multipliers();
  const SparseMatrix inputs_by_c = r + SparseMatrix(phi * a_);
  SparseMatrix z_by_c = s * inputs_by_c;
  Vector left = pass.solution - contact_.state_values;
  if (phi.nonZeros() > 0) {
    SparseMatrix within(s.rows(), s.rows());
    within.setIdentity();
    within = SparseMatrix(within - SparseMatrix(SparseMatrix(s * phi) * x_));
    SparseLu lu;
    if (!lu.factor(within)) return false;
    z_by_c = lu.solve(z_by_c);
    left = lu.solve(left);
  }
  const SparseMatrix h = force_ * SparseMatrix(a_ + SparseMatrix(x_ * z_by_c));
  if (!lu_->factor(h, {})) return false;
  Vector c;
  lu_->solve(-(force_ * (x_ * left)), c);
  if (!c.allFinite()) return false;
  const Vector moved = left + z_by_c * c;
  change = r * c + phi * (a_ * c + x_ * moved);
  return change.allFinite();
}

} // namespace hvi::solver
