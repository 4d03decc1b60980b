// Energies and the quantities of Lemma 3.2, step by step; see energy.hpp. Called by run.cpp.
#include "solver/results/energy.hpp"

#include "solver/common/stream.hpp"
#include "solver/discrete/inertia.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/linear/vector_stream.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

enum Sum {
  sum_work,
  sum_viscous,
  sum_memory,
  sum_lost,
  max_u,
  sum_jumps,
  max_xi,
  sum_rate,
  n_sums
};

/// Increments below this part of u are taken for rounding in the scale of the balance.
constexpr double rounding_of_rest = 1e-8;

/// The column of a law that stores nothing, or not all of its work.
std::string column_of_work(const Problem& problem, const LawTerm& term) {
  const bool rubs = term.seen.empty() && !is_memory(term.field);
  return monitor_column(problem, rubs ? "friction_" : "law_", term);
}

} // namespace

bool is_energy(std::string_view column) {
  for (const std::string_view law : {"friction_", "law_", "released_"})
    if (column.starts_with(law)) return true;
  for (const std::string_view one :
       {"work", "viscous", "memory", "elastic", "contact", "kinetic", "lost", "energy"})
    if (column == one) return true;
  return false;
}

EnergyMonitor::EnergyMonitor(const Problem& problem, const Discretisation& d, const RunState& run)
    : problem_(problem), d_(d), stored_(problem, d, run), inertia_(inertia_matrix(problem, d)),
      rate_(matrix_of_field(problem, d, field_of_u(1))),
      gram_(gram_v(d.space, d.dofs.needs_mass())),
      released_(problem, run), names_{"energy",      "elastic",    "contact",    "work",
                                      "viscous",     "memory",     "lost",       "lemma_u",
                                      "lemma_jumps", "lemma_xi",   "lemma_rate", "inclusion",
                                      "equilibrium", "iterations", "events",     "snap"},
      sums_(n_sums, 0.0) {
  const TimeScheme& scheme = run.evolution.scheme();
  moves_ = in_motion(problem);
  looks_back_ = scheme.looks_back() || problem.time.scheme == Scheme::newmark;
  energy_scale_ = 1.0 / (scheme.present(0) + scheme.past(0));
  if (moves_) names_.push_back("kinetic");
  columns_.resize(names_.size());
  for (const auto& term : problem.law_terms)
    if (term.field != field_of_u(0)) names_.push_back(column_of_work(problem, term));
  friction_.assign(names_.size() - columns_.size(), 0.0);
  names_.insert(names_.end(), released_.names().begin(), released_.names().end());
  columns_.resize(names_.size());
  for (std::size_t m = 0; m < problem.histories.size(); ++m)
    memory_.push_back(matrix_of_field(problem, d, field_of_memory(static_cast<int>(m))));
  for (Vector* v : {&u_, &before_, &d_u_, &work_}) *v = Vector::Zero(d.space.n_dofs());
  for (Forces* forces : {&now_, &last_, &acting_})
    for (const auto force : all_forces) forces->*force = Vector::Zero(d.space.n_dofs());
  run.formulation->scatter(run.evolution.u(), u_);
  take_states(run);
  elastic_energy_ = stored_.elastic(u_);
  contact_energy_ = stored_.contact(run, u_);
  kinetic_energy_ = kinetic_energy(run);
  if (!looks_back_) return;
  last_xi_ = run.xi();
  stored_.load(run, now_.load);
  forces(run);
}

/// Forms that states change are those of the run's; what that takes from the energy is lost.
void EnergyMonitor::take_states(const RunState& run) {
  if (!run.formulation->changes_forms()) return;
  const auto now = [&](int field) {
    return matrix_of_field(problem_, d_, field, run.contact(), run.states());
  };
  stored_.take_states(run);
  rate_ = now(field_of_u(1));
  for (std::size_t m = 0; m < memory_.size(); ++m)
    memory_[m] = now(field_of_memory(static_cast<int>(m)));
}

double EnergyMonitor::kinetic_energy(const RunState& run) {
  const Vector* velocity = run.evolution.scheme().velocity();
  if (velocity == nullptr) return 0.0;
  run.formulation->scatter(*velocity, work_);
  return 0.5 * work_.dot(inertia_ * work_);
}

