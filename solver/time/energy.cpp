// Energies and the quantities of Lemma 3.2, step by step; see energy.hpp. Called by run.cpp.
#include "solver/time/energy.hpp"

#include "solver/common/stream.hpp"
#include "solver/time/operators.hpp"
#include "solver/time/saved_state.hpp"

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

double asymmetry(const SparseMatrix& k) {
  const SparseMatrix skew = SparseMatrix(k - SparseMatrix(k.transpose()));
  double size = 0, off = 0;
  for (int e = 0; e < k.nonZeros(); ++e) size = std::max(size, std::abs(k.valuePtr()[e]));
  for (int e = 0; e < skew.nonZeros(); ++e) off = std::max(off, std::abs(skew.valuePtr()[e]));
  return size > 0 ? off / size : 0.0;
}

/// The column of a law that stores nothing: its name, and where that stands on several parts the
/// part's.
std::string column_of(const Problem& problem, const LawTerm& term) {
  const std::string name = (is_memory(term.field) ? "law_" : "friction_") + term.name;
  const auto same = std::ranges::count(problem.law_terms, term.name, &LawTerm::name);
  return same > 1 ? name + "_" + problem.parts[static_cast<std::size_t>(term.part)].name : name;
}

} // namespace

EnergyMonitor::EnergyMonitor(const Problem& problem, const Discretisation& d, const RunState& run)
    : problem_(problem), d_(d), rate_(matrix_of_field(problem, d, field_of_u(1))),
      elastic_(matrix_of_field(problem, d, field_of_u(0))),
      gram_(gram_v(d.space, d.dofs.eliminated.empty())),
      loads_(d.space, d.parts, problem.loads), names_{"energy",      "elastic",    "contact",
                                                      "work",        "viscous",    "memory",
                                                      "lost",        "lemma_u",    "lemma_jumps",
                                                      "lemma_xi",    "lemma_rate", "inclusion",
                                                      "equilibrium", "iterations", "events",
                                                      "snap"},
      sums_(n_sums, 0.0), columns_(names_.size()) {
  for (const auto& term : problem.law_terms)
    if (term.field != field_of_u(0)) names_.push_back(column_of(problem, term));
  friction_.assign(names_.size() - columns_.size(), 0.0);
  columns_.resize(names_.size());
  for (std::size_t m = 0; m < problem.histories.size(); ++m)
    memory_.push_back(matrix_of_field(problem, d, field_of_memory(static_cast<int>(m))));
  symmetric_ = asymmetry(elastic_) <= 1e-12;
  for (Vector* v : {&u_, &before_, &d_u_, &f_, &work_, &viscous_force_, &elastic_force_,
                    &memory_force_, &contact_force_})
    *v = Vector::Zero(d.space.n_dofs());
  z_ = Vector::Zero(run.contact().n_rows());
  run.formulation->scatter(run.evolution.u(), u_);
  elastic_energy_ = 0.5 * u_.dot(elastic_ * u_);
  contact_energy_ = contact_energy(run, u_);
}

/// sum_p w_p j(z_p) of the laws on u with the laws and offsets of the run's time.
double EnergyMonitor::contact_energy(const RunState& run, const Vector& u) {
  const Contact& contact = run.contact();
  z_ = contact.offset;
  double sum = 0;
  for (const auto& term : contact.terms) {
    if (term.field != field_of_u(0)) continue;
    z_.segment(term.first_row, term.n_rows()) += term.points.g * u;
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = contact.problem.points[term.first_point + p];
      const auto& graph = contact.problem.graphs[point.graph];
      const auto z = z_.segment(point.first_row, point.rows);
      const double r = contact.laws[point.law]->spec().radial ? z.norm() : z[0];
      sum += point.weight * contact.laws[point.law]->potential(graph, piece_of(graph, r), r);
    }
  }
  return sum;
}

void EnergyMonitor::load(const RunState& run) {
  const auto& grid = run.evolution.grid();
  const int n = run.evolution.step();
  f_.setZero();
  if (problem_.time.sampling == LoadSampling::average && !grid.is_static() && n > 0)
    loads_.add_mean(grid.t(n - 1), grid.t(n), f_);
  else
    loads_.add(grid.t(n), f_);
}

double EnergyMonitor::energy(const RunState& run) {
  run.formulation->scatter(run.evolution.u(), work_);
  load(run);
  return 0.5 * work_.dot(elastic_ * work_) + contact_energy(run, work_) - f_.dot(work_);
}

