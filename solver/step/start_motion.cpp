// See start_motion.hpp. Called when the state of a run is made.
#include "solver/step/start_motion.hpp"

#include "solver/formulation/halved_bases.hpp"
#include "solver/formulation/leading_forms.hpp"
#include "solver/formulation/rigid.hpp"
#include "solver/plan/couplings.hpp"
#include "solver/step/step_load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace hvi::solver {
namespace {

/// Bounds that are multipliers are found by so many passes, to this change.
constexpr int most_bound_passes = 100;
constexpr double settled = 1e-12;
/// A set of slopes smaller than this, by the largest of them, is one slope.
constexpr double one_slope = 1e-13;

/// Of the first step: so far behind the initial time a function that may have a kink there is
/// looked at. Of the largest rate in that step: a change that no smooth function makes so soon.
constexpr double behind = 1e-9, by_a_kink = 1e-6;

/// The function of t is differentiated so many times in every imposed value. At a kink it is the
/// rate with which the motion begins: `ramp` from the initial time on has one.
Vector imposed_rate(const Problem& problem, const Discretisation& d, int times, Vector out) {
  SpaceSpec rates = problem.space;
  for (auto& entry : rates.dirichlet)
    for (auto& value : entry.value)
      for (int i = 0; i < times; ++i) value = derivative(value, slot::t);
  const double t = problem.time.grid.front(), end = problem.time.grid[1];
  impose(d.space, rates, d.dofs, t, out);
  Vector later = out, at_end = out;
  impose(d.space, rates, d.dofs, t + behind * (end - t), later);
  impose(d.space, rates, d.dofs, end, at_end);
  const Vector largest = later.cwiseAbs().cwiseMax(out.cwiseAbs()).cwiseMax(at_end.cwiseAbs());
  for (Eigen::Index i = 0; i < out.size(); ++i)
    if (std::abs(later[i] - out[i]) > by_a_kink * largest[i]) out[i] = later[i];
  return out;
}

/// Two laws, of which a point's place gives the numbers: dj(0) = [x_0, x_1], and for a vector the
/// ball of radius x_0.
LawSpec support_law(bool radial) {
  LawSpec out;
  out.name = "the forces that laws leave open";
  out.radial = radial, out.by_slope = true;
  const Expr low = Expr::variable(slot::x(0)), high = Expr::variable(slot::x(1));
  const Expr negative = less(Expr::variable(slot::argument(0)), Expr(0.0));
  out.expression = radial ? low : select(negative, low, high);
  return out;
}

using Rows = Eigen::Ref<const Vector>;

/// By which arguments of laws on u move at t_0, and what that is made of.
struct ArgumentRates {
  Vector value, size;
  /// Those of a point; zero where they are rounding.
  Vector of(const ContactPoint& point) const {
    Vector out = value.segment(point.first_row, point.rows);
    if (out.norm() <= one_slope * size.segment(point.first_row, point.rows).norm()) out.setZero();
    return out;
  }
};

ArgumentRates argument_rates(const Problem& problem, const Contact& contact, double t,
                             const Vector& velocity) {
  ArgumentRates out{Vector::Zero(contact.n_rows()), Vector::Zero(contact.n_rows())};
  Vector moving;
  for (const auto& term : contact.terms) {
    if (term.field != field_of_u(0)) continue;
    LawTerm spec = problem.law_terms[static_cast<std::size_t>(term.points.law_term)];
    for (auto& row : spec.rows) row.offset = derivative(row.offset, slot::t);
    law_offsets(term.points, spec, t, moving);
    for (int row = 0; row < term.n_rows(); ++row) {
      double& value = out.value[term.first_row + row];
      double& size = out.size[term.first_row + row];
      value = moving[row], size = std::abs(moving[row]);
      for (SparseMatrix::InnerIterator it(contact.g, term.first_row + row); it; ++it) {
        value += it.value() * velocity[it.col()];
        size += std::abs(it.value() * velocity[it.col()]);
      }
    }
  }
  return out;
}

/// The laws at t_0: forces that are known, and the sets of those that are not.
class OpenForces {
public:
  /// The laws are prepared for t_0. Keeps references to both.
  OpenForces(const Contact& contact, const ArgumentRates& rates)
      : known(Vector::Zero(contact.n_rows())), problem(contact.problem), contact_(contact),
        rates_(rates), scalar_(support_law(false)), radial_(support_law(true)) {
    problem.laws = {&scalar_, &radial_};
    problem.graphs.clear();
    problem.coupled.clear();
    problem.offset.setZero();
    problem.offset_size.resize(0);
    for (auto& point : problem.points) take(point);
  }
  OpenForces(const OpenForces&) = delete; // the problem refers to the laws
  OpenForces& operator=(const OpenForces&) = delete;