/// M u'', A u', B u, sum_m E_m w_m and G^T W xi at the run's time.
void EnergyMonitor::forces(const RunState& run) {
  const Formulation& formulation = *run.formulation;
  const Evolution& evolution = run.evolution;
  now_.elastic.noalias() = stored_.matrix() * u_;
  now_.inertia.setZero(), now_.viscous.setZero(), now_.memory.setZero(), now_.contact.setZero();
  if (!run.evolution.grid().is_static()) {
    evolution.derivative(1, state_);
    formulation.scatter(state_, work_);
    now_.viscous.noalias() += rate_ * work_;
    for (std::size_t m = 0; m < memory_.size() && evolution.step() > 0; ++m) {
      evolution.history_field(static_cast<int>(m), state_);
      formulation.scatter(state_, work_);
      now_.memory.noalias() += memory_[m] * work_;
    }
  }
  if (moves_) {
    evolution.derivative(2, state_);
    formulation.scatter(state_, work_);
    now_.inertia.noalias() += inertia_ * work_;
  }
  const Contact& contact = run.contact();
  for (const auto& term : contact.terms) {
    Vector weighted = run.xi().segment(term.first_row, term.n_rows());
    for (int p = 0; p < term.n_points(); ++p)
      weighted.segment(p * term.points.rows, term.points.rows) *= term.points.weight[p];
    now_.contact.noalias() += term.points.g.transpose() * weighted;
  }
}

void EnergyMonitor::mix(Vector Forces::*force, double present, double past) {
  acting_.*force = energy_scale_ * (present * (now_.*force) + past * (last_.*force));
}

/// The forces of the step's equation.
void EnergyMonitor::mix_steps(const TimeScheme& scheme) {
  if (problem_.time.scheme == Scheme::newmark) {
    for (const auto force : all_forces) mix(force, 0.5, 0.5);
    acting_xi_ = 0.5 * (acting_xi_ + last_xi_);
    return;
  }
  mix(&Forces::inertia, scheme.present(2), 0.0);
  mix(&Forces::viscous, scheme.present(1), scheme.past(1));
  mix(&Forces::elastic, scheme.present(0), scheme.past(0));
  mix(&Forces::memory, scheme.present(0), scheme.past(0));
  mix(&Forces::contact, 1.0, scheme.past_of_laws());
  acting_xi_ = energy_scale_ * (acting_xi_ + scheme.past_of_laws() * last_xi_);
  const bool mean = problem_.time.sampling == LoadSampling::average &&
                    problem_.time.scheme == Scheme::midpoint; // it stands for both ends
  mix(&Forces::load, mean ? 1.0 : scheme.present(0), mean ? 0.0 : scheme.past(0));
}

/// The laws on rates: what they dissipate in the step.
void EnergyMonitor::add_friction(const RunState& run) {
  auto sum = friction_.begin();
  for (const auto& term : run.contact().terms) {
    if (term.field == field_of_u(0)) continue;
    const Vector slip = term.points.g * d_u_;
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = run.contact().problem.points[term.first_point + p];
      *sum += point.weight * acting_xi_.segment(point.first_row, point.rows)
                                 .dot(slip.segment(p * point.rows, point.rows));
    }
    ++sum;
  }
}

/// The step's displacement, what its states release, and its forces.
void EnergyMonitor::take_forces(const RunState& run) {
  before_.swap(u_);
  run.formulation->scatter(run.evolution.u(), u_);
  d_u_ = u_ - before_;
  if (looks_back_) std::swap(now_, last_);
  const auto of_forms = [&] {
    return 0.5 * (released_.of_mean_forces() ? u_ : before_).dot(stored_.matrix() * before_);
  };
  const double stored = released_.of_forms() ? of_forms() : 0.0;
  take_states(run);
  if (released_.of_forms()) released_.add_forms(stored - of_forms());
  released_.add_laws(run, before_);
  stored_.load(run, now_.load);
  forces(run);
  acting_xi_ = run.xi();
  if (looks_back_) mix_steps(run.evolution.scheme()), last_xi_ = run.xi();
}

/// The work of the reactions. On the unknowns the parts add up to the load, which is checked; on
/// imposed values the rest is the reaction.
double EnergyMonitor::reaction_work(const Forces& acting) {
  work_ = acting.viscous + acting.elastic + acting.memory + acting.contact - acting.load;
  if (moves_) work_ += acting.inertia;
  double reaction = 0, error = 0, size = 0;
  for (const auto& e : d_.dofs.eliminated) reaction += work_[e.dof] * d_u_[e.dof];
  for (const auto i : d_.dofs.free) error += work_[i] * d_u_[i];
  for (const DofLink& link : d_.dofs.links) error += work_[link.dof] * d_u_[link.dof];
  // What all forces would do on u itself is the scale of rounding where nothing moves.
  double at_rest = 0;
  for (const auto force : all_forces) {
    if (force == &Forces::load) continue;
    size += (acting.*force).cwiseAbs().dot(d_u_.cwiseAbs());
    at_rest += (acting.*force).cwiseAbs().dot(u_.cwiseAbs());
  }
  size = std::max(size, rounding_of_rest * at_rest);
  largest_error_ = std::max(largest_error_, std::abs(error));
  largest_size_ = std::max(largest_size_, size);
  return reaction;
}

