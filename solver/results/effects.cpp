// See effects.hpp. Called by the reporter in report.cpp.
#include "solver/results/effects.hpp"

#include "solver/common/stream.hpp"
#include "solver/fem/periodic.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

using State = EffectNote::State;
using Rows = Eigen::Ref<const Vector>;

/// s with xi = s z in every row, if there is one (to 1e-9 of the largest xi).
double common_slope(const Rows& z, const Rows& xi) {
  Eigen::Index row = 0;
  const double largest = xi.cwiseAbs().maxCoeff(&row);
  const double slope = xi[row] / z[row];
  const bool linear = (xi - slope * z).cwiseAbs().maxCoeff() <= 1e-9 * largest;
  return linear ? slope : std::numeric_limits<double>::quiet_NaN();
}

const char* text_of(LoadAssembler::Cost cost) {
  switch (cost) {
  case LoadAssembler::Cost::nothing:
    return "it is zero";
  case LoadAssembler::Cost::once:
    return "the same at all times: assembled once";
  case LoadAssembler::Cost::once_per_factor:
    return "separable in time: assembled once for each function of time";
  case LoadAssembler::Cost::every_step:
    return "not separable in time: assembled at every step";
  }
  return "";
}

} // namespace

void LawRange::note(const RunState& run) {
  const Contact& contact = run.contact();
  for (const auto& term : contact.terms) {
    char& reached = reached_[term.points.law_term];
    double& slope = slopes_[term.points.law_term];
    if (reached == acted && std::isnan(slope)) continue;
    const auto z = run.trial.z.segment(term.first_row, term.n_rows());
    const auto xi = run.xi().segment(term.first_row, term.n_rows());
    if (xi.isZero(0.0)) {
      // At rest with an argument: a law that acts later, or did before, is no line through zero.
      if (z.isZero(0.0)) continue;
      if (reached == acted) slope = std::numeric_limits<double>::quiet_NaN();
      reached = std::max(reached, moved);
      continue;
    }
    const double now = common_slope(z, xi);
    const bool first = reached != acted;
    const bool same = first ? reached != moved : std::abs(now - slope) <= 1e-9 * std::abs(slope);
    slope = same ? now : std::numeric_limits<double>::quiet_NaN();
    reached = acted;
  }
}

void LawRange::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(reached_);
  w.put(slopes_);
}

void LawRange::restore(std::istream& in) {
  StateReader r(in, {});
  reached_ = r.get_vector<char>(reached_.size());
  slopes_ = r.get_vector<double>(slopes_.size());
}

std::vector<EffectNote> found_effects(const Problem& problem, const Discretisation& discretisation,
                                      const RunState& run) {
  std::vector<EffectNote> out;
  const int dim = discretisation.mesh.dim;
  for (int a = 0; a < 3; ++a)
    out.push_back(
        {fmt::format("space dimension {}", "xyz"[a]), a < dim ? State::on : State::off,
         a < dim ? problem.mesh.origin : Origin{},
         a < dim ? "" : fmt::format("the mesh has {} dimension{}", dim, dim == 1 ? "" : "s")});
  if (discretisation.mesh.axisymmetric)
    out.push_back({"axisymmetry", State::on, problem.mesh.origin,
                   problem.space.vector ? "integrals carry 2 pi x, strains the hoop part u_x/x; "
                                          "u_x = 0 on the axis"
                                        : "integrals carry 2 pi x"});
  for (const PeriodicNote& note :
       periodic_notes(discretisation.space, problem, discretisation.parts))
    out.push_back({note.condition, State::on, note.origin, note.found});
  if (!problem.space.more.empty()) {
    std::string names;
    for (const UnknownSpec& unknown : unknowns_of(problem.space))
      names += fmt::format("{}`{}` in P{}", names.empty() ? "" : ", ", unknown.name, unknown.order);
    out.push_back({"several unknowns", State::on, problem.space.more.front().origin,
                   names + (run.formulation->operators().coupled ? "; forms couple them"
                                                                 : "; no form couples them")});
  }
  const bool symmetric = run.formulation->operators().symmetric;
  out.push_back({"symmetry",
                 symmetric ? State::on : State::off,
                 {},
                 symmetric ? "all matrices are symmetric: one triangle is factored (Cholesky)"
                 : run.formulation->operators().coupled
                     ? "unknowns act on each other: LU with pivots by size (UMFPACK)"
                     : "a matrix is not symmetric: LU"});
  for (const LoadTerm& load : problem.loads)
    out.push_back({fmt::format("load on `{}`", problem.parts[load.part].name), State::on,
                   load.origin, text_of(run.formulation->loads().cost(load.origin))});
  for (const LoadTerm& load : problem.state_loads)
    out.push_back({fmt::format("load on `{}`", problem.parts[load.part].name), State::on,
                   load.origin,
                   reads_solution(problem, load) ? "reads the solution, found with each step"
                                                 : "reads states, found with each step"});
  return out;
}

std::vector<EffectNote> effects_of_run(const Problem& problem, const LawRange& range) {
  auto out = problem.effects;
  for (auto& effect : out) {
    if (effect.state != State::on || effect.origin.id < 0) continue;
    for (std::size_t l = 0; l < problem.law_terms.size(); ++l) {
      if (effect.origin != problem.law_terms[l].origin) continue;
      if (range.asleep(l)) {
        effect.state = State::asleep;
        effect.why = "its multiplier was zero at every point and step";
      } else if (std::isfinite(range.slope(l))) {
        effect.why =
            fmt::format("linear on the range reached: {:.6g} times its argument", range.slope(l));
      }
    }
  }
  return out;
}

} // namespace hvi::solver
