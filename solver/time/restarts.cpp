// See restarts.hpp.
#include "solver/time/restarts.hpp"

#include "solver/discrete/memory.hpp"
#include "solver/output/file.hpp"

namespace hvi::solver {
namespace {

void put_note(StateWriter& w, const StepNote& note) {
  w.put(note.step);
  w.put(note.t);
  put_text(w, note.what);
  w.put(note.origin);
}

StepNote get_note(StateReader& r) {
  StepNote out{};
  out.step = r.get<int>();
  out.t = r.get<double>();
  out.what = get_text(r);
  out.origin = r.get<Origin>();
  return out;
}

} // namespace

void put_notes(StateWriter& w, const std::vector<StepNote>& notes) {
  w.put(static_cast<std::uint64_t>(notes.size()));
  for (const auto& note : notes) put_note(w, note);
}

std::vector<StepNote> get_notes(StateReader& r) {
  std::vector<StepNote> out;
  for (auto n = r.get<std::uint64_t>(); n > 0; --n) out.push_back(get_note(r));
  return out;
}

void Restarts::take(const MemoryMistrust& mistrust) {
  notes.push_back({0, 0.0, mistrust.said, mistrust.origin});
  routes[static_cast<std::size_t>(mistrust.history)] = static_cast<int>(mistrust.next);
}

void Restarts::take(const HorizonEnd& end) {
  notes.push_back({0, 0.0, end.said + ": started again from the first step", end.origin});
}

void Restarts::take(const Restart& why, bool resumed) {
  const auto* end = std::get_if<HorizonEnd>(&why);
  if (end != nullptr && !resumed)
    throw Failure(FailureKind::limit, end->origin, end->said, end->help);
  std::visit([&](const auto& one) { take(one); }, why);
}

void Restarts::add_notes(const Plan& plan, RunResult& result) const {
  for (const auto& sentence : route_notes(plan, result.histories))
    if (notes.empty()) result.notes.push_back({0, 0.0, sentence, Origin{}});
  result.notes.insert(result.notes.begin(), notes.begin(), notes.end());
  if (doubles)
    result.notes.push_back({0, 0.0,
                            "a step was not certified with the factor in single precision: started "
                            "again in double precision",
                            Origin{}});
}

Plan Restarts::applied(const Plan& plan) const {
  Plan out = plan;
  for (std::size_t m = 0; m < routes.size(); ++m)
    if (routes[m] >= 0) out.problem.histories[m].route = static_cast<HistoryRoute>(routes[m]);
  if (both_sides) out.options.jumps_as_unknowns = false;
  out.options.rows_refused = all_unknowns;
  if (doubles) out.options.factor = FactorEntries::doubles;
  if (solver) out.options.solver = solver->solver;
  return out;
}

void Restarts::save(StateWriter& w, const ChosenSolver& chosen) const {
  w.put(
      static_cast<std::uint8_t>((both_sides ? 1 : 0) + (all_unknowns ? 2 : 0) + (doubles ? 4 : 0)));
  w.put(routes);
  put_notes(w, notes);
  w.put(static_cast<std::uint8_t>(chosen.solver));
  put_text(w, chosen.why);
}

void Restarts::restore(StateReader& r, const Plan& plan) {
  const auto refused = r.get<std::uint8_t>();
  if (refused > 7) r.fail("is inconsistent");
  both_sides = (refused & 1) != 0, all_unknowns = (refused & 2) != 0;
  doubles = (refused & 4) != 0;
  routes = r.get_vector<int>(plan.problem.histories.size());
  for (const int route : routes)
    if (route < -1 || route > static_cast<int>(HistoryRoute::direct)) r.fail("is inconsistent");
  notes = get_notes(r);
  const auto number = r.get<std::uint8_t>();
  if (number > static_cast<std::uint8_t>(LinearSolver::iterative)) r.fail("is inconsistent");
  solver = {static_cast<LinearSolver>(number), get_text(r)};
  const LinearSolver asked = plan.options.solver;
  if ((asked == LinearSolver::direct || asked == LinearSolver::iterative) &&
      asked != solver->solver)
    throw Failure(FailureKind::bad_checkpoint, {},
                  asked == LinearSolver::direct
                      ? "it was written by a run with `solver = iterative`"
                      : "it was written by a run with `solver = direct`");
}

void with_its_name(const std::filesystem::path& file, const std::function<void()>& read) {
  try {
    read();
  } catch (const Failure& failure) {
    refuse_checkpoint(file, std::string("does not fit: ") + failure.what());
  }
}

std::optional<std::string> saved_state(const Plan& plan, const Discretisation& discretisation,
                                       const RunSettings& settings) {
  if (settings.checkpoint_every == 0 && !settings.resume) return std::nullopt;
  if (settings.output_folder.empty())
    throw Failure(FailureKind::bad_value, {}, "a checkpoint needs an output folder");
  const auto file = checkpoint_path(settings.output_folder, settings.name);
  remove_leftovers(file.parent_path());
  if (!settings.resume || !std::filesystem::exists(file)) return std::nullopt;
  return read_checkpoint(file, fingerprint(plan, discretisation.mesh));
}

} // namespace hvi::solver
