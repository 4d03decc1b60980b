// Runs that are kept to be compared; see kept_run.hpp.
#include "solver/study/kept_run.hpp"

#include "solver/common/clock.hpp"
#include "solver/discrete/shared_work.hpp"
#include "solver/study/reference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

/// Steps whose states are kept: all, or a power of two apart, with 1, 2, 4, ... and the last; then
/// a run of half the steps has the same times among its own.
bool keeps_step(int n, int steps, int stride) {
  return n == steps || n % stride == 0 || (n & (n - 1)) == 0;
}

int stride_for(int steps, int dofs) {
  const double most = std::clamp(2e8 / (8.0 * dofs), 8.0, 2048.0);
  int stride = 1;
  while (steps / stride > most) stride *= 2;
  return stride;
}

double v_distance(const KeptRun& coarse, const KeptRun& fine) {
  auto reference = std::make_shared<Trajectory>();
  reference->discretisation = fine.discretisation;
  std::vector<const Vector*> compared;
  const auto n_coarse = std::max(coarse.setting.steps, 1), n_fine = std::max(fine.setting.steps, 1);
  for (std::size_t i = 0; i < coarse.steps.size(); ++i)
    for (std::size_t j = 0; j < fine.steps.size(); ++j)
      if (static_cast<long long>(coarse.steps[i]) * n_fine ==
          static_cast<long long>(fine.steps[j]) * n_coarse) {
        reference->times.push_back(static_cast<double>(compared.size())); // a number, not a time
        reference->states.push_back(fine.states[j]);
        compared.push_back(&coarse.states[i]);
      }
  const auto gauge = trajectory_gauge(reference, *coarse.discretisation,
                                      norms_of(coarse.plan.problem, *coarse.discretisation));
  for (std::size_t i = 0; i < compared.size(); ++i)
    gauge->step(static_cast<double>(i), *compared[i]);
  return gauge->error().relative();
}

/// What a column's size is where it is zero but for rounding, by symmetry for one: that which its
/// rounding is relative to.
double size_beyond_rounding(const RunResult& result, const std::string& probe, double size) {
  for (const ColumnError& e : result.forward_error.columns)
    if (e.name == probe && size <= e.absolute && e.relative > 0.0) return e.absolute / e.relative;
  return size;
}

double probe_distance(const KeptRun& coarse, const KeptRun& fine, const std::string& probe) {
  const auto a = coarse.result.columns.find(probe), b = fine.result.columns.find(probe);
  double largest = 0.0, size = 0.0;
  bool seen = false;
  const auto compare = [&](double x, double y) {
    if (std::isnan(x) || std::isnan(y)) return; // what a row has no value for
    largest = std::max(largest, std::abs(x - y)), size = std::max(size, std::abs(y));
    seen = true;
  };
  if (a != coarse.result.columns.end() && b != fine.result.columns.end()) {
    const auto &s = coarse.result.times, &t = fine.result.times;
    for (std::size_t i = 0, j = 0; i < s.size() && j < t.size();) {
      // Grids of one family share their times to the last bits; others may be very close, at jumps.
      if (std::abs(s[i] - t[j]) <= 1e-15 * (std::abs(t.front()) + std::abs(t.back())))
        compare(a->second[i++], b->second[j++]);
      else
        s[i] < t[j] ? ++i : ++j;
    }
  }
  compare(coarse.result.final.at(probe), fine.result.final.at(probe));
  if (!seen) return std::numeric_limits<double>::quiet_NaN();
  size = size_beyond_rounding(fine.result, probe, size);
  return size > 0.0 ? largest / size : largest;
}

} // namespace

double distance(const KeptRun& coarse, const KeptRun& fine, const std::string& probe) {
  return probe.empty() ? v_distance(coarse, fine) : probe_distance(coarse, fine, probe);
}

std::shared_ptr<const Discretisation> Runner::discretisation_of(const Setting& setting,
                                                                const Plan& plan) {
  const std::tuple key{setting.order, setting.level, setting.grade};
  if (const auto known = meshes_.find(key); known != meshes_.end()) return known->second;
  auto made = std::make_shared<Discretisation>();
  const auto failures = discretise(plan, *made, settings_.stop);
  if (!failures.empty()) throw failures.front();
  made->shared = std::make_shared<SharedWork>();
  return meshes_[key] = made; // only now: a setting without a mesh has no entry
}

Spared Runner::spared() const {
  Spared out;
  for (const auto& [key, mesh] : meshes_) {
    const Spared one = mesh->shared->spared();
    out.matrices += one.matrices, out.orders += one.orders, out.factors += one.factors;
    out.seconds_assembly += one.seconds_assembly;
    out.seconds_orders += one.seconds_orders, out.seconds_factors += one.seconds_factors;
  }
  return out;
}

KeptRun Runner::make(const Setting& setting, const RunSettings& settings, bool final) {
  KeptRun out;
  out.setting = setting;
  out.plan = family_.at(setting);
  const double begin = cpu_seconds();
  out.discretisation = discretisation_of(setting, out.plan);
  const int stride = stride_for(setting.steps, out.discretisation->space.n_dofs());
  RunSettings here = settings;
  double watching = 0.0;
  here.on_start = [&](double, const Vector& u) { out.first = u; };
  here.on_step = [&](int n, double, const Vector& u, const Vector&) {
    const PhaseClock<> clock(watching);
    if (!keeps_step(n, setting.steps, stride)) return;
    out.steps.push_back(n), out.states.push_back(u);
  };
  here.on_restart = [&] { out.steps.clear(), out.states.clear(); };
  if (!final) {
    out.plan.report.fields.clear(), out.plan.report.pictures.clear();
    out.plan.report.lines.clear(), out.plan.report.plots.clear();
    for (auto& table : out.plan.report.tables) table.every = 1;
  }
  out.result = final && shown_ != nullptr ? run_shown(out.plan, *out.discretisation, here, *shown_)
                                          : run(out.plan, *out.discretisation, here);
  const auto& t = out.result.timing;
  out.cost = {static_cast<double>(out.result.unknowns), std::max(t.total - t.steps - t.output, 0.0),
              t.steps / std::max(1, out.result.steps)};
  out.row = std::max(t.output - watching, 0.0) /
            static_cast<double>(std::max<std::size_t>(1, out.result.times.size()));
  out.cpu = cpu_seconds() - begin;
  return out;
}

const KeptRun& Runner::cheap(const Setting& setting) {
  if (const auto known = runs_.find(setting); known != runs_.end()) return known->second;
  RunSettings quiet;
  quiet.stop = settings_.stop;
  try {
    return runs_[setting] = make(setting, quiet, false);
  } catch (const Failure& failure) {
    using K = FailureKind;
    const bool coarse = failure.kind == K::not_certified || failure.kind == K::mostly_rounding ||
                        failure.kind == K::empty_region || failure.kind == K::not_coercive ||
                        failure.kind == K::bad_value;
    if (!coarse) throw; // finer settings would not help
    KeptRun& out = runs_[setting];
    out.setting = setting;
    out.failure = failure.what();
    out.failed_by_rounding = failure.kind == K::mostly_rounding;
    return out;
  }
}

const KeptRun& Runner::final_run(const Setting& setting) {
  return runs_[setting] = make(setting, settings_, true);
}

} // namespace hvi::solver
