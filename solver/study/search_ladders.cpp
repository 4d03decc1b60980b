// Ladders of cheap runs, and the choice made by them; see search.hpp.
#include "solver/study/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int first_rungs = 3, most_rungs = 10, most_deeper = 6;
constexpr double steep = 1.8, steeper = 3.0; ///< gradings tried beside the uniform mesh

/// Where no choice is found yet, ladders get further runs up to this size.
constexpr int largest_ladder_steps = 8192;
constexpr double largest_ladder_unknowns = 20000.0;

} // namespace

const KeptRun& Search::cheap(const Setting& setting, const std::string& purpose) {
  const KeptRun& run = runner_.cheap(setting);
  for (const auto& r : out_.runs)
    if (r.setting == setting) return run;
  AccuracyRun record{setting,
                     to_string(setting, family_.at(setting).problem),
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

void Search::record_distance(const KeptRun& run, const KeptRun& against, double d) {
  for (auto& r : out_.runs)
    if (r.setting == run.setting)
      r.distance = d, r.against = to_string(against.setting, against.plan.problem);
}

double Search::distance_between(const KeptRun& coarse, const KeptRun& fine) {
  const double d = distance(coarse, fine, out_.request.probe);
  if (std::isnan(d)) give_up("it has no value in any row that two runs share");
  return d;
}

double Search::compared(const KeptRun& coarse, const KeptRun& fine) {
  const double d = distance_between(coarse, fine);
  record_distance(coarse, fine, d);
  return d;
}

/// A rung of a ladder; null: it is larger than meshes may be, after rungs that were not.
const KeptRun* Search::rung(const Setting& setting, const std::string& purpose, bool first) {
  try {
    return &cheap(setting, purpose);
  } catch (const Failure& failure) {
    const bool too_large =
        failure.kind == FailureKind::limit || failure.kind == FailureKind::too_large;
    if (first || !too_large) throw;
    return nullptr;
  }
}

/// Distances of neighbours of a ladder that doubles; a rung that fails is left out. Where two in a
/// row fail by rounding, finer ones have more of it.
/// Returns the resolution of the finest good run, 0 for none.
int Search::climb(std::vector<Rung>& rungs, int first, int wanted, const std::string& purpose,
                  const std::function<Setting(int)>& at) {
  const KeptRun* before = nullptr;
  int good = 0, finest = 0, resolution = first;
  for (int k = 0; k < most_rungs && good < wanted; ++k, resolution *= 2) {
    const KeptRun* const found = rung(at(resolution), purpose, k == 0);
    if (found == nullptr) break;
    const KeptRun& run = *found;
    if (run.failed_by_rounding && before != nullptr && before->failed_by_rounding) break;
    if (run.failure.empty()) {
      if (before != nullptr && before->failure.empty())
        add_rung(rungs, {0.5 * resolution, 2.0, compared(*before, run)});
      finest = resolution, ++good;
    }
    before = &run;
  }
  return finest;
}

bool Search::has_time_error() const {
  if (family_.is_static()) return false;
  const auto& forms = family_.plan().problem.forms;
  return std::any_of(forms.begin(), forms.end(),
                     [](const FormTerm& f) { return f.field != field_of_u(0); });
}

Setting Search::space_setting(Element element, int level) const {
  const auto scheme = family_.plan().problem.time.scheme;
  return {element.first, scheme, level, family_.is_static() ? 1 : space_steps_, element.second};
}
Setting Search::time_setting(Clock clock, int steps) const {
  return {family_.first_order(), clock.first, 2, steps, plain(), clock.second};
}

void Search::climb_space(Element element, int rungs) {
  const auto purpose =
      fmt::format("space ladder, P{}{}", element.first,
                  element.second == adaptive ? ", adapted"
                  : element.second != 1.0    ? fmt::format(", graded {}", element.second)
                                             : std::string());
  finest_level_[element] = climb(space_[element], 1, rungs, purpose,
                                 [&](int level) { return space_setting(element, level); });
}
void Search::climb_time(Clock clock, int rungs) {
  finest_steps_[clock] = climb(time_[clock], family_.coarsest_steps(clock.second), rungs,
                               fmt::format("time ladder, {}", in_prose(clock.first)),
                               [&](int steps) { return time_setting(clock, steps); });
}

/// How many rungs a ladder in time has that ends where this one does.
int Search::rungs_to(Clock clock) const {
  const double climbed =
      static_cast<double>(finest_steps_.at(clock)) / family_.coarsest_steps(clock.second);
  return static_cast<int>(std::lround(std::log2(std::max(climbed, 1.0)))) + 1;
}

/// Does every mesh that was tried leave P2 far below its order?
bool Search::is_singular() const {
  bool seen = false;
  for (const auto& [element, rungs] : space_) {
    if (element.first != 2 || rungs.size() < 2 || !out_.request.probe.empty()) continue;
    if (space_law(element).order > 1.6) return false;
    seen = true;
  }
  return seen;
}

void Search::choose_candidates() {
  schemes_ = {family_.plan().problem.time.scheme};
  const bool fixed = out_.request.as_written;
  if (has_time_error() && !fixed && !needs_inertia(schemes_.front()))
    schemes_ = {Scheme::backward_euler, Scheme::bdf2};
  if (!family_.is_static())
    for (const Scheme scheme : schemes_) climb_time({scheme, 0}, first_rungs);
  // Enough steps that every level could be certified, and few.
  space_steps_ = 2 * family_.coarsest_steps();
  for (int k = 0; k < 6 && !family_.is_static(); ++k, space_steps_ *= 2)
    if (const int order = family_.first_order();
        cheap(space_setting({order, plain()}, 2), fmt::format("space ladder, P{}", order))
            .failure.empty())
      break;
  for (const int order : family_.orders()) elements_.emplace_back(order, plain());
  if (fixed) elements_ = {{family_.plan().problem.space.order, plain()}};
  if (family_.gradable() && !fixed && !family_.adapted()) {
    for (const int order : family_.orders()) elements_.emplace_back(order, steep);
    if (family_.orders().back() == 2) elements_.emplace_back(2, steeper);
  }
  for (const Element& element : elements_) climb_space(element, first_rungs);
  if (!fixed && !family_.adapted() && is_singular())
    for (const int order : family_.orders()) {
      elements_.emplace_back(order, adaptive);
      climb_space(elements_.back(), first_rungs);
    }
  pair_up();
  if (pairs_.empty() && !family_.is_static()) adapt_time();
  if (pairs_.empty()) give_up(first_failure());
}

/// Of the runs in their order: what stops later ones may be that they are as fine as they are.
std::string Search::first_failure() const {
  for (const AccuracyRun& run : out_.runs)
    if (!run.failure.empty()) return "no coarse run could be certified: " + run.failure;
  return "no run succeeded";
}

/// All elements with all clocks whose ladders say something.
void Search::pair_up() {
  pairs_.clear();
  for (const Element& element : elements_) {
    if (space_[element].empty()) continue;
    if (family_.is_static()) pairs_.emplace_back(element, Clock{schemes_.front(), 0});
    for (const auto& [clock, rungs] : time_)
      if (!rungs.empty()) pairs_.emplace_back(element, clock);
  }
}

// ---- choice ----------------------------------------------------------------------------------

ErrorLaw Search::space_law(Element element) const {
  const int order = family_.nominal_order(element.first);
  const double nominal = out_.request.probe.empty() ? order : 2 * order;
  const auto& rungs = space_.at(element);
  ErrorLaw out = fit_error(rungs, nominal, space_distance_, floor_);
  // Of a value at a point the error changes with the place of the point in its cell, also its sign:
  // the last two runs may be near each other by chance, which the pair before them gives away.
  if (space_distance_ == Distance::additive && rungs.size() > 1) {
    const Rung& before = rungs[rungs.size() - 2];
    const double coarser =
        coarser_error(before.distance, before.ratio, out.order, Distance::additive);
    if (before.distance > floor_)
      out.at_one = std::max(out.at_one, coarser * std::pow(before.resolution, out.order));
  }
  if (const auto seen = refused_.find(element); seen != refused_.end())
    out.at_one =
        std::max(out.at_one, seen->second.error * std::pow(seen->second.resolution, out.order));
  return out;
}
ErrorLaw Search::time_law(Clock clock) const {
  if (family_.is_static()) return {};
  const bool laws = !family_.plan().problem.law_terms.empty();
  return fit_error(time_.at(clock), order_of(clock.first, laws), Distance::additive, floor_);
}

std::vector<Candidate> Search::candidates() const {
  std::vector<Candidate> out;
  for (const auto& [element, clock] : pairs_) {
    const int order = element.first;
    Candidate c{order, clock.first, element.second, space_law(element), time_law(clock),
                {},    0.0,         clock.second};
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

Choice Search::choose() {
  for (;;) {
    const auto all = candidates();
    const auto& request = out_.request;
    const auto choice = cheapest(all, family_, target_, request.most_unknowns, request.most_steps);
    if (!time_adapted_ && worth_adapting(choice)) {
      adapt_time();
      continue;
    }
    if ((!choice || choice->seconds > request.most_seconds) && deepen()) continue;
    if (!choice)
      give_up(fmt::format("no setting within {:.1e} unknowns and {:.1e} steps promises it",
                          request.most_unknowns, request.most_steps));
    if (choice->seconds > request.most_seconds)
      give_up(fmt::format("the cheapest setting ({}) would take about {:.2g} CPU seconds, more "
                          "than {:.2g}",
                          to_string(choice->setting, family_.at(choice->setting).problem),
                          choice->seconds, request.most_seconds));
    if (!extend(choice->setting)) return *choice;
  }
}

/// A further rung where the choice lies far beyond what was seen.
bool Search::extend(const Setting& choice) {
  const Element element = element_of(choice);
  if (const int level = finest_level_[element]; choice.level > 4 * level) {
    climb_space(element, static_cast<int>(std::lround(std::log2(level))) + 2);
    if (finest_level_[element] > level) return true;
  }
  if (family_.is_static()) return false;
  const int steps = finest_steps_[clock_of(choice)];
  if (choice.steps <= 16 * steps) return false;
  climb_time(clock_of(choice), rungs_to(clock_of(choice)) + 1);
  return finest_steps_[clock_of(choice)] > steps;
}

/// Where no choice is found the runs may be too coarse for errors to fall like a power: a further
/// rung for each ladder. False where no ladder got one.
bool Search::deepen() {
  if (deepened_++ >= most_deeper) return false;
  bool any = false;
  for (const auto& [clock, rungs] : std::map<Clock, std::vector<Rung>>(time_))
    if (2 * finest_steps_[clock] <= largest_ladder_steps) {
      climb_time(clock, rungs_to(clock) + 1);
      any = true;
    }
  std::map<Element, double> unknowns;
  for (const auto& c : candidates())
    unknowns[{c.order, c.grade}] =
        c.unknowns_at_one * std::pow(2.0 * finest_level_[{c.order, c.grade}], family_.dim());
  for (const auto& [element, many] : unknowns) {
    if (many > largest_ladder_unknowns) continue;
    climb_space(element, static_cast<int>(std::lround(std::log2(finest_level_[element]))) + 2);
    any = true;
  }
  pair_up();
  return any;
}

} // namespace hvi::solver
