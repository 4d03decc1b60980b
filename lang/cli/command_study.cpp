// hvi-run study: runs every setting of the script's ladders and shows what accuracy costs.
#include "lang/cli/commands.hpp"
#include "lang/cli/interrupt.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/cli/say.hpp"
#include "lang/cli/study_journal.hpp"
#include "lang/cli/study_outputs.hpp"
#include "lang/discretisation_key.hpp"
#include "lang/study.hpp"
#include "solver/common/clock.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/common/read_file.hpp"
#include "solver/discrete/shared_work.hpp"
#include "solver/study/ladder.hpp"
#include "solver/time/checkpoint.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;
using solver::Gauge;

constexpr int most_dofs_for_terms =
    200'000; ///< the exact solution is seen on sixteen times as many

constexpr double most_dofs_kept = 5e5; ///< of meshes (with factors) for settings to come

constexpr double short_run = 0.3; ///< CPU seconds below which a run is timed three times

/// Of a script whose values give no problem.
std::string first_mistake(const Script& script) {
  for (const Diagnostic& mistake : script.diagnostics.sorted())
    if (mistake.severity == Severity::error)
      return fmt::format("{}: {}", mistake.code, mistake.message);
  return "no problem";
}

/// Resets the peak of solver::memory_peak() to what is held now (Linux).
void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

/// Runs the settings one after the other; knows what has been done before.
class Studying {
public:
  Studying(const std::string& path, const Options& options, Study& study)
      : path_(path), options_(options), study_(study),
        folder_(output_folder(path, options, "_study")), journal_(folder_ / "study.jsonl") {}

  int go() {
    Session session(path_, compile_settings(options_));
    const Script& script = session.script;
    const Exit compiled = session.compile();
    show_diagnostics(script, options_);
    if (compiled != exit_ok) return compiled;
    if (!script.model->study) {
      tell("hvi-run: `{}` has no `study` statement\n  = help: study vary n in [8, 16, "
           "32] and N in [8, 16, 32] against finest\n",
           path_);
      return exit_usage;
    }
    plan_rows(*script.model);
    study_.units_by_kind = units_by_kind(script);
    if (script.model->units.used()) study_.units = units_told(script);
    auto names = files_of_study(study_);
    names.push_back(journal_.name());
    if (options_.report) names.push_back(std::string("study") + report_ending);
    const Outputs wanted = outputs_in(folder_.string(), names, options_);
    if (const Exit code = outputs_.take(wanted, options_, session); code != exit_ok) {
      show_diagnostics(script, options_);
      return code;
    }
    journal_.read(what_decides(script), study_.rows);
    for (StudyRow& row : study_.rows) take_error(row);
    return run_all();
  }
  std::string folder() const { return folder_.string(); }

private:
  void plan_rows(const Model& model) {
    study_.script = path_;
    study_.ladders = model.study->ladders;
    kind_ = model.study->reference;
    study_.reference = kind_ == ModelStudy::Reference::exact    ? "the exact solution"
                       : kind_ == ModelStudy::Reference::finest ? "the finest run"
                       : kind_ == ModelStudy::Reference::none   ? "none"
                                                                : "the finest run, extrapolated";
    study_.sweep = kind_ == ModelStudy::Reference::none;
    for (const auto& table : model.report.tables)
      for (const int probe : table.probes)
        study_.columns.push_back(model.report.probes[static_cast<std::size_t>(probe)].name);
    study_.machine = machine_line();
    if (model.space.more.size() > 0)
      for (const auto& unknown : unknowns_of(model.space)) study_.unknowns.push_back(unknown.name);
    study_.in = model.study->unknown;
    std::vector<int> counts;
    for (const StudyLadder& ladder : study_.ladders)
      counts.push_back(static_cast<int>(ladder.values.size()));
    for (const auto& rungs : solver::combinations(counts)) {
      StudyRow row;
      row.rungs = rungs;
      for (std::size_t l = 0; l < rungs.size(); ++l) {
        const StudyLadder& ladder = study_.ladders[l];
        row.values[ladder.parameter] = ladder.values[rungs[l]];
        for (const auto& [name, values] : ladder.more) row.values[name] = values[rungs[l]];
      }
      study_.rows.push_back(std::move(row));
    }
    if (!study_.rows.empty() && !study_.sweep) study_.finest = study_.rows.size() - 1;
  }