void EnergyMonitor::add_sums(const RunState& run, const Forces& acting, double reaction) {
  const double viscous = acting.viscous.dot(d_u_), memory = acting.memory.dot(d_u_);
  const double work = acting.load.dot(d_u_) + reaction, elastic = 0.5 * now_.elastic.dot(u_),
               contact = stored_.contact(run, u_), kinetic = kinetic_energy(run);
  const double k = run.evolution.grid().length(run.evolution.step()), jump = norm_squared(d_u_);
  double xi = 0;
  for (const auto& point : run.contact().problem.points)
    xi += point.weight * run.xi().segment(point.first_row, point.rows).squaredNorm();
  sums_[sum_work] += work, sums_[sum_viscous] += viscous, sums_[sum_memory] += memory;
  sums_[sum_lost] += work - viscous - memory - (elastic - elastic_energy_) -
                     (contact - contact_energy_) - (kinetic - kinetic_energy_);
  sums_[max_u] = std::max(sums_[max_u], std::sqrt(norm_squared(u_)));
  sums_[sum_jumps] += jump, sums_[sum_rate] += jump / k;
  sums_[max_xi] = std::max(sums_[max_xi], std::sqrt(xi));
  elastic_energy_ = elastic, contact_energy_ = contact, kinetic_energy_ = kinetic;
}

void EnergyMonitor::take(const RunState& run, const StepResult& outcome) {
  take_forces(run);
  const Forces& acting = looks_back_ ? acting_ : now_;
  add_sums(run, acting, reaction_work(acting));
  add_friction(run);
  std::vector<double> row = {kinetic_energy_ + elastic_energy_ + contact_energy_ -
                                 now_.load.dot(u_),
                             elastic_energy_,
                             contact_energy_,
                             sums_[sum_work],
                             sums_[sum_viscous],
                             sums_[sum_memory],
                             sums_[sum_lost],
                             sums_[max_u],
                             sums_[sum_jumps],
                             sums_[max_xi],
                             sums_[sum_rate],
                             outcome.inclusion.worst,
                             outcome.equilibrium,
                             static_cast<double>(outcome.inequality.iterations),
                             static_cast<double>(outcome.inequality.events),
                             outcome.snap ? 1.0 : 0.0};
  if (moves_) row.push_back(kinetic_energy_);
  row.insert(row.end(), friction_.begin(), friction_.end());
  row.insert(row.end(), released_.sums().begin(), released_.sums().end());
  for (std::size_t c = 0; c < columns_.size(); ++c) columns_[c].push_back(row[c]);
}

void EnergyMonitor::save(std::ostream& out) const {
  StateWriter w(out);
  put_vector(w, u_);
  w.put(std::array<double, 5>{elastic_energy_, contact_energy_, kinetic_energy_, largest_error_,
                              largest_size_});
  if (looks_back_)
    for (const auto force : all_forces) put_vector(w, now_.*force);
  if (looks_back_) put_vector(w, last_xi_);
  w.put(sums_);
  w.put(friction_);
  released_.save(w);
  for (const auto& column : columns_) w.put(column);
}

void EnergyMonitor::restore(std::istream& in, std::size_t rows, const RunState& run) {
  take_states(run);
  StateReader r(in, {});
  get_vector(r, u_, u_.size());
  const auto numbers = r.get<std::array<double, 5>>();
  elastic_energy_ = numbers[0], contact_energy_ = numbers[1], kinetic_energy_ = numbers[2];
  largest_error_ = numbers[3], largest_size_ = numbers[4];
  if (looks_back_)
    for (const auto force : all_forces) get_vector(r, now_.*force, u_.size());
  if (looks_back_) get_vector(r, last_xi_, run.contact().n_rows());
  sums_ = r.get_vector<double>(sums_.size());
  friction_ = r.get_vector<double>(friction_.size());
  released_.restore(r);
  for (auto& column : columns_) column = r.get_vector<double>(rows);
}

} // namespace hvi::solver
