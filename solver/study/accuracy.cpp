// The search for a wanted accuracy; see accuracy.hpp.
#include "solver/study/accuracy.hpp"

#include "solver/study/kept_run.hpp"
#include "solver/time/clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hvi::solver {
namespace {

constexpr int first_rungs = 3, most_rungs = 8, most_tries = 8;
constexpr double margin = 1.2; ///< a setting is chosen for so much less than the check asks

constexpr double steep = 1.8, steeper = 3.0; ///< gradings tried beside the uniform mesh

/// Element and grading: what a ladder in space is climbed with.
using Element = std::pair<int, double>;

const char* scheme_name(Scheme scheme) {
  return scheme == Scheme::bdf2 ? "bdf2" : "backward Euler";
}

class Search {
public:
  Search(const Plan& plan, const AccuracyRequest& request, const RunSettings& settings,
         const std::function<void(const std::string&)>& tell)
      : family_(prepared(plan, request)), runner_(family_, settings), tell_(tell),
        space_distance_(request.probe.empty() ? Distance::orthogonal : Distance::additive) {
    out_.request = request;
    out_.memory_tolerance = family_.plan().options.memory_tolerance;
    floor_ = std::max(1e-3 * request.wanted, 1e-11);
  }

  AccuracyResult go() {
    const double start = cpu_seconds();
    choose_candidates();
    target_ = out_.request.wanted / (accuracy_safety * margin);
    for (int k = 0; k < most_tries && !out_.reached; ++k) {
      const Choice choice = choose();
      attempt(choice);
    }
    out_.cpu = cpu_seconds() - start;
    out_.spared = runner_.spared();
    if (!out_.reached)
      give_up(out_.tries.empty()
                  ? "the errors seen do not fall as coarser runs promised"
                  : fmt::format("after {} settings the estimated error is still {:.2e}",
                                out_.tries.size(), out_.tries.back().estimate));
    return std::move(out_);
  }

private:
  /// The memory need not be a thousand times closer than the answer.
  static Plan prepared(const Plan& plan, const AccuracyRequest& request) {
    Plan out = plan;
    out.options.memory_tolerance = std::clamp(1e-3 * request.wanted, 1e-10, 1e-5);
    return out;
  }

  [[noreturn]] void give_up(const std::string& why) {
    const std::string what =
        out_.request.probe.empty() ? "of u in V" : "of `" + out_.request.probe + "`";
    throw AccuracyFailure(
        fmt::format("a relative error {} of {:.1e} is out of reach: {}", what, out_.request.wanted,
                    why),
        "ask for less, allow more with --budget SECONDS, or grade the mesh toward corners",
        std::move(out_));
  }

  // ---- ladders -----------------------------------------------------------------------------

  const KeptRun& cheap(const Setting& setting, const std::string& purpose) {
    const KeptRun& run = runner_.cheap(setting);
    for (const auto& r : out_.runs)
      if (r.setting == setting) return run;
    AccuracyRun record{setting,
                       to_string(setting, family_.at(setting)),
                       purpose,
                       run.failure,
                       run.result.unknowns,
                       run.cpu,
                       {},
                       {}};
    if (run.failure.empty()) costs_[kind_of(setting)].push_back(run.cost);
    tell_(run.failure.empty() ? fmt::format("{}: {}, {:.2g} s", purpose, record.text, run.cpu)
                              : fmt::format("{}: {}: {}", purpose, record.text, run.failure));
    out_.runs.push_back(std::move(record));
    return run;
  }

  void record_distance(const KeptRun& run, const KeptRun& against, double d) {
    for (auto& r : out_.runs)
      if (r.setting == run.setting)
        r.distance = d, r.against = to_string(against.setting, against.plan);
  }

  static void add_rung(std::vector<Rung>& rungs, const Rung& rung) {
    std::erase_if(rungs, [&](const Rung& r) { return r.resolution == rung.resolution; });
    rungs.push_back(rung);
    std::sort(rungs.begin(), rungs.end(),
              [](const Rung& a, const Rung& b) { return a.resolution < b.resolution; });
  }