  /// Everything that decides a row: the program, the script and its imports, the parameters, and
  /// for each setting the plan with the values of its tables and the content of its mesh file.
  std::string what_decides(const Script& script) const {
    std::string all = fmt::format("journal 4, hvi-run {}\n", version);
    for (const auto& program : script.programs) all += script.sources.file(program.file).text();
    for (const auto& [name, value] : options_.defines) all += name + "=" + value + ";";
    std::map<std::string, std::string> meshes;
    for (const StudyRow& row : study_.rows) {
      const auto setting = compile_row(row);
      const auto& plan = setting->script.plan;
      if (!plan) continue; // said when its turn comes
      // A run's state leaves out what a run may choose anew; a row is of one choice.
      all += fmt::format("{:016x} {} {};", solver::fingerprint(*plan, {}),
                         static_cast<int>(plan->options.solver),
                         static_cast<int>(plan->options.factor));
      std::vector<const solver::MeshSpec*> used{&plan->problem.mesh};
      for (const auto& piece : plan->problem.mesh.pieces) used.push_back(&piece);
      for (const auto* mesh : used)
        if (mesh->kind == solver::MeshSpec::Kind::file)
          meshes.try_emplace(mesh->path, solver::read_file(mesh->path).value_or(""));
    }
    for (const auto& [path, content] : meshes) all += content;
    return all;
  }

  /// The script with the values of a row; without a plan where that has mistakes.
  std::unique_ptr<Session> compile_row(const StudyRow& row) const {
    CompileSettings here = compile_settings(options_);
    for (const auto& [name, value] : row.values) here.defines[name] = value;
    auto out = std::make_unique<Session>(path_, here);
    if (!out->compile_variation()) out->script.plan.reset();
    return out;
  }

  int run_all() {
    const bool against_run = kind_ != ModelStudy::Reference::exact && !study_.sweep;
    const bool all_known = std::all_of(study_.rows.begin(), study_.rows.end(),
                                       [&](const StudyRow& row) { return journal_.has(row); });
    if (against_run && !all_known) {
      // The reference is run first, also when a study is continued: its steps are not kept on disk.
      StudyRow& finest = study_.rows.back();
      if (const int code = run_row(finest, true); code != exit_ok) return code;
      if (!finest.failure.empty()) {
        tell("hvi-run: the finest run failed, nothing can be compared with it: {}\n",
             finest.failure);
        return exit_solve;
      }
    }
    for (std::size_t i = 0; i < study_.rows.size(); ++i) {
      StudyRow& row = study_.rows[i];
      if (journal_.has(row)) continue;
      tell_progress(i);
      if (const int code = make_coarser(i); code != exit_ok) return code;
      if (const int code = run_row(row, false); code != exit_ok) return code;
    }
    if (!options_.quiet && isatty(STDERR_FILENO)) tell("\r\033[K");
    while (!meshes_.empty()) forget(meshes_.begin());
    return exit_ok;
  }

  bool is_rung(const StudyRow& row) const {
    return kind_ == ModelStudy::Reference::richardson && below_finest(study_, row);
  }

  /// A study that is continued has no steps of the coarser run that a rung is compared with: it is
  /// run again.
  int make_coarser(std::size_t i) {
    if (!is_rung(study_.rows[i])) return exit_ok;
    for (std::size_t k = i; k-- > 0;) {
      StudyRow again = study_.rows[k];
      if (!is_rung(again) || !again.failure.empty()) continue;
      return coarser_values_ == again.values ? exit_ok : try_row(again, false);
    }
    return exit_ok;
  }

  /// What a setting may cost, as far as its numbers tell: their product.
  double weight(const StudyRow& row) const {
    double out = 1.0;
    for (const auto& [name, value] : row.values) {
      char* end = nullptr;
      const double number = std::strtod(value.c_str(), &end);
      if (end != value.c_str() && number > 0.0) out *= number;
    }
    return out;
  }

  void tell_progress(std::size_t next) {
    if (options_.quiet || !isatty(STDERR_FILENO)) return;
    double left = 0.0;
    for (std::size_t i = next; i < study_.rows.size(); ++i)
      if (!journal_.has(study_.rows[i])) left += weight(study_.rows[i]);
    const double wall =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
    const std::string when = done_weight_ > 0.0
                                 ? fmt::format(", about {:.0f} s left", wall * left / done_weight_)
                                 : std::string();
    tell("\r\033[K{} of {} settings{}", next + 1, study_.rows.size(), when);
    std::fflush(stderr);
  }

  struct KnownMesh {
    std::string key;
    std::shared_ptr<solver::Discretisation> mesh;
    double held = -1.0; ///< resident bytes that stay after a run on it; < 0: none was made
  };
  void forget(std::vector<KnownMesh>::iterator at) {
    const auto spared = at->mesh->shared->spared();
    study_.shared.matrices += spared.matrices, study_.shared.orders += spared.orders;
    study_.shared.factors += spared.factors, study_.shared.seconds += spared.seconds();
    if (fine_for_ == at->mesh.get()) fine_for_ = nullptr; // the next may have its address
    meshes_.erase(at);
  }