  Vector known;           ///< a row each
  ReducedProblem problem; ///< of the others

private:
  void take(ContactPoint& point) {
    const Law& law = *contact_.laws[static_cast<std::size_t>(point.law)];
    const bool radial = law.spec().radial;
    const LawGraph& graph = contact_.problem.graphs[static_cast<std::size_t>(point.graph)];
    const Point set = radial ? ball(law, graph, point) : interval(law, graph, point);
    point.law = radial ? 1 : 0;
    point.graph = static_cast<int>(problem.graphs.size());
    problem.graphs.push_back((radial ? radial_ : scalar_).graph(set, 0.0));
  }

  double snap(const ContactPoint& point) const {
    return one_slope * contact_.problem.offset_size[point.first_row];
  }

  /// The ends of the open set; both 0 where the force is known.
  Point interval(const Law& law, const LawGraph& graph, const ContactPoint& point) {
    auto [low, high] = clarke(law, graph, contact_.problem.offset[point.first_row], snap(point));
    const double moves = rates_.of(point)[0];
    if (moves > 0.0 && high < unbounded_slope) low = high;
    if (moves < 0.0 && low > -unbounded_slope) high = low;
    if (high - low > one_slope * std::max(std::abs(low), std::abs(high))) return {low, high, 0.0};
    // Beyond an obstacle no force is known: the first step takes the state back.
    if (std::abs(low) < unbounded_slope) known[point.first_row] = low;
    return {};
  }

  /// The radius of the open ball; 0 where the force is known.
  Point ball(const Law& law, const LawGraph& graph, const ContactPoint& point) {
    const Rows z = contact_.problem.offset.segment(point.first_row, point.rows);
    const Vector moves = rates_.of(point);
    auto xi = known.segment(point.first_row, point.rows);
    const double r = z.norm(), speed = moves.norm();
    if (r > snap(point)) {
      const auto [low, high] = clarke(law, graph, r, snap(point));
      xi = (z.dot(moves) < 0.0 ? low : high) / r * z;
      return {};
    }
    const double radius = std::abs(law.slope(graph, 0, 0.0));
    if (!(speed > 0.0)) return {radius, 0.0, 0.0};
    xi = radius / speed * moves;
    return {};
  }

  const Contact& contact_;
  const ArgumentRates& rates_;
  Law scalar_, radial_;
};

/// M a = f on the unknowns, with laws that leave forces open; or L y = f (leading_forms.hpp).
class MassSolver {
public:
  /// Keeps references; `weights`: of the base matrices, whose sum is M.
  MassSolver(const Plan& plan, const Formulation& formulation, const Operators& operators,
             const Vector& weights)
      : plan_(plan), formulation_(formulation), matrix_(operators, formulation.contact()) {
    try {
      matrix_.factor(weights);
      if (!formulation.contact().none()) reduced_ = matrix_.reduced_operator();
    } catch (const NotFactorable&) {
      no_mass();
    }
  }

  Vector solve(const Vector& f) const {
    Vector out;
    hvi::solver::solve(*matrix_.factorisation(), f, out);
    return out;
  }