  /// Distances of neighbours of a ladder that doubles; a rung that fails is left out.
  /// Returns the resolution of the finest good run, 0 for none.
  int climb(std::vector<Rung>& rungs, int first, int wanted, const std::string& purpose,
            const std::function<Setting(int)>& at) {
    const KeptRun* before = nullptr;
    int good = 0, resolution = first;
    for (int k = 0; k < most_rungs && good < wanted; ++k, resolution *= 2) {
      const KeptRun& run = cheap(at(resolution), purpose);
      if (!run.failure.empty()) {
        before = nullptr;
        continue;
      }
      if (before != nullptr) {
        const double d = distance(*before, run, out_.request.probe);
        record_distance(*before, run, d);
        add_rung(rungs, {0.5 * resolution, 2.0, d});
      }
      before = &run, ++good;
    }
    return good > 0 ? resolution / 2 : 0;
  }

  bool has_time_error() const {
    if (family_.is_static()) return false;
    const auto& forms = family_.plan().forms;
    return std::any_of(forms.begin(), forms.end(),
                       [](const FormTerm& f) { return f.field != field_u; });
  }

  Setting space_setting(Element element, int level) const {
    const auto scheme = family_.plan().time.scheme;
    return {element.first, scheme, level, family_.is_static() ? 1 : space_steps_, element.second};
  }
  Setting time_setting(Scheme scheme, int steps) const { return {1, scheme, 2, steps, plain()}; }
  /// The grade of meshes that are neither graded nor adapted unless the script says so.
  double plain() const { return family_.adapted() ? adaptive : 1.0; }

  void climb_space(Element element, int rungs) {
    const auto purpose =
        fmt::format("space ladder, P{}{}", element.first,
                    element.second == adaptive ? ", adapted"
                    : element.second != 1.0    ? fmt::format(", graded {}", element.second)
                                               : std::string());
    finest_level_[element] = climb(space_[element], 1, rungs, purpose,
                                   [&](int level) { return space_setting(element, level); });
  }
  void climb_time(Scheme scheme, int rungs) {
    finest_steps_[scheme] = climb(time_[scheme], family_.coarsest_steps(), rungs,
                                  fmt::format("time ladder, {}", scheme_name(scheme)),
                                  [&](int steps) { return time_setting(scheme, steps); });
  }

  /// Does every mesh that was tried leave P2 far below its order?
  bool is_singular() const {
    bool seen = false;
    for (const auto& [element, rungs] : space_) {
      if (element.first != 2 || rungs.size() < 2 || !out_.request.probe.empty()) continue;
      if (space_law(element).order > 1.6) return false;
      seen = true;
    }
    return seen;
  }

  void choose_candidates() {
    std::vector<Scheme> schemes = {family_.plan().time.scheme};
    const bool fixed = out_.request.as_written;
    if (has_time_error() && !fixed) schemes = {Scheme::backward_euler, Scheme::bdf2};
    if (!family_.is_static())
      for (const Scheme scheme : schemes) climb_time(scheme, first_rungs);
    // Enough steps that every level could be certified, and few.
    space_steps_ = 2 * family_.coarsest_steps();
    for (int k = 0; k < 6 && !family_.is_static(); ++k, space_steps_ *= 2)
      if (cheap(space_setting({1, plain()}, 2), "space ladder, P1").failure.empty()) break;
    std::vector<Element> elements = {{1, plain()}, {2, plain()}};
    if (fixed) elements = {{family_.plan().space.order, plain()}};
    if (family_.gradable() && !fixed && !family_.adapted())
      elements.insert(elements.end(), {{1, steep}, {2, steep}, {2, steeper}});
    for (const Element& element : elements) climb_space(element, first_rungs);
    if (!fixed && !family_.adapted() && is_singular())
      for (const Element& element : {Element{1, adaptive}, Element{2, adaptive}}) {
        elements.push_back(element);
        climb_space(element, first_rungs);
      }
    for (const Element& element : elements)
      for (const Scheme scheme : schemes)
        if (!space_[element].empty() && (family_.is_static() || !time_[scheme].empty()))
          pairs_.emplace_back(element, scheme);
    if (pairs_.empty())
      give_up(out_.runs.empty() ? "no run succeeded"
                                : "no coarse run could be certified: " + out_.runs.back().failure);
  }

  // ---- choice ------------------------------------------------------------------------------

  /// Settings whose seconds and unknowns grow alike: order, and whether meshes are adapted.
  using Kind = std::pair<int, bool>;
  static Kind kind_of(const Setting& s) { return {s.order, s.grade == adaptive}; }
  static Element element_of(const Setting& s) { return {s.order, s.grade}; }