  /// Mesh and space of a plan; settings with the same share them, and what was assembled, ordered
  /// and factored on them.
  std::shared_ptr<solver::Discretisation> discretisation_of(const solver::Plan& plan) {
    std::string key = discretisation_key(plan);
    const auto known = std::ranges::find(meshes_, key, &KnownMesh::key);
    if (known != meshes_.end()) {
      ++study_.shared.meshes;
      std::rotate(known, known + 1, meshes_.end());    // the last one used is the last to go
      resident_ -= std::max(0.0, meshes_.back().held); // a run of its own would need that, too
      return meshes_.back().mesh;
    }
    auto made = std::make_shared<solver::Discretisation>();
    const auto failures = solver::discretise(plan, *made, &stop_flag());
    if (!failures.empty()) throw failures.front();
    made->shared = std::make_shared<solver::SharedWork>();
    double dofs = made->space.n_dofs();
    for (const KnownMesh& one : meshes_) dofs += one.mesh->space.n_dofs();
    for (; !meshes_.empty() && dofs > most_dofs_kept; forget(meshes_.begin()))
      dofs -= meshes_.front().mesh->space.n_dofs();
    meshes_.push_back({std::move(key), made});
    return made;
  }

  /// The terms of the Cea type inequality for a row, against what its error is measured against.
  void take_terms(const Script& script, const solver::Discretisation& d, StudyRow& row) {
    const auto& plan = *script.plan;
    if (!row.error || plan.problem.time.is_static ||
        plan.problem.time.scheme != solver::Scheme::backward_euler)
      return;
    if (kind_ != ModelStudy::Reference::exact) {
      row.cea = solver::cea_terms(solver::fine_trajectory(*reference_problem_, reference_),
                                  plan.problem, d);
      return;
    }
    if (d.space.n_dofs() > most_dofs_for_terms) return;
    if (fine_for_ != &d)
      fine_ = solver::fine_exact(plan.problem, d.mesh, script.model->study->exact), fine_for_ = &d;
    row.cea = solver::cea_terms(fine_, plan.problem, d);
  }

  /// One setting; `keeps`: its steps become the reference.
  Exit run_row(StudyRow& row, bool keeps) {
    if (const Exit code = try_row(row, keeps); code != exit_ok) return code;
    journal_.keep(row);
    done_weight_ += weight(row);
    return exit_ok;
  }

  Exit try_row(StudyRow& row, bool keeps) {
    const auto session = compile_row(row);
    Script& script = session->script;
    if (!script.plan && keeps) { // nothing can be compared with it
      show_diagnostics(script, options_);
      return exit_script;
    }
    if (!script.plan) {
      row.failure = first_mistake(script);
      return exit_ok;
    }
    script.plan->report.fields.clear(), script.plan->report.pictures.clear();
    script.plan->report.lines.clear(), script.plan->report.plots.clear();
    forget_peak();
    resident_ = solver::memory_peak();
    try {
      const auto discretisation = discretisation_of(*script.plan);
      measure(script, discretisation, row, keeps);
      take_terms(script, *discretisation, row);
    } catch (const solver::Failure& failure) {
      using K = solver::FailureKind; // these are no property of the row
      if (failure.kind == K::interrupted || failure.kind == K::missing_file) {
        const Exit code = session->refuse(failure);
        show_diagnostics(script, options_);
        return code;
      }
      row.failure = failure.what();
    }
    return exit_ok;
  }

  std::unique_ptr<Gauge> gauge_for(const Script& script, const solver::Discretisation& d,
                                   bool keeps) const {
    auto norms = solver::norms_of(script.plan->problem, d);
    if (kind_ == ModelStudy::Reference::exact)
      return solver::exact_gauge(d, script.model->study->exact, std::move(norms));
    return keeps || study_.sweep ? nullptr
                                 : solver::trajectory_gauge(reference_, d, std::move(norms));
  }

  void take_errors(const Gauge& gauge, StudyRow& row) const {
    if (!study_.unknowns.empty()) row.errors = gauge.errors();
    take_error(row);
    if (study_.unknowns.empty()) row.error = gauge.error();
  }
  /// Of several unknowns: what the row is judged by.
  void take_error(StudyRow& row) const {
    if (!row.errors.empty())
      row.error = study_.in ? row.errors[*study_.in] : solver::together(row.errors);
  }