  /// The same with the open forces; xi: all multipliers.
  Vector solve(const Vector& f, const OpenForces& open, Vector& xi) const {
    const Contact& contact = formulation_.contact();
    const SharedFactor& factor = matrix_.factorisation();
    const Vector rest = f - contact.force * open.known;
    Vector r = rest, y, a;
    if (factor) forward(*factor, rest, y, r);
    InequalityOptions options;
    options.tolerance = plan_.options.tolerance;
    InequalityState state;
    state.c = Vector::Zero(r.size());
    state.xi = Vector::Zero(contact.n_rows());
    const auto report = InequalitySolver(open.problem, *reduced_, options).solve(r, state);
    if (!report.converged)
      throw Failure(FailureKind::not_certified, plan_.problem.time.origin,
                    "no acceleration at the initial time was found: " + report.verdict,
                    "use `scheme = midpoint`, which needs none");
    xi = open.known + state.xi;
    if (!factor) return state.c;
    back(*factor, state.c, y, a);
    return a;
  }

private:
  [[noreturn]] void no_mass() const {
    throw Failure(FailureKind::not_coercive, plan_.problem.time.origin,
                  fmt::format("the scheme {} starts from u'' at the initial time, and not every "
                              "unknown has a mass",
                              name_of(plan_.problem.time.scheme)),
                  "let the form in u'' act on the whole body, or use backward_euler, bdf2 or "
                  "midpoint");
  }

  const Plan& plan_;
  const Formulation& formulation_;
  FactoredMatrix matrix_;
  std::unique_ptr<ReducedOperator> reduced_;
};

/// out += f(t_0), with the initial states.
void add_loads_at_start(const Formulation& formulation, double t, Vector& out) {
  formulation.loads().add(t, out);
  formulation.state_loads().add(t, formulation.contact().state_values, 1.0, out);
}

/// f(t_0) - A v_0 - B u_0 - M a_0, a_0 the acceleration of imposed values only.
Vector forces_at_start(const Formulation& formulation, const Evolution& evolution,
                       const Vector& velocity, const Vector& imposed) {
  const Operators& operators = formulation.operators();
  Vector out = Vector::Zero(operators.n_unknowns);
  SparseMatrix room;
  add_loads_at_start(formulation, evolution.grid().t(0), out);
  for (int b = 0; b < operators.n_bases(); ++b) {
    const auto weight = operators.weights.col(b);
    const Vector state = weight[field_of_u(0)] * evolution.u() + weight[field_of_u(1)] * velocity +
                         weight[field_of_u(2)] * imposed;
    if (operators.dealt)
      add_product_of_base(operators, b, -1.0, state, out);
    else
      subtract_product(base_by_rows(operators, b, room), state, out);
  }
  return out;
}

/// Solves for what a run starts from.
class Start {
public:
  Start(const Plan& plan, const Discretisation& d, RunState& run)
      : plan_(plan), run_(run), formulation_(*run.formulation),
        orders_(orders_in_time(plan.problem)) {
    const StateLayout& layout = formulation_.layout();
    for (Vector& derivative : derivatives_) derivative = Vector::Zero(layout.n_state);
    derivatives_[0] = run.evolution.u();
    layout.gather(starting_velocity(plan.problem, d), derivatives_[1]);
    run.evolution.start_motion(derivatives_[1], derivatives_[2]);
    run.solver.equations.laws.states.start();
    if (!needed()) return;
    layout.gather(imposed_rate(plan.problem, d, 2, Vector::Zero(d.space.n_dofs())),
                  derivatives_[2]);
    if (std::ranges::all_of(orders_, [](int order) { return order == highest_derivative; })) {
      solve(formulation_.operators(),
            formulation_.operators().weights.row(field_of_u(2)).transpose(),
            forces_at_start(formulation_, run.evolution, derivatives_[1], derivatives_[2]));
      return;
    }
    require_known_arguments();
    leading_.emplace(plan.problem, d, layout);
    Operators leading;
    leading.bases = {leading_->matrix()};
    leading.weights = DenseMatrix::Ones(1, 1);
    leading.symmetric = formulation_.operators().symmetric;
    leading.coupled = formulation_.operators().coupled;
    leading.n_unknowns = layout.n_unknowns;
    Vector f = -leading_->known(derivatives_);
    add_loads_at_start(formulation_, run.evolution.grid().t(0), f);
    solve(leading, Vector::Ones(1), f);
  }

private:
  bool needed() const {
    const TimeScheme& scheme = run_.evolution.scheme();
    return scheme.needs_acceleration() ||
           (scheme.looks_back() && std::ranges::find(orders_, 0) != orders_.end());
  }

