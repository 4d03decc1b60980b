// See stability.hpp.
#include "lang/stability.hpp"

#include "lang/nudge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace hvi::lang {

namespace {

constexpr double unit = std::numeric_limits<double>::epsilon();
constexpr int samples = 3;      ///< of the script's and the mesh's numbers
constexpr int most_states = 16; ///< at which two runs are compared

Trace traced(const solver::Plan& plan, const solver::Discretisation& d, bool monitors,
             const std::atomic<bool>* stop) {
  Trace out;
  solver::RunSettings settings;
  settings.monitors = settings.condition = monitors;
  settings.stop = stop;
  const int steps =
      plan.problem.time.is_static ? 1 : static_cast<int>(plan.problem.time.grid.size()) - 1;
  const int stride = std::max(1, steps / most_states);
  settings.on_step = [&](int n, double, const solver::Vector& u, const solver::Vector&) {
    if (n % stride == 0 || n == steps) out.states.push_back(u);
  };
  settings.on_restart = [&] { out.states.clear(); };
  out.result = solver::run(plan, d, settings);
  return out;
}

/// The run that others are compared with, and what stops them all.
struct First {
  const Trace& trace;
  const std::atomic<bool>* stop;
};

/// max_n |u_n - v_n| / max_n |u_n|, or why there is none.
void take_distance(const Trace& a, const Trace& b, Variation& out) {
  if (a.states.size() != b.states.size()) {
    out.failure = "it has another number of steps";
    return;
  }
  double off = 0, size = 0;
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    if (a.states[i].size() != b.states[i].size()) {
      out.failure = "it has another number of unknowns";
      return;
    }
    off = std::max(off, (a.states[i] - b.states[i]).lpNorm<Eigen::Infinity>());
    size = std::max(size, a.states[i].lpNorm<Eigen::Infinity>());
  }
  out.change = size > 0 ? off / size : off;
}

/// A run with other numbers has failed: says why, or throws where the numbers are not the reason.
void take_failure(const solver::Failure& failure, Variation& out) {
  using K = solver::FailureKind;
  if (failure.kind == K::interrupted || failure.kind == K::missing_file) throw failure;
  out.failure = failure.what();
}

/// The text of the script's own file, read once: the file may change or be refused later.
std::string text_of(const Script& script) { return std::string(script.sources.file(0).text()); }

/// The script with a parameter moved by one unit in the last place; nothing where it must be whole.
std::optional<Variation> moved_parameter(const Script& given, const CompileSettings& settings,
                                         const ModelParam& param, const First& first) {
  const auto* value = std::get_if<double>(&param.value);
  if (value == nullptr || *value == 0.0 || !std::isfinite(*value)) return std::nullopt;
  std::optional<Variation> failed; // says why, where neither way gives a script that runs
  for (const double towards : {HUGE_VAL, -HUGE_VAL}) { // the other way at the end of its range
    const double next = std::nextafter(*value, towards);
    CompileSettings other = settings;
    other.defines[param.name] = fmt::format("{:.17g}", param.as_declared(next));
    Session session(given.path, other, text_of(given));
    if (!session.compile_variation()) continue;
    Variation out;
    out.what = fmt::format("`{}` by one unit in the last place", param.name);
    out.moved = std::abs((next - *value) / *value);
    const solver::Plan& plan = *session.script.plan;
    auto& d = session.discretisation;
    if (const auto failures = solver::discretise(plan, d); !failures.empty()) {
      take_failure(failures.front(), out);
      failed = out;
      continue;
    }
    try {
      take_distance(first.trace, traced(plan, d, false, first.stop), out);
    } catch (const solver::Failure& failure) {
      take_failure(failure, out);
    }
    return out;
  }
  return failed;
}

/// A run of a script or a mesh with other numbers, against the first.
Variation compared(const std::string& what, const First& first,
                   const std::function<Trace()>& other) {
  Variation out{what, true, unit, {}, {}};
  try {
    take_distance(first.trace, other(), out);
  } catch (const solver::Failure& failure) {
    take_failure(failure, out);
  }
  return out;
}

solver::Failure refusal(const std::vector<solver::Failure>& failures) {
  return failures.empty() ? solver::Failure(solver::FailureKind::bad_value, {},
                                            "the moved numbers give no script")
                          : failures.front();
}

