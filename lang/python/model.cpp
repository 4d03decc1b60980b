// See model.hpp.
#include "lang/python/model.hpp"

#include "lang/cli/accuracy_report.hpp"
#include "lang/cli/check_report.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/diag/render.hpp"
#include "lang/discretisation_key.hpp"
#include "lang/forecast.hpp"
#include "lang/mesh_values.hpp"
#include "lang/pictures.hpp"
#include "lang/python/fields.hpp"
#include "lang/python/results.hpp"
#include "solver/discrete/memory.hpp"
#include "solver/discrete/shared_work.hpp"

#include <algorithm>
#include <utility>

namespace hvi::python {

using lang::Exit;
using lang::Session;

namespace {

/// What can be done, in the words of this module.
std::string help(solver::FailureKind kind) {
  using K = solver::FailureKind;
  switch (kind) {
  case K::unasked_geometry:
    return "mesh it first (`gmsh -2 FILE.geo`), or allow it with allow_geo=True";
  case K::out_of_reach:
    return "ask for less, or allow more with budget=SECONDS";
  case K::output_folder:
  case K::busy_folder:
    return "choose another folder with output=";
  default:
    return {};
  }
}

lang::CompileSettings settings_of(const Defines& defines, bool allow_geo) {
  lang::CompileSettings out;
  out.defines = defines;
  out.allow_geo = allow_geo;
  out.words = {.define = "the parameter ",
               .allow_geometry = "allow it with allow_geo=True",
               .output_folder = "the folder of output=",
               .help = help};
  return out;
}

lang::RunRequest request_of(const Session& session, const RunAsked& how, Watch& watch) {
  lang::RunRequest out;
  out.settings.name = session.script.model->title;
  out.settings.output_folder = how.output;
  out.settings.monitors = how.monitors;
  out.settings.stop = &watch.stop();
  out.settings.progress = [&watch](const solver::Progress& p) { watch.note(p); };
  out.accuracy = how.accuracy;
  out.accuracy_of = how.accuracy_of;
  out.budget = how.budget;
  return out;
}

/// Takes the folder of results, as the command does.
Exit take_folder(lang::HeldOutputs& held, Session& session, const RunAsked& how) {
  if (how.output.empty()) return lang::exit_ok;
  lang::Options options;
  options.output_folder = how.output;
  options.monitors = how.monitors;
  return held.take(lang::outputs_of_run(session.script, options), options, session);
}

/// The pictures and plots of the script itself.
void draw(Session& session, const RunAsked& how, std::size_t own_pictures, Answer& answer) {
  solver::Shown shown = std::move(session.shown);
  shown.pictures.resize(std::min(shown.pictures.size(), own_pictures));
  for (const lang::Drawn& drawn :
       lang::draw_pictures(session.script, session.result, shown, how.output)) {
    if (!drawn.failure)
      session.result.files.push_back(drawn.file);
    else if (drawn.asked_by_name)
      answer.exit = session.refuse(*drawn.failure);
    else
      session.warn("W0601", *drawn.failure, drawn.origin);
  }
}

Exit solve(Session& session, const lang::RunRequest& request, Shared* shared) {
  if (shared == nullptr) return session.run(request);
  return session.attempt([&] {
    session.result = solver::run(*session.script.plan, shared->discretisation(), request.settings,
                                 &session.result);
    session.result.script = session.script.path;
  });
}

} // namespace

Exit Shared::prepare(const std::shared_ptr<Session>& session, const std::atomic<bool>* stop) {
  lang::Script& script = session->script;
  const std::string key = lang::discretisation_key(*script.plan);
  if (made_by_ && key == key_)
    return session->attempt([&] { lang::check_materials(script, made_by_->discretisation); });
  made_by_.reset();
  if (const Exit code = session->discretise(stop); code != lang::exit_ok) return code;
  session->discretisation.shared = std::make_shared<solver::SharedWork>();
  made_by_ = session, key_ = key;
  return lang::exit_ok;
}

std::shared_ptr<Session> Model::session(const Defines& defines) const {
  return std::make_shared<Session>(path_, settings_of(defines, allow_geo_), text_);
}

Answer Model::describe(const Defines& defines) const {
  Answer out;
  const auto one = session(defines);
  out.exit = one->compile();
  if (out.exit == lang::exit_ok) out.data = description_of(one->script);
  add_diagnostics(*one, out);
  return out;
}

Answer Model::run(const Defines& defines, const RunAsked& how, Watch& watch, Shared* shared) const {
  Answer out;
  const auto one = session(defines);
  lang::HeldOutputs held;
  std::unique_lock<std::mutex> turn;
  if (shared != nullptr) turn = std::unique_lock(shared->turn());
  out.exit = one->compile();
  if (out.exit == lang::exit_ok && how.keep_every > 0 &&
      (how.accuracy > 0.0 || one->script.model->accuracy))
    out.exit = one->refuse({solver::FailureKind::bad_value,
                            {},
                            "the steps of a run for an accuracy cannot be kept",
                            "leave out keep_every, or the accuracy"});
  if (out.exit == lang::exit_ok) out.exit = take_folder(held, *one, how);
  if (out.exit == lang::exit_ok)
    out.exit =
        shared != nullptr ? shared->prepare(one, &watch.stop()) : one->discretise(&watch.stop());
  if (out.exit == lang::exit_ok) {
    const std::size_t pictures = show_fields(*one->script.plan);
    lang::RunRequest request = request_of(*one, how, watch);
    const auto& d = shared != nullptr ? shared->discretisation() : one->discretisation;
    if (how.keep_every > 0) {
      request.settings.on_step = [&](int n, double t, const solver::Vector& u,
                                     const solver::Vector&) {
        if (n % how.keep_every == 0) keep(d.space, t, u, out);
      };
      request.settings.on_restart = [&] { out.kept_times.clear(), out.kept.clear(); };
    }
    out.exit = solve(*one, request, shared);
    if (out.exit == lang::exit_ok && one->result.unwritten)
      out.exit = one->refuse(*one->result.unwritten);
    if (out.exit == lang::exit_ok && !how.output.empty()) draw(*one, how, pictures, out);
    add_results(*one, shared != nullptr ? shared->discretisation() : one->last_discretisation(),
                pictures, out);
    if (one->accuracy) out.data["accuracy"] = lang::accuracy_json(*one->accuracy);
  }
  add_diagnostics(*one, out);
  return out;
}

Answer Model::check(const Defines& defines, Watch& watch) const {
  Answer out;
  const auto one = session(defines);
  out.exit = one->compile();
  if (out.exit == lang::exit_ok) out.exit = one->discretise(&watch.stop());
  if (out.exit == lang::exit_ok) out.exit = one->take_first_step();
  if (out.exit == lang::exit_ok)
    out.exit = one->attempt([&] {
      const auto report = solver::check_hypotheses(*one->script.plan, one->discretisation);
      out.data = lang::hypotheses_json(one->script, report);
      out.data["text"] = lang::hypotheses_text(one->script, report, false);
    });
  add_diagnostics(*one, out);
  return out;
}

Answer Model::plan(const Defines& defines, Watch& watch) const {
  Answer out;
  const auto one = session(defines);
  out.exit = one->compile();
  if (out.exit == lang::exit_ok) out.exit = one->discretise(&watch.stop());
  if (out.exit == lang::exit_ok)
    out.exit = one->attempt([&] {
      const auto memory = solver::planned_memory(*one->script.plan);
      const auto cost = lang::forecast(*one->script.plan, one->discretisation, &watch.stop());
      out.data = lang::forecast_json(one->script, cost, memory);
    });
  add_diagnostics(*one, out);
  return out;
}

} // namespace hvi::python