  ErrorLaw space_law(Element element) const {
    const double nominal = out_.request.probe.empty() ? element.first : 2 * element.first;
    return fit_error(space_.at(element), nominal, space_distance_, floor_);
  }
  ErrorLaw time_law(Scheme scheme) const {
    if (family_.is_static()) return {};
    return fit_error(time_.at(scheme), scheme == Scheme::bdf2 ? 2.0 : 1.0, Distance::additive,
                     floor_);
  }

  std::vector<Candidate> candidates() const {
    std::vector<Candidate> out;
    for (const auto& [element, scheme] : pairs_) {
      const int order = element.first;
      Candidate c{order, scheme, element.second, space_law(element), time_law(scheme), {}, 0.0};
      c.cost = fit_cost(costs_.at({order, element.second == adaptive}), family_.dim());
      int finest = 0;
      for (const auto& r : out_.runs)
        if (kind_of(r.setting) == Kind{order, element.second == adaptive} && r.failure.empty() &&
            r.setting.level > finest) {
          finest = r.setting.level;
          c.unknowns_at_one = r.unknowns / std::pow(finest, family_.dim());
        }
      out.push_back(c);
    }
    return out;
  }

  Choice choose() {
    for (;;) {
      const auto all = candidates();
      const auto& request = out_.request;
      const auto choice =
          cheapest(all, family_, target_, request.most_unknowns, request.most_steps);
      if (!choice)
        give_up(fmt::format("no setting within {:.1e} unknowns and {:.1e} steps promises it",
                            request.most_unknowns, request.most_steps));
      if (choice->seconds > request.most_seconds)
        give_up(fmt::format("the cheapest setting ({}) would take about {:.2g} CPU seconds, more "
                            "than {:.2g}",
                            to_string(choice->setting, family_.at(choice->setting)),
                            choice->seconds, request.most_seconds));
      if (!extend(choice->setting)) return *choice;
    }
  }

  /// A further rung where the choice lies far beyond what was seen.
  bool extend(const Setting& choice) {
    int& level = finest_level_[element_of(choice)];
    if (choice.level > 4 * level) {
      climb_space(element_of(choice), static_cast<int>(std::lround(std::log2(level))) + 2);
      return true;
    }
    if (family_.is_static()) return false;
    int& steps = finest_steps_[choice.scheme];
    if (choice.steps <= 16 * steps) return false;
    climb_time(choice.scheme,
               static_cast<int>(std::lround(std::log2(steps / family_.coarsest_steps()))) + 2);
    return true;
  }

  // ---- the run and its check ---------------------------------------------------------------

  /// The ladder in time was climbed on a coarse mesh: its order stays, its constant becomes what
  /// this mesh shows. Returns the order.
  double rescale(Scheme scheme, int steps, double seen) {
    const ErrorLaw law = time_law(scheme);
    const double promised = law.at(steps) - law.at(2.0 * steps);
    if (promised > 0.0)
      for (Rung& r : time_[scheme]) r.distance *= std::max(seen, floor_) / promised;
    return law.order;
  }

  /// Error in time of the chosen steps, seen on half the level.
  bool look_at_time(AccuracyTry& now, const Setting& half, const KeptRun& companion) {
    if (family_.is_static()) return true;
    Setting fewer = half;
    fewer.steps /= 2;
    const KeptRun& coarse = cheap(fewer, "companion of half the level and half the steps");
    if (!coarse.failure.empty()) return false;
    now.time_distance = distance(coarse, companion, out_.request.probe);
    record_distance(coarse, companion, now.time_distance);
    now.time_order = rescale(half.scheme, fewer.steps, now.time_distance);
    now.time_error = finer_error(now.time_distance, 2.0, now.time_order, Distance::additive);
    return true;
  }

  void attempt(const Choice& choice) {
    const auto& s = choice.setting;
    AccuracyTry now;
    now.setting = s;
    now.text = to_string(s, family_.at(s));
    now.predicted_error = choice.error;
    now.steps = s.steps;
    tell_(fmt::format("chosen: {}; about {:.0f} unknowns, predicted error {:.1e}, {:.2g} CPU "
                      "seconds with its check",
                      now.text, choice.unknowns, choice.error, choice.seconds));
    Setting half = s;
    half.level /= 2;
    const KeptRun& companion = cheap(half, "companion of half the level");
    if (!companion.failure.empty() || !look_at_time(now, half, companion)) {
      // What is chosen must be well inside what can be certified.
      target_ *= 0.5;
      return;
    }
    const ErrorLaw space = space_law(element_of(s));
    if (accuracy_safety * (now.time_error + space.at(s.level)) > out_.request.wanted) {
      tell_(fmt::format("the steps are too few: error in time {:.1e}", now.time_error));
      tighten(s);
      return;
    }
    now.predicted_cpu = predicted_seconds(s, companion);
    tell_(fmt::format("running {}: about {:.2g} CPU seconds", now.text, now.predicted_cpu));
    finish(now, runner_.final_run(s), companion);
  }

