// See stepped_run.hpp.
#include "solver/time/stepped_run.hpp"

#include "solver/time/one_run.hpp"
#include "solver/time/start_state.hpp"
#include "solver/time/trust.hpp"

#include <cmath>
#include <optional>
#include <utility>

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
    while (run_->step() < step)
      if (const auto restart = run_->take_step(clock)) {
        restarts_.take(*restart, false);
        start();
      }
    if (run_->at_end()) run_->certify();
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
  void start() {
    run_.reset(); // reads the plan
    plan_.emplace(restarts_.applied(of_.plan_));
    run_.emplace(*plan_, of_.discretisation_, of_.settings_, restarts_, nullptr);
  }

  const SteppedRun& of_;
  Restarts restarts_;
  std::optional<Plan> plan_;
  std::optional<OneRun> run_;
};

SteppedRun::SteppedRun(const Plan& plan, const Discretisation& discretisation,
                       const std::atomic<bool>* stop)
    : plan_(plan), discretisation_(discretisation) {
  plan_.report.fields.clear();
  for (TableSpec& table : plan_.report.tables) table.every = 1;
  settings_.stop = stop;
  if (plan_.start) plan_ = with_start_solved(plan_, discretisation, settings_, start_notes_);
  settings_.on_step = [this](int, double t, const Vector& u, const Vector& xi) {
    t_ = t, u_ = u, xi_ = xi;
  };
  tried_ = std::make_unique<Tried>(*this);
}

SteppedRun::~SteppedRun() = default;

int SteppedRun::steps() const { return tried_->run().steps(); }

bool SteppedRun::advance() {
  if (tried_->run().at_end()) return false;
  tried_->go_to(step_ + 1);
  ++step_;
  return true;
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