/// A u', B u, sum_m E_m w_m and G^T W xi.
void EnergyMonitor::forces(const RunState& run) {
  const Formulation& formulation = *run.formulation;
  const Evolution& evolution = run.evolution;
  elastic_force_.noalias() = elastic_ * u_;
  viscous_force_.setZero(), memory_force_.setZero(), contact_force_.setZero();
  if (!run.evolution.grid().is_static()) {
    evolution.derivative(1, state_);
    formulation.scatter(state_, work_);
    viscous_force_.noalias() += rate_ * work_;
    for (std::size_t m = 0; m < memory_.size(); ++m) {
      evolution.history_field(static_cast<int>(m), state_);
      formulation.scatter(state_, work_);
      memory_force_.noalias() += memory_[m] * work_;
    }
  }
  const Contact& contact = run.contact();
  for (const auto& term : contact.terms) {
    Vector weighted = run.xi().segment(term.first_row, term.n_rows());
    for (int p = 0; p < term.n_points(); ++p)
      weighted.segment(p * term.points.rows, term.points.rows) *= term.points.weight[p];
    contact_force_.noalias() += term.points.g.transpose() * weighted;
  }
}

/// The laws on rates: what they dissipate in the step.
void EnergyMonitor::add_friction(const RunState& run) {
  auto sum = friction_.begin();
  for (const auto& term : run.contact().terms) {
    if (term.field == field_of_u(0)) continue;
    const Vector slip = term.points.g * d_u_;
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = run.contact().problem.points[term.first_point + p];
      *sum += point.weight * run.xi()
                                 .segment(point.first_row, point.rows)
                                 .dot(slip.segment(p * point.rows, point.rows));
    }
    ++sum;
  }
}

void EnergyMonitor::take(const RunState& run, const StepResult& outcome) {
  before_.swap(u_);
  run.formulation->scatter(run.evolution.u(), u_);
  d_u_ = u_ - before_;
  load(run);
  forces(run);
  // On the unknowns the parts add up to the load; on imposed values the rest is the reaction.
  work_ = viscous_force_ + elastic_force_ + memory_force_ + contact_force_ - f_;
  const double viscous = viscous_force_.dot(d_u_), memory = memory_force_.dot(d_u_);
  double reaction = 0, error = 0, size = 0;
  for (const auto& e : d_.dofs.eliminated) reaction += work_[e.dof] * d_u_[e.dof];
  for (const auto i : d_.dofs.free) error += work_[i] * d_u_[i];
  for (const Vector* force : {&viscous_force_, &elastic_force_, &memory_force_, &contact_force_})
    size += force->cwiseAbs().dot(d_u_.cwiseAbs());
  largest_error_ = std::max(largest_error_, std::abs(error));
  largest_size_ = std::max(largest_size_, size);

  const double work = f_.dot(d_u_) + reaction, elastic = 0.5 * elastic_force_.dot(u_),
               contact = contact_energy(run, u_);
  const double k = run.evolution.grid().length(run.evolution.step()), jump = norm_squared(d_u_);
  double xi = 0;
  for (const auto& point : run.contact().problem.points)
    xi += point.weight * run.xi().segment(point.first_row, point.rows).squaredNorm();
  sums_[sum_work] += work, sums_[sum_viscous] += viscous, sums_[sum_memory] += memory;
  sums_[sum_lost] +=
      work - viscous - memory - (elastic - elastic_energy_) - (contact - contact_energy_);
  sums_[max_u] = std::max(sums_[max_u], std::sqrt(norm_squared(u_)));
  sums_[sum_jumps] += jump, sums_[sum_rate] += jump / k;
  sums_[max_xi] = std::max(sums_[max_xi], std::sqrt(xi));
  elastic_energy_ = elastic, contact_energy_ = contact;
  add_friction(run);
  std::vector<double> row = {elastic + contact - f_.dot(u_),
                             elastic,
                             contact,
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
  row.insert(row.end(), friction_.begin(), friction_.end());
  for (std::size_t c = 0; c < columns_.size(); ++c) columns_[c].push_back(row[c]);
}

void EnergyMonitor::save(std::ostream& out) const {
  StateWriter w(out);
  put_vector(w, u_);
  w.put(std::array<double, 4>{elastic_energy_, contact_energy_, largest_error_, largest_size_});
  w.put(sums_);
  w.put(friction_);
  for (const auto& column : columns_) w.put(column);
}

void EnergyMonitor::restore(std::istream& in, std::size_t rows) {
  StateReader r(in, {});
  get_vector(r, u_, u_.size());
  const auto numbers = r.get<std::array<double, 4>>();
  elastic_energy_ = numbers[0], contact_energy_ = numbers[1];
  largest_error_ = numbers[2], largest_size_ = numbers[3];
  sums_ = r.get_vector<double>(sums_.size());
  friction_ = r.get_vector<double>(friction_.size());
  for (auto& column : columns_) column = r.get_vector<double>(rows);
}

} // namespace hvi::solver
