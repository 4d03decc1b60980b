// See stepping.hpp.
#include "lang/python/stepping.hpp"

#include "lang/mesh_values.hpp"
#include "lang/python/fields.hpp"
#include "lang/python/results.hpp"

namespace hvi::python {

using lang::Exit;

Answer Stepping::start() {
  Answer out;
  out.exit = session_->compile();
  if (out.exit == lang::exit_ok) out.exit = session_->discretise(&watch_.stop());
  if (out.exit == lang::exit_ok)
    out.exit = session_->attempt([&] {
      own_pictures_ = show_fields(*session_->script.plan);
      run_.emplace(*session_->script.plan, session_->discretisation, &watch_.stop());
      out.data = description_of(session_->script);
    });
  add_diagnostics(*session_, out);
  return out;
}

Answer Stepping::set(const Defines& defines) {
  Answer out;
  const auto next = model_.session(defines);
  // The file may be another one by now.
  next->script.text = std::string(session_->script.sources.file(0).text());
  out.exit = next->compile();
  if (out.exit == lang::exit_ok)
    out.exit =
        next->attempt([&] { lang::check_materials(next->script, session_->discretisation); });
  if (out.exit == lang::exit_ok)
    out.exit = next->attempt([&] {
      show_fields(*next->script.plan);
      run_->change(*next->script.plan);
      session_->script = std::move(next->script);
    });
  if (out.exit == lang::exit_ok)
    out.data = description_of(session_->script);
  else
    add_diagnostics(*next, out);
  return out;
}

std::pair<Answer, bool> Stepping::advance() {
  Answer out;
  bool more = false;
  out.exit = session_->attempt([&] { more = run_->advance(); });
  if (out.exit != lang::exit_ok) add_diagnostics(*session_, out);
  return {std::move(out), more};
}

Answer Stepping::conclude() {
  Answer out;
  out.exit = session_->attempt([&] {
    session_->result = run_->conclude();
    session_->result.script = session_->script.path;
    add_results(*session_, session_->discretisation, own_pictures_, out);
  });
  add_diagnostics(*session_, out);
  return out;
}

std::vector<std::pair<std::string, double>> Stepping::values() const {
  std::vector<std::pair<std::string, double>> out;
  const auto& report = session_->script.plan->report;
  for (const auto& table : report.tables)
    for (const int probe : table.probes) {
      const auto& name = report.probes[static_cast<std::size_t>(probe)].name;
      out.emplace_back(name, run_->value(name));
    }
  return out;
}

std::vector<Array> Stepping::unknowns() const {
  return unknowns_of(session_->discretisation.space, run_->u());
}

Grid Stepping::grid() const { return grid_of(session_->discretisation.space); }

} // namespace hvi::python
