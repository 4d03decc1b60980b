// What a run gives back.
#pragma once

#include "solver/discrete/chosen_solver.hpp"
#include "solver/history/history.hpp"
#include "solver/linear/sparse.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/work.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

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

} // namespace hvi::solver