/// All numbers of the script at once, each by one unit in the last place, up or down at random.
std::vector<Variation> moved_numbers(const Script& given, const CompileSettings& settings,
                                     const First& first) {
  std::vector<Variation> out;
  const std::string text = text_of(given);
  const auto literals = movable_literals(given.path, text, settings);
  if (literals.empty()) return out;
  for (int sample = 1; sample <= samples; ++sample)
    out.push_back(compared(
        fmt::format("the {} numbers of the script by one unit in the last place, sample {}",
                    literals.size(), sample),
        first, [&] {
          Session session(given.path, settings,
                          moved_text(text, literals, static_cast<std::uint64_t>(sample)));
          if (!session.compile_variation()) throw refusal({});
          const solver::Plan& plan = *session.script.plan;
          if (const auto failures = solver::discretise(plan, session.discretisation);
              !failures.empty())
            throw refusal(failures);
          return traced(plan, session.discretisation, false, first.stop);
        }));
  return out;
}

/// All coordinates of the mesh in the same way.
std::vector<Variation> moved_meshes(const solver::Plan& plan, const solver::Discretisation& d,
                                    const First& first) {
  std::vector<Variation> out;
  for (int sample = 1; sample <= samples; ++sample)
    out.push_back(compared(
        fmt::format("the coordinates of the nodes by one unit in the last place, sample {}",
                    sample),
        first, [&] {
          solver::Mesh mesh = d.mesh;
          move_nodes(mesh, static_cast<std::uint64_t>(sample));
          solver::Discretisation other;
          if (const auto failures = solver::discretise_on(plan, std::move(mesh), other);
              !failures.empty())
            throw refusal(failures);
          return traced(plan, other, false, first.stop);
        }));
  return out;
}

/// Choices that must not matter where the solution is unique.
std::vector<std::pair<std::string, std::function<void(solver::Plan&)>>>
choices(const solver::Plan& plan) {
  std::vector<std::pair<std::string, std::function<void(solver::Plan&)>>> out;
  out.emplace_back("the certificate's tolerance times 1/100",
                   [](solver::Plan& p) { p.options.tolerance *= 0.01; });
  if (!plan.problem.histories.empty() && plan.options.route != solver::HistoryRoute::direct)
    out.emplace_back("memory by the direct sum",
                     [](solver::Plan& p) { p.options.route = solver::HistoryRoute::direct; });
  if (plan.problem.law_terms.empty()) return out;
  if (plan.options.branch != solver::Branch::release)
    out.emplace_back("the released branch",
                     [](solver::Plan& p) { p.options.branch = solver::Branch::release; });
  if (plan.options.branch != solver::Branch::least_energy)
    out.emplace_back("the branch of least energy",
                     [](solver::Plan& p) { p.options.branch = solver::Branch::least_energy; });
  return out;
}

Variation chosen(const std::string& what, const solver::Plan& plan, const solver::Discretisation& d,
                 const First& first) {
  Variation out{what, false, 0, {}, {}};
  try {
    take_distance(first.trace, traced(plan, d, false, first.stop), out);
  } catch (const solver::Failure& failure) {
    take_failure(failure, out);
  }
  return out;
}

} // namespace

Stability examine(const Session& session, const CompileSettings& settings,
                  const std::atomic<bool>* stop) {
  const Script& script = session.script;
  const auto& d = session.discretisation;
  Stability out;
  out.base = traced(*script.plan, d, true, stop);
  const First first{out.base, stop};
  out.condition = out.base.result.forward_error.condition;
  try {
    out.theory = solver::check_hypotheses(*script.plan, d, false);
  } catch (const solver::Failure& failure) {
    out.no_theory = failure.what();
  }
  for (const ModelParam& param : script.model->params)
    if (auto moved = moved_parameter(script, settings, param, first))
      out.variations.push_back(std::move(*moved));
  for (auto& moved : moved_numbers(script, settings, first))
    out.variations.push_back(std::move(moved));
  for (auto& moved : moved_meshes(*script.plan, d, first))
    out.variations.push_back(std::move(moved));
  for (const auto& [what, change] : choices(*script.plan)) {
    solver::Plan other = *script.plan;
    change(other);
    out.variations.push_back(chosen(what, other, d, first));
  }
  return out;
}

} // namespace hvi::lang
