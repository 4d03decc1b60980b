// Fits and the choice between settings; see predict.hpp.
#include "solver/study/predict.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

double ErrorLaw::at(double resolution) const { return at_one * std::pow(resolution, -order); }

double finer_error(double distance, double ratio, double order, Distance kind) {
  const double fall = std::pow(ratio, order);
  return kind == Distance::orthogonal ? distance / std::sqrt(fall * fall - 1.0)
                                      : distance / (fall - 1.0);
}
double coarser_error(double distance, double ratio, double order, Distance kind) {
  return finer_error(distance, ratio, order, kind) * std::pow(ratio, order);
}

void add_rung(std::vector<Rung>& rungs, const Rung& rung) {
  std::erase_if(rungs, [&](const Rung& r) { return r.resolution == rung.resolution; });
  rungs.push_back(rung);
  std::sort(rungs.begin(), rungs.end(),
            [](const Rung& a, const Rung& b) { return a.resolution < b.resolution; });
}

ErrorLaw fit_error(std::span<const Rung> rungs, double nominal, Distance kind, double floor) {
  ErrorLaw out;
  out.order = 0.75 * nominal;
  out.seen = static_cast<int>(rungs.size());
  if (rungs.empty()) return out;
  const Rung& last = rungs.back();
  if (last.distance <= floor) { // nothing to be seen: the floor stands for it
    out.order = nominal;
    out.at_one = floor * std::pow(last.resolution, nominal);
    return out;
  }
  if (rungs.size() > 1) {
    const Rung& before = rungs[rungs.size() - 2];
    const double seen = std::log(std::max(before.distance, floor) / last.distance) /
                        std::log(last.resolution / before.resolution);
    out.order = std::clamp(seen, 0.4, nominal);
  }
  out.at_one = coarser_error(last.distance, last.ratio, out.order, kind) *
               std::pow(last.resolution, out.order);
  return out;
}

double CostLaw::seconds(double unknowns, double steps) const {
  const double more = std::max(unknowns, 1.0) / std::max(at.unknowns, 1.0);
  const auto grown = [&](double seen, double fixed, double power) {
    return std::min(seen, fixed) + std::max(seen - fixed, 0.0) * std::pow(more, power);
  };
  return grown(at.setup, overhead.setup, setup_power) +
         steps * grown(at.step, overhead.step, step_power);
}

CostLaw fit_cost(std::span<const CostPoint> points, int dim) {
  CostLaw out;
  if (points.empty()) return out;
  std::vector<CostPoint> sorted(points.begin(), points.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const CostPoint& a, const CostPoint& b) { return a.unknowns < b.unknowns; });
  out.at = sorted.back();
  if (sorted.front().unknowns < 0.3 * out.at.unknowns && sorted.front().unknowns < 1000.0)
    out.overhead = {0.0, 0.8 * sorted.front().setup, 0.8 * sorted.front().step};
  const double usual_setup = dim == 3 ? 1.5 : 1.15, usual_step = dim == 3 ? 1.25 : 1.1;
  out.setup_power = usual_setup, out.step_power = usual_step;
  const auto other = std::find_if(sorted.rbegin(), sorted.rend(), [&](const CostPoint& p) {
    return p.unknowns < 0.6 * out.at.unknowns;
  });
  // Small runs are overhead: their growth says nothing of large ones.
  if (other == sorted.rend() || other->unknowns < 500.0) return out;
  const double span = std::log(out.at.unknowns / other->unknowns);
  const auto power = [&](double a, double b, double most) {
    return a > 0.0 && b > 0.0 ? std::clamp(std::log(b / a) / span, 1.0, most) : 1.0;
  };
  // The usual power and what is seen, half and half: single timings scatter.
  out.setup_power = 0.5 * (usual_setup + power(other->setup, out.at.setup, dim == 3 ? 2.0 : 1.5));
  out.step_power = 0.5 * (usual_step + power(other->step, out.at.step, dim == 3 ? 1.4 : 1.25));
  return out;
}

namespace {

/// Least multiple of `unit`, at least `least`, with law.at(steps) <= error.
double steps_for(const ErrorLaw& law, double error, int unit, int least) {
  const double needed = law.at_one > 0.0 ? std::pow(law.at_one / error, 1.0 / law.order) : 0.0;
  return std::ceil(std::max(needed, static_cast<double>(least)) / unit - 1e-9) * unit;
}

} // namespace

std::optional<Choice> cheapest(std::span<const Candidate> candidates, const SettingFamily& family,
                               double target, double most_unknowns, double most_steps) {
  std::optional<Choice> best;
  const int d = family.dim();
  for (const Candidate& c : candidates) {
    const auto unknowns = [&](double level) { return c.unknowns_at_one * std::pow(level, d); };
    for (int level = 2; unknowns(level) <= most_unknowns && level < (1 << 24);
         level = family.bisected() && c.grade != adaptive ? 2 * level
                                                          : level + std::max(2, level / 64 * 2)) {
      const double left = target - c.space.at(level);
      if (left <= 0.0) continue;
      double steps = 1.0, with_companions = c.cost.seconds(unknowns(level), 1);
      if (!family.is_static()) {
        steps =
            steps_for(c.time, left, family.step_unit(c.base), 2 * family.coarsest_steps(c.base));
        if (steps > most_steps) continue;
        with_companions = c.cost.seconds(unknowns(level), steps) +
                          c.cost.seconds(unknowns(0.5 * level), 1.5 * steps);
      }
      if (best && best->seconds <= with_companions) continue;
      best = Choice{{c.order, c.scheme, level, static_cast<int>(steps), c.grade, c.base},
                    c.space.at(level) + (family.is_static() ? 0.0 : c.time.at(steps)),
                    with_companions,
                    unknowns(level)};
    }
  }
  return best;
}

} // namespace hvi::solver
