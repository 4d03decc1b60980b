// See stepped_run.hpp.
#include "solver/time/stepped_run.hpp"

#include "solver/discrete/shared_work.hpp"
#include "solver/results/trust.hpp"
#include "solver/time/later_plan.hpp"
#include "solver/time/one_run.hpp"
#include "solver/time/start_state.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

/// The run as it is tried now.
class SteppedRun::Tried {
public:
  explicit Tried(const SteppedRun& of) : of_(of) {
    restarts_.routes.assign(of.plan_.problem.histories.size(), -1);
    start();
  }

  /// Takes steps until this one has been taken.
  void go_to(int step) {
    LapClock<> clock;
    while (run_->step() < step) {
      if (changed_ < changes_.size() && changes_[changed_].after == run_->step())
        take(changes_[changed_++].plan);
      if (const auto restart = run_->take_step(clock)) {
        restarts_.take(*restart, false);
        start();
      }
    }
    if (run_->at_end()) run_->certify();
  }

  /// The steps from the next one on are those of this plan.
  void change(const Plan& plan) {
    const int step = run_->step();
    const Plan& last = changes_.empty() ? of_.plan_ : changes_.back().plan;
    require_same_evolution(last, plan, of_.discretisation_);
    // Plans of a run that changes in each step have most of their expressions in common.
    Change next{step, plan};
    if (only_loads_differ(last, plan)) {
      next.plan = last;
      take_loads_of(plan, next.plan.problem);
    }
    std::optional<Change> replaced;
    if (!changes_.empty() && changes_.back().after == step) {
      replaced = std::move(changes_.back());
      changes_.pop_back();
    }
    changes_.push_back(std::move(next));
    try {
      if (run_->reduced() || (!of_.discretisation_.dofs.homogeneous && !run_->imposed())) {
        start(); // states hold more from now on
        go_to(step);
      }
      take(changes_.back().plan);
    } catch (...) {
      changes_.pop_back();
      if (replaced) changes_.push_back(*std::move(replaced));
      changed_ = changes_.size();
      throw;
    }
    changed_ = changes_.size();
  }

  const OneRun& run() const { return *run_; }

  RunResult conclude() {
    const bool whole = run_->at_end();
    // A check that was put off is the only reason to start again here, and there are none: a run
    // that is looked at makes each check in its step.
    auto result = std::get<RunResult>(run_->conclude());
    if (whole) refuse_rounding(result, plan_->problem);
    restarts_.add_notes(of_.plan_, result);
    return result;
  }

private:
  struct Change {
    int after; ///< this step
    Plan plan;
  };

  Plan applied(const Plan& plan) const {
    Plan out = restarts_.applied(plan);
    if (!changes_.empty()) out.options.proportional_path = false; // loads are no modes of the state
    return out;
  }

  void start() {
    changed_ = 0;
    make(applied(of_.plan_));
  }

  void make(Plan plan) {
    run_.reset(); // reads the plan
    plan_.emplace(std::move(plan));
    run_.emplace(*plan_, of_.discretisation_, of_.settings_, restarts_, nullptr);
  }

  void make_after(Plan plan, int step, const std::string& state) {
    make(std::move(plan));
    if (step == 0) return;
    std::istringstream in(state);
    if (const auto end = run_->take_over(in)) restarts_.take(*end, false);
  }

  /// From the accepted state; where that fails the run is what it was.
  void take(const Plan& plan) {
    restarts_.solver = run_->solver(); // its unknowns are those of the state
    const Plan next = applied(plan);
    if (!only_loads_differ(*plan_, next)) return go_on_as(next);
    const Plan before = *plan_;
    take_loads_of(next, plan_->problem);
    try {
      run_->take_loads();
    } catch (const Failure&) {
      take_loads_of(before, plan_->problem);
      throw;
    }
  }

  void go_on_as(const Plan& plan) {
    const int step = run_->step();
    std::ostringstream out;
    out.exceptions(std::ios::badbit); // memory that runs out is no shorter state
    run_->hand_over(out);
    const std::string state = std::move(out).str();
    const Plan before = *plan_;
    try {
      make_after(plan, step, state);
    } catch (const Failure&) {
      make_after(before, step, state);
      throw;
    }
  }

  const SteppedRun& of_;
  Restarts restarts_;
  std::vector<Change> changes_;
  std::size_t changed_ = 0; ///< so many of them hold
  std::optional<Plan> plan_;
  std::optional<OneRun> run_;
};

SteppedRun::SteppedRun(const Plan& plan, Discretisation& discretisation,
                       const std::atomic<bool>* stop)
    : plan_(as_run(plan)), discretisation_(discretisation) {
  settings_.stop = stop;
  settings_.every_value = true;
  if (plan_.start) plan_ = with_start_solved(plan_, discretisation, settings_, start_notes_);
  settings_.on_step = [this](int, double t, const Vector& u, const Vector& xi) {
    t_ = t, u_ = u, xi_ = xi;
  };
  tried_ = std::make_unique<Tried>(*this);
}

/// No files are written.
Plan SteppedRun::as_run(const Plan& plan) {
  Plan out = plan;
  out.report.fields.clear();
  return out;
}

SteppedRun::~SteppedRun() = default;

int SteppedRun::steps() const { return tried_->run().steps(); }

bool SteppedRun::advance() {
  if (tried_->run().at_end()) return false;
  tried_->go_to(step_ + 1);
  ++step_;
  return true;
}

void SteppedRun::change(const Plan& plan) {
  if (tried_->run().at_end())
    throw Failure(FailureKind::bad_value, {}, "the last step has been taken",
                  "change values before it");
  Plan next = as_run(plan);
  next.start.reset(); // is behind it
  next.problem.time.start = plan_.problem.time.start;
  if (std::ranges::any_of(next.problem.space.dirichlet,
                          [](const DirichletSpec& imposed) { return !imposed.value.empty(); }))
    discretisation_.dofs.homogeneous = false;
  if (!discretisation_.shared) discretisation_.shared = std::make_shared<SharedWork>();
  tried_->change(next);
}

double SteppedRun::value(std::string_view column) const {
  const auto& probes = plan_.report.probes;
  const auto values = tried_->run().values();
  for (std::size_t i = 0; i < probes.size(); ++i)
    if (probes[i].name == column) return values[i];
  return std::nan("");
}

RunResult SteppedRun::conclude() {
  RunResult out = tried_->conclude();
  out.notes.insert(out.notes.begin(), start_notes_.begin(), start_notes_.end());
  return out;
}

} // namespace hvi::solver