  /// Set-up from the run whose unknowns are nearest; steps from the two companions, whose
  /// difference is what a step costs and whose rest is what the first step does once.
  double predicted_seconds(const Setting& setting, const KeptRun& companion) {
    const auto& points = costs_.at(kind_of(setting));
    const double unknowns = companion.cost.unknowns * std::pow(2.0, family_.dim());
    CostLaw law = fit_cost(points, family_.dim());
    law.at = companion.cost;
    const auto off = [&](const CostPoint& p) { return std::abs(std::log(p.unknowns / unknowns)); };
    for (const CostPoint& p : points)
      if (off(p) < 0.8 * off(law.at)) law.at = p;
    const double setup = law.seconds(unknowns, 0.0), steps = std::max(1, setting.steps);
    double each = companion.cost.step, once = 0.0;
    if (!family_.is_static()) {
      Setting fewer = companion.setting;
      fewer.steps /= 2;
      const double all = each * steps, half = runner_.cheap(fewer).cost.step * fewer.steps;
      each = std::clamp((all - half) / (steps - fewer.steps), 0.3 * each, each);
      once = all - each * steps;
    }
    const double more = unknowns / companion.cost.unknowns;
    int every = static_cast<int>(steps);
    for (const auto& table : family_.at(setting).report.tables)
      every = std::min(every, table.every);
    return setup + (once + each * steps) * std::pow(more, law.step_power) +
           companion.row * more * steps / every;
  }

  void finish(AccuracyTry& now, const KeptRun& run, const KeptRun& companion) {
    now.cpu = run.result.timing.total;
    now.unknowns = run.result.unknowns;
    costs_[kind_of(now.setting)].push_back(run.cost);
    now.space_distance = distance(companion, run, out_.request.probe);
    record_distance(companion, run, now.space_distance);
    add_rung(space_[element_of(now.setting)], {0.5 * now.setting.level, 2.0, now.space_distance});
    now.space_order = space_law(element_of(now.setting)).order;
    now.space_error = finer_error(now.space_distance, 2.0, now.space_order, space_distance_);
    now.estimate = now.space_error + now.time_error;
    out_.tries.push_back(now);
    out_.reached = accuracy_safety * now.estimate <= out_.request.wanted;
    out_.run = run.result;
    out_.plan = run.plan;
    out_.discretisation = run.discretisation;
    tell_(fmt::format("estimated error {:.2e} (space {:.1e}, time {:.1e}), times {} {} the wanted "
                      "{:.1e}",
                      now.estimate, now.space_error, now.time_error, accuracy_safety,
                      out_.reached ? "within" : "above", out_.request.wanted));
    if (!out_.reached) tighten(now.setting);
  }

  /// After a setting whose evidence says no: the laws know better now; where they would choose the
  /// same again, the aim is lowered.
  void tighten(const Setting& refused) {
    for (int k = 0; k < 40; ++k, target_ *= 0.85) {
      const auto again = cheapest(candidates(), family_, target_, out_.request.most_unknowns,
                                  out_.request.most_steps);
      if (!again || again->setting != refused) return;
    }
  }

  SettingFamily family_;
  Runner runner_;
  const std::function<void(const std::string&)>& tell_;
  Distance space_distance_;
  AccuracyResult out_;
  double floor_ = 0.0, target_ = 0.0;
  int space_steps_ = 1;
  std::vector<std::pair<Element, Scheme>> pairs_;
  std::map<Element, std::vector<Rung>> space_;
  std::map<Scheme, std::vector<Rung>> time_;
  std::map<Kind, std::vector<CostPoint>> costs_;
  std::map<Element, int> finest_level_;
  std::map<Scheme, int> finest_steps_;
};

} // namespace

AccuracyResult reach_accuracy(const Plan& plan, const AccuracyRequest& request,
                              const RunSettings& settings,
                              const std::function<void(const std::string&)>& tell) {
  return Search(plan, request, settings, tell).go();
}

} // namespace hvi::solver