  /// A law on what is sought here has no place on its graph yet, a load that reads it no value.
  void require_known_arguments() const {
    for (const LawTerm& term : plan_.problem.law_terms)
      if (!is_memory(term.field) && term.field >= orders_[static_cast<std::size_t>(term.unknown)])
        not_known("the argument of this law is", term.origin);
    for (const StateTerm& state : plan_.problem.states)
      if (state.algebraic && reads_what_is_sought(state.rate))
        not_known("what this load reads is", state.origin);
  }

  [[noreturn]] void not_known(std::string_view what, const Origin& origin) const {
    throw Failure(FailureKind::bad_value, origin,
                  fmt::format("the scheme {} starts from a balance at the initial time, where {} "
                              "not known",
                              name_of(plan_.problem.time.scheme), what),
                  "use backward_euler or bdf2, which start from initial values alone");
  }

  bool reads_what_is_sought(const Expr& value) const {
    return std::ranges::any_of(value.slots(), [&](Slot s) {
      if (!slot::is_field(s) || is_memory(slot::field_of(s))) return false;
      const auto unknown = static_cast<std::size_t>(slot::unknown_of(slot::derivative_of(s)));
      return slot::field_of(s) >= orders_[unknown];
    });
  }

  void solve(const Operators& operators, const Vector& weights, const Vector& f) {
    const MassSolver mass(plan_, formulation_, operators, weights);
    Contact& contact = formulation_.contact();
    Vector xi = Vector::Zero(contact.n_rows());
    if (contact.none())
      take(mass.solve(f));
    else
      solve_with_laws(mass, f, xi);
    run_.solver.equations.laws.start(xi);
    run_.balance.load.note_multipliers(xi);
  }

  void solve_with_laws(const MassSolver& mass, const Vector& f, Vector& xi) {
    Evolution& evolution = run_.evolution;
    Contact& contact = formulation_.contact();
    const double t = evolution.grid().t(0);
    const auto rates = argument_rates(plan_.problem, contact, t, derivatives_[1]);
    for (int pass = 0; pass < most_bound_passes; ++pass) {
      const auto fields = evolution.law_fields(contact.other_fields);
      if (pass == 0 || leading_) read_solution(contact, t, fields, xi);
      const Vector before = xi;
      prepare(contact, plan_.problem, t, fields, xi);
      take(mass.solve(f, OpenForces(contact, rates), xi));
      if (!contact.coupled || (xi - before).norm() <= settled * xi.norm()) return;
    }
  }

  /// Of the unknowns: their second derivatives, or those that leading_ is of.
  void take(const Vector& y) {
    Evolution& evolution = run_.evolution;
    if (!leading_) {
      derivatives_[2].head(y.size()) = y;
    } else {
      for (int k = 0; k <= highest_derivative; ++k)
        leading_->put(y, k, derivatives_[static_cast<std::size_t>(k)]);
      evolution.start_from(derivatives_[0]);
    }
    evolution.start_motion(derivatives_[1], derivatives_[2]);
  }

  const Plan& plan_;
  RunState& run_;
  Formulation& formulation_;
  std::vector<int> orders_;
  std::array<Vector, 3> derivatives_; ///< states, by order
  std::optional<LeadingForms> leading_;
};

} // namespace

Vector starting_velocity(const Problem& problem, const Discretisation& d) {
  Vector out = Vector::Zero(d.space.n_dofs());
  const auto& time = problem.time;
  if (time.velocity)
    out = interpolate(d.space, *time.velocity, time.grid.front(), time.velocity_origin);
  return imposed_rate(problem, d, 1, std::move(out));
}

void start_motion(const Plan& plan, const Discretisation& d, RunState& run) { Start(plan, d, run); }

} // namespace hvi::solver
