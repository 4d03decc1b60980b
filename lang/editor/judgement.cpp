// See judgement.hpp.
#include "lang/editor/judgement.hpp"

#include "lang/editor/protocol.hpp"
#include "lang/forecast.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/hypotheses/hypotheses.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace hvi::lang {

namespace {

std::string size_of(const Session& session) {
  const int steps = static_cast<int>(session.script.plan->problem.time.grid.size()) - 1;
  return fmt::format("{} values at nodes{}", session.discretisation.space.n_dofs(),
                     steps > 0 ? fmt::format(", {} steps", steps) : "");
}

std::string numbers_of(const Session& session, const std::atomic<bool>& stop) {
  const auto report = solver::check_hypotheses(*session.script.plan, session.discretisation, false);
  std::string out;
  if (std::isfinite(report.margins.step))
    out += fmt::format(", step margin {:.3g}", report.margins.step);
  const Forecast cost = forecast(*session.script.plan, session.discretisation, &stop);
  return out + fmt::format(", predicted {:.2g} s and {}: {}", cost.seconds(),
                           solver::bytes_text(cost.most_bytes), report.discrete_verdict);
}

/// One line: unknowns, steps, margin and verdict. Empty where there is no plan.
std::string judgement_of(Session& session, const std::atomic<bool>& stop) {
  if (!session.script.plan) return {};
  const Exit tried = session.try_out(&stop, most_unknowns_judged);
  if (session.discretisation.space.n_dofs() == 0) return "the mesh does not fit the script";
  std::string out = size_of(session);
  if (tried != exit_ok) return out;
  if (session.discretisation.space.n_dofs() > most_unknowns_judged)
    return out + "; `hvi-run check` has the numbers";
  if (stop) return out;
  try {
    return out + numbers_of(session, stop);
  } catch (const solver::Failure& failure) { // no mistake of the script: `check` has none either
    return out + "; the hypotheses cannot be judged: " + failure.what();
  }
}

} // namespace

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
                    const CompileSettings& settings, CharacterUnit unit) {
  {
    const std::scoped_lock lock(mutex_);
    if (path == at_hand_ && text == text_at_hand_ && !dropped_) return;
    std::erase_if(waiting_, [&](const Request& one) { return one.path == path; });
    waiting_.push_back({path, text, settings, unit});
    waiting_.back().settings.on_name = nullptr;
    stop_ = true;
    dropped_ = dropped_ || path == at_hand_;
  }
  asked_.notify_one();
}

void Judgement::forget(const std::string& path) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(waiting_, [&](const Request& one) { return one.path == path; });
  found_.erase(path);
  if (path == at_hand_) dropped_ = stop_ = true;
}

void Judgement::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    asked_.wait(lock, [&] { return !waiting_.empty() || over_; });
    if (over_) return;
    stop_ = dropped_ = false;
    Request request = std::move(waiting_.back());
    waiting_.pop_back();
    at_hand_ = request.path, text_at_hand_ = request.text;
    lock.unlock();
    Found found = judged(request);
    lock.lock();
    at_hand_.clear();
    if (dropped_) continue;
    if (stop_) { // something else came first
      waiting_.insert(waiting_.empty() ? waiting_.end() : waiting_.end() - 1, std::move(request));
      continue;
    }
    newly_found_.push_back(request.path);
    found_[request.path] = std::move(found);
    lock.unlock();
    ready_();
    lock.lock();
  }
}

Judgement::Found Judgement::judged(const Request& request) const {
  Found found{request.text, {}, nullptr};
  try {
    Analysis analysis(request.path, request.settings, request.text);
    Session& session = analysis.session;
    session.attempt([&] { found.numbers = judgement_of(session, stop_); });
    found.messages = diagnostics_json({analysis, 0, request.unit});
  } catch (const std::exception& error) {
    found.numbers = error.what(); // out of memory: the editor goes on
  }
  return found;
}

std::optional<std::string> Judgement::numbers_of(const std::string& path) const {
  const std::scoped_lock lock(mutex_);
  const auto known = found_.find(path);
  if (known == found_.end() || known->second.numbers.empty()) return std::nullopt;
  return known->second.numbers;
}

std::optional<nlohmann::json> Judgement::messages_of(const std::string& path,
                                                     const std::string& text) const {
  const std::scoped_lock lock(mutex_);
  const auto known = found_.find(path);
  const bool of_text = known != found_.end() && known->second.text == text;
  if (!of_text || known->second.messages.is_null()) return std::nullopt;
  return known->second.messages;
}

std::vector<std::string> Judgement::newly_judged() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(newly_found_, {});
}

} // namespace hvi::lang
