// See judgement.hpp.
#include "lang/editor/judgement.hpp"

#include "lang/forecast.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/hypotheses/hypotheses.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hvi::lang {

namespace {

std::string size_of(const Session& session) {
  const int steps = static_cast<int>(session.script.plan->problem.time.grid.size()) - 1;
  return fmt::format("{} values at nodes{}", session.discretisation.space.n_dofs(),
                     steps > 0 ? fmt::format(", {} steps", steps) : "");
}

} // namespace

std::string judgement_of(Session& session, const std::atomic<bool>& stop) {
  if (session.compile() != exit_ok) return {};
  if (session.discretise(&stop) != exit_ok) return "the mesh does not fit the script";
  std::string out = size_of(session);
  if (session.discretisation.space.n_dofs() > most_unknowns_judged)
    return out + "; `hvi-run check` has the numbers";
  if (stop || session.take_first_step() != exit_ok) return out;
  const auto report = solver::check_hypotheses(*session.script.plan, session.discretisation, false);
  if (std::isfinite(report.margins.step))
    out += fmt::format(", step margin {:.3g}", report.margins.step);
  const Forecast cost = forecast(*session.script.plan, session.discretisation, &stop);
  out += fmt::format(", predicted {:.2g} s and {}", cost.seconds(),
                     solver::bytes_text(cost.most_bytes));
  return out + ": " + report.discrete_verdict;
}

Judgement::Judgement(std::function<void()> ready)
    : ready_(std::move(ready)), thread_([this] { work(); }) {}

Judgement::~Judgement() {
  {
    const std::scoped_lock lock(mutex_);
    over_ = stop_ = true;
  }
  asked_.notify_one();
  thread_.join();
}

void Judgement::ask(const std::string& path, const std::string& text,
                    const CompileSettings& settings) {
  {
    const std::scoped_lock lock(mutex_);
    if (path == path_ && text == text_) return;
    path_ = path, text_ = text, settings_ = settings, result_.reset();
    settings_.on_name = nullptr;
    waits_ = stop_ = true;
  }
  asked_.notify_one();
}

void Judgement::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    asked_.wait(lock, [&] { return waits_ || over_; });
    if (over_) return;
    waits_ = stop_ = false;
    const std::string path = path_, text = text_;
    CompileSettings settings = settings_;
    lock.unlock();
    std::string found = judged(path, text, std::move(settings));
    lock.lock();
    if (stop_ || found.empty()) continue;
    result_ = std::move(found);
    lock.unlock();
    ready_();
    lock.lock();
  }
}

std::string Judgement::judged(const std::string& path, const std::string& text,
                              CompileSettings settings) {
  std::string found;
  try {
    Session session(path, std::move(settings), text);
    session.attempt([&] { found = judgement_of(session, stop_); });
  } catch (const std::exception& error) {
    found = error.what(); // out of memory: the editor goes on
  }
  return found;
}

std::optional<std::string> Judgement::of(const std::string& path) const {
  const std::scoped_lock lock(mutex_);
  return path == path_ ? result_ : std::nullopt;
}

} // namespace hvi::lang
