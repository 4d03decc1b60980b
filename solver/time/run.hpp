// The run: from a plan to certified steps. What the language's driver and a C++ user call.
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/history/history.hpp"
#include "solver/plan/plan.hpp"

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

class SharedWork;

/// Mesh, parts and space of a plan, made once and shared by run, check and study.
struct Discretisation {
  Mesh mesh;
  std::vector<Region> parts;
  Space space; ///< points into `mesh`
  DofMap dofs;
  double seconds = 0;
  /// Nodes of the first side of a pair that have no partner: how many, and one of them.
  struct Alone {
    int part = 0, points = 0;
    Point first{};
  };
  std::vector<Alone> alone;
  std::shared_ptr<SharedWork> shared; ///< set: what a run computes, later runs on it take over
  Discretisation() = default;
  Discretisation(const Discretisation&) = delete;
  Discretisation& operator=(const Discretisation&) = delete;
};
/// All mesh and part mistakes of the plan at once (several missing groups: several failures).
/// Includes: unknown groups, empty parts, a law or load on a clamped facet, a law twice on a part,
/// a point that is no node, an initial state that contradicts the imposed values.
/// A mesh that is adapted is solved on meanwhile, until `stop`: throws Failure(interrupted).
std::vector<Failure> discretise(const Plan& plan, Discretisation& out,
                                const std::atomic<bool>* stop = nullptr);
/// The same on a given mesh, which must have the groups the plan's mesh has.
std::vector<Failure> discretise_on(const Plan& plan, Mesh mesh, Discretisation& out);

struct Certificate {
  bool certified = false;
  double inclusion = 0, equilibrium = 0, tolerance = 0; ///< worst over the steps
  std::optional<double> states; ///< the same of the states' equations, where there are states
  std::string mode = "full";    ///< or "contact rows every step, ..."
  int worst_step = 0;
  int inclusion_step = 0, equilibrium_step = 0; ///< where each was worst
};

/// What rounding, of the assembly too, may have done to a printed column: an estimate, three times
/// the root mean square of samples (rounding_estimate.cpp).
struct ColumnError {
  std::string name;
  double absolute = 0.0;
  /// By the column's largest value, and by what a translation or a strain of the solution's own
  /// size makes of it: a column that is zero by symmetry is not judged by itself.
  double relative = 0.0;
};

struct ForwardError {
  std::vector<ColumnError> columns; ///< in the order of the probes, but for parts of others
  double solution = 0.0;            ///< of u at the nodes, by its largest value
  double amplification = 1.0;       ///< of the errors of one step by the steps together
  double condition = 0.0;           ///< of the last step's matrix, in the 1-norm; 0: not asked for
  bool refined = false;             ///< steps were refined with residuals in extended precision
  double worst() const;             ///< the largest relative one; NaN counts as infinite
  /// Beyond this a run is not certified.
  static constexpr double largest = 1e-2;
  /// Beyond this a run says so.
  static constexpr double small = 1e-6;
};

/// What helps where a result is mostly rounding.
inline constexpr const char* better_conditioned =
    "fewer, better shaped cells, or units and stiffnesses closer to each other, make the matrix "
    "better conditioned";

/// Seconds of CPU time by phase; history, triangular solves and inequality, parts of
/// steps, by the wall clock.
struct Timing {
  double mesh = 0, assembly = 0, ordering = 0, factor = 0, history = 0, triangular_solves = 0,
         inequality = 0, steps = 0, output = 0, total = 0;
  double factor_bytes_read = 0; ///< by all triangular solves
};

/// Work done, counted: what the tests of "only the effects a scene calls for" compare.
struct WorkCounters {
  int matrices = 0, analyses = 0, factorisations = 0, triangular_solves = 0, products = 0,
      newton = 0, history_fields = 0, fallback_steps = 0;
  /// Steps whose branch was followed from the last state, the inner steps that took, and steps
  /// where that could not be done.
  int followed_steps = 0, inner_steps = 0, unfollowed_steps = 0;
  int iterations = 0;           ///< of iterative solvers
  std::int64_t field_reads = 0; ///< of stored history fields
  double bytes = 0;
};

struct StepNote {
  int step;
  double t;
  std::string what; ///< "3 points released (downward jump)", "snap to a new branch"
  Origin origin;
};

/// Columns with a value a step: energies, the quantities of Lemma 3.2, the certificate
/// (energy.hpp).
struct MonitorTable {
  std::vector<std::string> names;
  std::vector<double> times;
  std::vector<std::vector<double>> columns;
  double balance_error = 0; ///< of the work identity, relative to its parts
};

/// What a picture shows, at its time or at the end.
struct PictureValues {
  Vector u;                   ///< full vector
  std::vector<double> values; ///< at the nodes of the space, components of a node side by side
};

/// Direct or iterative.
struct ChosenSolver {
  LinearSolver solver = LinearSolver::direct;
  std::string why; ///< empty: it was asked for, or nothing was
};

struct RunResult {
  std::string script;
  ChosenSolver solver;
  std::string path; ///< why states hold all unknowns; empty: the contact unknowns (reduce.hpp)
  int unknowns = 0, contact_unknowns = 0, steps = 0;
  std::vector<double> times;                          ///< of the table's rows
  std::map<std::string, std::vector<double>> columns; ///< by probe name
  std::vector<std::string> column_order;
  std::map<std::string, double> final; ///< every probe at the last step (or its time)
  Certificate certificate;
  ForwardError forward_error;
  Timing timing;
  WorkCounters work;
  std::vector<HistoryReport> histories;
  std::vector<EffectNote> effects; ///< with asleep filled in
  std::vector<StepNote> notes;
  std::vector<int> events;      ///< by row of the table: points released, or -1 for a snap
  bool unique = true;           ///< has every step's problem one solution?
  std::optional<double> energy; ///< of the last state, where more than one is possible
  std::optional<MonitorTable> monitors;
  int resumed_from = 0;             ///< the step of the checkpoint that was gone on from
  std::optional<Failure> unwritten; ///< of the first file that could not be written; none: all were
  std::vector<std::string> files;   ///< written, relative to the output folder
  Vector u;                         ///< full vector at the end
  std::vector<PictureValues> pictures;
};

struct Progress {
  int step, steps, newton;
  double seconds;
};
struct RunSettings {
  std::string output_folder; ///< empty: no files
  std::string name = "result";
  std::function<void(const Progress&)> progress;
  /// Called after every accepted step with (n, t, u, xi of all law points).
  std::function<void(int, double, const Vector&, const Vector&)> on_step;
  /// Told at once when a file cannot be written. The run goes on: see RunResult::unwritten.
  std::function<void(const std::string&)> warn;
  const std::atomic<bool>* stop = nullptr; ///< set by Ctrl-C: ends with Failure(interrupted), or
                                           ///< Failure(suspended) where it saves its state
  /// Every so many steps, at the end and on `stop` the state goes to <folder>/<name>.checkpoint;
  /// 0: never. `resume`: goes on from that file when it is there, with the same bits.
  int checkpoint_every = 0;
  bool resume = false;
  bool condition =
      false; ///< always fill ForwardError::condition, else where it costs next to nothing
  bool monitors = false; ///< fill RunResult::monitors and write <name>_monitors.csv
};

/// Solves. Throws Failure(not_certified) at a step without certificate, with its number in the
/// message and the law's origin; what was computed up to the last good step is in `partial`.
/// Tables reach the disk meanwhile: a killed run leaves all rows but those of its last second.
RunResult run(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
              RunResult* partial = nullptr);

} // namespace hvi::solver