  void measure(const Script& script, const std::shared_ptr<solver::Discretisation>& d,
               StudyRow& row, bool keeps) {
    const auto gauge = gauge_for(script, *d, keeps);
    auto trajectory = std::make_shared<solver::Trajectory>();
    trajectory->discretisation = d;
    const bool rung = is_rung(row), kept = keeps || rung;
    double watching = 0.0, watching_wall = 0.0;
    const auto& plan = *script.plan;
    solver::RunSettings settings;
    settings.stop = &stop_flag();
    settings.on_start = [&](double t, const solver::Vector& u) {
      if (kept) trajectory->times.push_back(t), trajectory->states.push_back(u);
    };
    settings.on_step = [&](int, double t, const solver::Vector& u, const solver::Vector&) {
      const solver::PhaseClock<> clock(watching);
      const auto start = std::chrono::steady_clock::now();
      if (kept) trajectory->times.push_back(t), trajectory->states.push_back(u);
      if (gauge) gauge->step(t, u);
      watching_wall +=
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    settings.on_restart = [&] {
      trajectory->times.clear(), trajectory->states.clear();
      if (gauge) gauge->forget();
    };
    const auto start = std::chrono::steady_clock::now();
    const auto result = solver::run(plan, *d, settings);
    row.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() -
               watching_wall + d->seconds;
    row.cpu = result.timing.total - watching;
    row.peak_bytes = std::max(0.0, solver::memory_peak() - resident_);
    if (meshes_.back().held < 0.0) {
      forget_peak();
      meshes_.back().held = std::max(0.0, solver::memory_peak() - resident_);
    }
    row.unknowns = result.unknowns, row.steps = result.steps, row.newton = result.work.newton;
    for (const auto& [name, value] : result.final)
      if (std::isfinite(value) && !name.empty()) row.probes[name] = value; // parts have no name
    if (gauge) take_errors(*gauge, row);
    if (keeps) reference_ = trajectory, reference_problem_ = plan.problem;
    if (rung) take_below(plan, trajectory, row);
    if (row.cpu < short_run) repeat(plan, *d, row);
  }

  /// How far the next coarser run on the diagonal is from this one.
  void take_below(const solver::Plan& plan, const std::shared_ptr<const solver::Trajectory>& now,
                  StudyRow& row) {
    if (coarser_) {
      const auto& d = *coarser_->discretisation;
      const auto gauge = solver::trajectory_gauge(now, d, solver::norms_of(plan.problem, d));
      const std::size_t begin = plan.problem.time.is_static ? 0 : 1; // all begin alike
      for (std::size_t i = begin; i < coarser_->states.size(); ++i)
        gauge->step(coarser_->times[i], coarser_->states[i]);
      row.below = gauge->errors();
    }
    coarser_ = now, coarser_values_ = row.values;
  }

  /// Short runs three times: the median.
  void repeat(const solver::Plan& plan, const solver::Discretisation& d, StudyRow& row) const {
    std::array<double, 3> cpu{row.cpu, 0.0, 0.0}, wall{row.wall, 0.0, 0.0};
    for (int k = 1; k < 3; ++k) {
      const auto start = std::chrono::steady_clock::now();
      cpu[k] = solver::run(plan, d, {}).timing.total;
      wall[k] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() +
                d.seconds;
    }
    std::sort(cpu.begin(), cpu.end()), std::sort(wall.begin(), wall.end());
    row.cpu = cpu[1], row.wall = wall[1];
  }

  std::string path_;
  const Options& options_;
  Study& study_;
  fs::path folder_;
  StudyJournal journal_;
  ModelStudy::Reference kind_ = ModelStudy::Reference::finest;
  std::shared_ptr<const solver::Trajectory> reference_;
  std::optional<solver::Problem> reference_problem_;
  std::shared_ptr<const solver::Trajectory> coarser_; ///< of the last run on the diagonal
  std::map<std::string, std::string> coarser_values_;
  std::vector<KnownMesh> meshes_;
  double resident_ = 0.0; ///< bytes before a row
  solver::FineSolution fine_;
  const solver::Discretisation* fine_for_ = nullptr;
  double done_weight_ = 0.0;
  HeldOutputs outputs_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

} // namespace

int study_command(const std::string& path, const Options& options) {
  Study study;
  const InterruptGuard guard;
  Studying studying(path, options, study);
  try {
    if (const int code = studying.go(); code != exit_ok) return code;
  } catch (const solver::Failure& failure) { // a file that was there is not to be read again
    const Ending ending = ending_of(failure.kind);
    tell("error[{}]: {}\n", ending.code, failure.what());
    return ending.exit;
  }
  judge(study, study.reference == "the finest run, extrapolated");
  const int code = report_study(path, study, studying.folder(), options);
  const auto failed = [](const StudyRow& row) { return !row.failure.empty(); };
  if (code != exit_ok || !std::ranges::all_of(study.rows, failed)) return code;
  tell("hvi-run: no setting of the study has a result: {}\n", study.rows.front().failure);
  return exit_solve;
}

} // namespace hvi::lang
