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

Judgement::~Judgement() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void Judgement::ask(const std::string& path, const std::string& text,
                    const CompileSettings& settings) {
  {
    const std::scoped_lock lock(mutex_);
    if (path == path_ && text == text_) return;
    path_ = path, text_ = text, result_.reset();
  }
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  stop_ = false;
  thread_ = std::thread([this, path, text, settings] { judge(path, text, settings); });
}

void Judgement::judge(const std::string& path, const std::string& text, CompileSettings settings) {
  settings.on_name = nullptr;
  std::string found;
  try {
    Session session(path, std::move(settings), text);
    session.attempt([&] { found = judgement_of(session, stop_); });
  } catch (const std::exception& error) {
    found = error.what(); // out of memory: the editor goes on
  }
  if (stop_ || found.empty()) return;
  {
    const std::scoped_lock lock(mutex_);
    result_ = std::move(found);
  }
  ready_();
}

std::optional<std::string> Judgement::of(const std::string& path) const {
  const std::scoped_lock lock(mutex_);
  return path == path_ ? result_ : std::nullopt;
}

} // namespace hvi::lang
