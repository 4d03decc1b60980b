// See body_tangent.hpp. Called by couple_states.
#include "solver/step/body_tangent.hpp"

#include "solver/formulation/formulation.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int most_directions = 40;
/// What loads read of the solution couples all points; directions are dropped before they take too
/// much room.
constexpr int most_from_inputs = 240, most_kept = 80;
/// Of Z - z: a Newton step needs no more.
constexpr double small_part = 1e-6;

} // namespace

BodyTangent::BodyTangent(const Problem& problem, const Discretisation& d,
                         const Formulation& formulation, const Evolution& evolution,
                         const PointStates& states)
    : d_(d), formulation_(formulation), evolution_(evolution), states_(states) {
  const auto& groups = formulation.contact().state_groups;
  const auto in_body = [](const StateGroup& group) { return group.body != nullptr; };
  const bool algebraic = std::ranges::any_of(problem.states, &StateTerm::algebraic);
  if (!algebraic && !std::ranges::all_of(groups, in_body)) return;
  for (const auto& group : groups)
    blocks_.push_back(in_body(group) ? std::make_unique<PointBlock>(as_block(group.body->points))
                                     : nullptr);
  for (const auto& [base, form] : formulation.operators().changing) add_form(base, *form);
  for (const LoadTerm& load : problem.state_loads) add_load(load);
}

BodyTangent::Place BodyTangent::place_of(int part) const {
  const auto& groups = formulation_.contact().state_groups;
  const auto group = std::ranges::find_if(
      groups, [&](const StateGroup& one) { return one.part == part && one.body; });
  return {&*group, blocks_[static_cast<std::size_t>(group - groups.begin())].get()};
}

SparseMatrix BodyTangent::rows(const PointBlock& points, int index, Origin origin) const {
  return restrict_columns(derivative_rows(d_.space, points, index, origin), formulation_.layout());
}

void BodyTangent::add_form(int base, const FormTerm& form) {
  const auto [group, points] = place_of(form.part);
  for (const auto& entry : form.entries)
    for (const int i : group->states) {
      const Expr change = derivative(entry.coefficient, slot::state(i));
      if (!change.is(0.0))
        parts_.push_back({base, first_of(i), form.origin, points,
                          rows(*points, entry.test, form.origin),
                          rows(*points, entry.trial, form.origin), Pointwise({&change, 1})});
    }
}

void BodyTangent::add_load(const LoadTerm& load) {
  const auto [group, points] = place_of(load.part);
  for (const auto& entry : load.entries)
    for (const int i : group->states) {
      const Expr change = -derivative(entry.value, slot::state(i));
      if (!change.is(0.0))
        parts_.push_back({-1,
                          first_of(i),
                          load.origin,
                          points,
                          rows(*points, entry.test, load.origin),
                          {},
                          Pointwise({&change, 1})});
    }
}

int BodyTangent::first_of(int state) const {
  return formulation_.contact().first_state[static_cast<std::size_t>(state)];
}

/// What a base matrix acts on in the equation of the step.
Vector BodyTangent::in_equation(const BodyPass& pass, int base) const {
  const auto weight = formulation_.operators().weights.col(base);
  std::vector<int> others;
  for (int field = 1; field < weight.size(); ++field)
    if (weight[field] != 0.0) others.push_back(field);
  const auto fields = evolution_.law_fields(pass.n, others, pass.u, &pass.d);
  const Vector shares = present_shares(evolution_.scheme(), static_cast<int>(weight.size()));
  Vector out = shares[field_of_u(0)] * weight[field_of_u(0)] * pass.u;
  for (const int field : others) out += shares[field] * weight[field] * fields[field];
  return out;
}

/// D_trial(y) at the points; of a load 1, or what a scheme takes of it at the end of the step.
Vector BodyTangent::trial_of(const BodyPass& pass, const Part& part) const {
  if (part.base >= 0) return part.trial * in_equation(pass, part.base);
  return Vector::Constant(part.test.rows(), evolution_.scheme().present(0));
}

