// The probes of a report; see probes.hpp.
#include "solver/results/probes.hpp"

#include "solver/discrete/domains.hpp"
#include "solver/discrete/fields_read.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// The derivative index of the value of a component of the space.
int value_of(const Space& space, int component) {
  const int b = space.block_of(component);
  return slot::of_unknown(b,
                          slot::value(component - space.blocks[static_cast<std::size_t>(b)].first));
}

template <class... F>
struct Match : F... {
  using F::operator()...;
};
template <class... F>
Match(F...) -> Match<F...>;

} // namespace

ProbeSet::ProbeSet(const Problem& problem, std::vector<Probe> probes, const Discretisation& d,
                   const RunState& run)
    : space_(d.space), parts_(d.parts), contact_(run.contact()), probes_(std::move(probes)),
      n_fields_(count_fields(problem)), reactions_(problem, d, run, probes_) {
  const CellLocator locator(d.mesh, probes_.size());
  for (const auto& probe : probes_) evaluators_.push_back(make(probe, problem, d, locator));
}

ProbeSet::Evaluator ProbeSet::make(const Probe& probe, const Problem& problem,
                                   const Discretisation& d, const CellLocator& locator) {
  const auto at_law_points = [&] {
    return reads_multiplier(probe.expression) ||
           d.parts[static_cast<std::size_t>(probe.part)].is_pair();
  };
  const auto on_law = [&] {
    return LawSampler(problem, d, contact_, {probe.expression}, probe.origin, probe.part);
  };
  switch (probe.kind) {
  case Probe::Kind::reaction:
    return OfSteps{};
  case Probe::Kind::largest:
  case Probe::Kind::smallest: {
    const auto which = probe.kind == Probe::Kind::largest ? Extreme::largest : Extreme::smallest;
    if (at_law_points()) return OnLaw{which, on_law()};
    return OnRegion{which, probe.part};
  }
  case Probe::Kind::combination:
    return Combination{};
  case Probe::Kind::norm_v:
    return SpaceNorm(d, probe.unknown);
  case Probe::Kind::integral:
    if (at_law_points()) return on_law();
    return Integrator(space_, d.parts[probe.part], probe.rule, {probe.expression});
  case Probe::Kind::at_point:
    break;
  }
  if (probe.on_pair) return LawSampler::at_pair(problem, d, contact_, probe);
  Expr expression = probe.expression;
  if (reads_multiplier(expression)) {
    auto found = LawSampler::at(problem, d, contact_, expression, probe.origin, probe.point);
    if (found) return std::move(*found);
    expression = away_from_states(problem, expression);
  }
  std::array<double, 4> barycentric{};
  int cell = locator.find(probe.point, barycentric);
  if (cell >= 0)
    cell = cell_that_reads(d, probe.expression, probe.point, cell, barycentric, probe.part);
  if (cell < 0)
    throw Failure(FailureKind::bad_value, probe.origin,
                  "the point of `" + probe.name + "` is outside the mesh");
  return AtPoint{cell, barycentric, PointValue(space_, expression, cell, barycentric)};
}

std::vector<Expr> ProbeSet::expressions() const {
  std::vector<Expr> out;
  for (const auto& probe : probes_)
    out.push_back(probe.kind == Probe::Kind::norm_v
                      ? Expr::variable(slot::field(field_of_u(0), slot::value(0)))
                      : probe.expression);
  const auto of_reactions = reactions_.fields();
  for (int k = 0; k < n_fields_; ++k)
    if (of_reactions[static_cast<std::size_t>(k)])
      out.push_back(Expr::variable(slot::field(k, slot::value(0))));
  return out;
}

double ProbeSet::value(int i, const Snapshot& snapshot, const Snapshot& before) {
  return std::visit(Match{[&](AtPoint& at) { return at.value(snapshot.values()); },
                          [&](const Integrator& integrator) {
                            double out = 0;
                            integrator.integrate(snapshot.values(), {&out, 1});
                            return out;
                          },
                          [&](LawSampler& sampler) { return sampler.integral(contact_, snapshot); },
                          [&](const OnRegion& on) {
                            return extreme_value(space_, parts_[static_cast<std::size_t>(on.part)],
                                                 probes_[static_cast<std::size_t>(i)].expression,
                                                 snapshot.values(), on.which);
                          },
                          [&](OnLaw& on) {
                            room_.resize(static_cast<std::size_t>(on.sampler.size()));
                            on.sampler.evaluate(contact_, snapshot, room_);
                            return extreme_of(room_, on.which);
                          },
                          [&](const OfSteps&) { return reactions_.value(i, snapshot, before); },
                          [&](const SpaceNorm& norm) {
                            return norm.value(snapshot.field(field_of_u(0)), snapshot.values());
                          },
                          [](const Combination&) { return std::nan(""); }},
                    evaluators_[i]);
}