void BodyTangent::find_q(const BodyPass& pass) {
  const Contact& contact = formulation_.contact();
  const auto column = [&](Slot s) -> const double* {
    return slot::is_state(s)
               ? contact.state_values.data() +
                     contact.first_state[static_cast<std::size_t>(s - slot::first_state)]
               : nullptr;
  };
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> coefficient;
  for (Part& part : parts_) {
    const Vector trial = trial_of(pass, part);
    coefficient.resize(part.points->size());
    part.coefficient.evaluate(*part.points, evolution_.grid().t(pass.n), part.origin, coefficient,
                              column);
    for (int p = 0; p < trial.size(); ++p) {
      const auto at = static_cast<std::size_t>(p);
      const double force = part.points->weight[at] * coefficient[at] * trial[p];
      for (SparseMatrix::InnerIterator it(part.test, p); it && force != 0.0; ++it)
        if (it.col() < formulation_.layout().n_unknowns)
          entries.emplace_back(static_cast<int>(it.col()), part.first + p, force * it.value());
    }
  }
  q_.resize(formulation_.layout().n_unknowns, contact.state_values.size());
  q_.setFromTriplets(entries.begin(), entries.end());
}

/// By which inputs follow the unknowns.
void BodyTangent::find_r(const BodyPass& pass) {
  const Contact& contact = formulation_.contact();
  r_ = contact.body_trace.leftCols(formulation_.layout().n_unknowns);
  const auto fields = evolution_.law_fields(pass.n, contact.state_fields, pass.u, &pass.d);
  for (const auto& group : contact.state_groups)
    for (std::size_t f = 0; f < group.fields.size(); ++f) {
      const int first = group.first_input + static_cast<int>(f) * group.n_points;
      for (int row = first; row < first + group.n_points; ++row)
        for (SparseMatrix::InnerIterator it(r_, row); it; ++it)
          it.valueRef() *= fields.factor(slot::field_of(group.fields[f]));
    }
}

/// v and its image, orthogonal to the images before and of length one.
bool BodyTangent::add_direction(const Vector& v, const StepMatrix& matrix,
                                const InequalityState& at) {
  const Vector force = -(q_ * v);
  std::vector<Vector> moved, multipliers;
  if (!respond(matrix, {&force, 1}, at, moved, multipliers)) return false;
  Direction out{v, v, r_ * moved.front()};
  out.image -= s_ * out.inputs;
  const double size = out.image.norm();
  for (int twice = 0; twice < 2; ++twice)
    for (const Direction& before : directions_) {
      const double part = before.image.dot(out.image);
      out.vector -= part * before.vector;
      out.inputs -= part * before.inputs;
      out.image -= part * before.image;
    }
  const double left = out.image.norm();
  if (!(left > 1e-12 * size)) return false;
  out.vector /= left, out.inputs /= left, out.image /= left;
  directions_.push_back(std::move(out));
  return true;
}

bool BodyTangent::prepare(const BodyPass& pass, const StepMatrix& matrix) {
  const bool solvable = matrix.factorisation() || matrix.laws() != nullptr;
  if (parts_.empty() || !solvable) return false;
  find_q(pass);
  find_r(pass);
  return true;
}

/// change += da of the dz that leaves nothing of `left`.
bool BodyTangent::reduce(Vector left, int most, const BodyPass& pass, const StepMatrix& matrix,
                         Vector& change) {
  directions_.clear();
  const double enough = small_part * left.norm();
  for (int n = 0; left.norm() > enough && n < most; ++n) {
    if (std::ssize(directions_) == most_kept) directions_.clear();
    if (!add_direction(left, matrix, pass.laws)) break;
    const Direction& last = directions_.back();
    const double part = last.image.dot(left);
    change += part * last.inputs;
    left -= part * last.image;
  }
  return change.allFinite();
}

bool BodyTangent::step(const BodyPass& pass, const StepMatrix& matrix, Vector& change) {
  if (!prepare(pass, matrix)) return false;
  s_ = states_.slopes(pass.inputs, pass.share, pass.solution);
  change.setZero(r_.rows());
  return reduce(pass.solution - formulation_.contact().state_values, most_directions, pass, matrix,
                change) &&
         !directions_.empty();
}

bool BodyTangent::step_from(const Vector& b, const BodyPass& pass, const StepMatrix& matrix,
                            Vector& change) {
  if (!prepare(pass, matrix)) return false;
  s_ = states_.slopes(b, pass.share, formulation_.contact().state_values);
  change = pass.inputs - b;
  return reduce(s_ * change, most_from_inputs, pass, matrix, change);
}

} // namespace hvi::solver