void ProbeSet::evaluate(const Snapshot& snapshot, const Snapshot& before,
                        std::span<double> values) {
  for (int i = 0; i < size(); ++i)
    if (!probes_[i].time && probes_[i].kind != Probe::Kind::combination)
      values[i] = value(i, snapshot, before);
  combine(snapshot.t(), values);
}

void ProbeSet::evaluate_start(const Snapshot& snapshot, bool balance, std::span<double> values) {
  const bool reactions = balance && !reactions_.look_back(); // else they are those of a step
  for (int i = 0; i < size(); ++i) {
    const bool later = probes_[i].time && *probes_[i].time > snapshot.t();
    if (later || probes_[i].kind == Probe::Kind::combination) continue;
    values[i] = of_steps(i) && !reactions ? std::nan("") : value(i, snapshot, snapshot);
  }
  combine(snapshot.t(), values);
}

void ProbeSet::evaluate_here(const Snapshot& snapshot, const Snapshot& before,
                             std::span<double> values) {
  for (int i = 0; i < size(); ++i)
    if (probes_[i].kind != Probe::Kind::combination) values[i] = value(i, snapshot, before);
  combine(snapshot.t(), values);
}

void ProbeSet::add_scales_of_reactions(const Snapshot& snapshot, const Snapshot& before,
                                       std::span<const double> values, std::span<double> floors) {
  std::vector<double> here(values.begin(), values.end());
  combine(snapshot.t(), here);
  std::vector<std::optional<double>> scales(space_.blocks.size());
  for (int i = 0; i < size(); ++i) {
    if (probes_[i].kind != Probe::Kind::reaction) continue;
    auto& scale = scales[static_cast<std::size_t>(probes_[i].unknown)];
    if (!scale) scale = reactions_.scale(probes_[i].unknown, snapshot, before);
    std::vector<double> moved = here;
    moved[i] += *scale;
    combine(snapshot.t(), moved);
    for (std::size_t k = 0; k < moved.size(); ++k)
      if (const double change = std::abs(moved[k] - here[k]); std::isfinite(change))
        floors[k] += change;
  }
}

/// A combination may read combinations that stand before it.
void ProbeSet::combine(double t, std::span<double> values) const {
  for (int i = 0; i < size(); ++i)
    if (probes_[i].kind == Probe::Kind::combination) values[i] = combined(i, t, values);
}

double ProbeSet::combined(int i, double t, std::span<const double> values) const {
  return solver::evaluate(probes_[i].expression, [&](Slot s) {
    if (s == slot::t) return t;
    return s >= slot::first_probe ? values[s - slot::first_probe] : std::nan("");
  });
}

std::vector<int> ProbeSet::timed(double from, double to, bool first) const {
  std::vector<int> out;
  for (int i = 0; i < size(); ++i) {
    const auto& probe = probes_[i];
    if (!probe.time || probe.kind == Probe::Kind::combination) continue;
    const bool after = *probe.time > from || (first && *probe.time == from);
    if (after && *probe.time <= to) out.push_back(i);
  }
  return out;
}

std::vector<int> ProbeSet::dofs_read() const {
  std::vector<int> out;
  for (int i = 0; i < size(); ++i) {
    const auto* at = std::get_if<AtPoint>(&evaluators_[i]);
    if (at == nullptr) continue;
    const bool gradient = reads_gradient(probes_[i].expression, n_fields_);
    const auto nodes = space_.nodes_of_cell(at->cell);
    for (std::size_t v = 0; v < nodes.size(); ++v) {
      // Of a P1 cell, node v has the shape function barycentric[v].
      if (!gradient && space_.order == 1 && at->barycentric[v] == 0.0) continue;
      for (int c = 0; c < space_.components; ++c) {
        bool read = gradient;
        for (int k = 0; k < n_fields_ && !read; ++k)
          read = probes_[i].expression.depends_on(slot::field(k, value_of(space_, c)));
        if (read) out.push_back(space_.dof(nodes[v], c));
      }
    }
  }
  return out;
}

bool ProbeSet::look_back() const {
  return reactions_.look_back() && std::ranges::any_of(probes_, [](const Probe& probe) {
           return probe.kind == Probe::Kind::reaction;
         });
}

bool ProbeSet::any_timed() const {
  for (const auto& probe : probes_)
    if (probe.time) return true;
  return false;
}

} // namespace hvi::solver
