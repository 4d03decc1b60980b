// The checked script: everything has a type, every name is resolved, every formula is symbolic.
// Made by the checker; lang/lower turns it into the engine's plan.
#pragma once

#include "lang/check/value.hpp"
#include "solver/plan/options.hpp"
#include "solver/plan/report.hpp"
#include "solver/plan/tensor.hpp"

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace hvi::lang {

/// A parameter with the value it has in this run.
struct ModelParam {
  std::string name;
  Span span;
  std::variant<double, std::string> value; ///< a number, or a word such as P2
  std::string range, doc;                  ///< as written
  bool overridden = false;                 ///< by whoever asks
  std::string unit;                        ///< in which it is declared, "GPa"; the value is in that
                                           ///< of the script
  double times = 1, over = 1;              ///< one such unit in that of the script, times/over

  /// A value as the script declares it, and as whoever sets the parameter gives it.
  double as_declared(double in_units) const { return in_units * over / times; }
};

/// What numbers are in, for a script with units.
struct ModelUnits {
  std::string system; ///< "mm, N, s"; empty: the script has no units
  /// Of t, unknowns, states and sigma; "1": no dimension.
  std::map<std::string, std::string> of;
  std::map<std::string, std::string> of_columns;   ///< of tables, and of t beside them
  std::map<std::string, std::string> of_laws;      ///< of their multipliers
  std::map<std::string, std::string> of_arguments; ///< of laws
  std::map<std::string, std::string> of_tensors;
  std::map<std::string, std::string> of_kernels; ///< of those that a memory has
  std::map<std::string, std::string> of_tests;   ///< test functions

  bool used() const { return !system.empty(); }
  /// " [mm]" for the column `tip`; nothing where the unit is not known or is 1.
  std::string behind(const std::string& column) const { return behind(of_columns, column); }
  std::string of_argument(const std::string& law) const { return behind(of_arguments, law); }
  std::string of_multiplier(const std::string& law) const { return behind(of_laws, law); }
  std::string of_kernel(const std::string& kernel) const { return behind(of_kernels, kernel); }
  static std::string bracketed(const std::string& unit) {
    return unit.empty() || unit == "1" ? "" : " [" + unit + "]";
  }

private:
  static std::string behind(const std::map<std::string, std::string>& units,
                            const std::string& name) {
    const auto found = units.find(name);
    return found == units.end() ? "" : bracketed(found->second);
  }
};

struct ModelPart {
  std::string name;
  Span span;
  solver::RegionSpec region;
  std::optional<solver::Group::Kind> kind; ///< when the mesh tells
};

/// sign * factor * integral(part, integrand). `right`: it stands on the right of >=.
struct ModelTerm {
  Span span;        ///< of the integral
  Span factor_span; ///< of the first factor, else of the integral
  int part = 0;
  solver::Rule rule = solver::Rule::exact;
  bool rule_given = false;
  bool right = false;
  Symbol factor = 1.0; ///< with the sign
  Field integrand;
};

/// A memory field int_0^t c(t, s) u(s) ds met in the form.
struct ModelHistory {
  std::string name;
  Span span;
  Symbol kernel;
  std::optional<solver::PronySeries> series; ///< where it was written as one
  std::vector<std::string> also;             ///< other kernels that have this factor of time
};

struct ModelLaw {
  std::string name;
  Span span;
  solver::LawSpec spec;
  Span reads_multiplier{}; ///< where its body reads another law's
};

/// A state of the points of a part.
struct ModelState {
  int declaration = -1; ///< of the checker
  Span span, rate_span;
  solver::StateTerm spec;
};

/// A tensor that varies in place: looked at on the mesh, on the parts where it is used.
struct ModelMaterial {
  Span span;
  Field value;           ///< rank 4 or 2, of slot::x and slot::inside
  bool elliptic = false; ///< a material of the library, which must be; else finite is enough
  std::set<int> parts;
};

struct Expectation {
  Span span;
  std::string probe;
  std::optional<double> time;
  double value = 0, tolerance = 0;
  bool relative = false, active = true;
  std::string source;
};

/// Is a row of this time the one that is meant by t?
inline bool is_at(double row, double t) { return std::abs(row - t) <= 1e-12 * (1.0 + std::abs(t)); }

struct StudyLadder {
  std::string parameter;
  Span span;
  std::vector<std::string> values; ///< as whoever asks would give them
  /// Parameters that climb together with it, each with as many values.
  std::vector<std::pair<std::string, std::vector<std::string>>> more{};
};

struct ModelStudy {
  Span span;
  std::vector<StudyLadder> ladders;
  enum class Reference { finest, richardson, exact, none } reference = Reference::finest;
  std::vector<Symbol> exact; ///< components of the exact solution, of slot::x and slot::t
  std::string norm;
  std::optional<std::size_t> unknown; ///< of several: the one whose error the rows are judged by
};

/// Something the checker found out that the plan tells.
struct ModelNote {
  std::string name;
  Span span;
  std::string what;
  bool taken = true; ///< false: it is known, but not what is computed with
};

struct Model {
  std::string title;
  int dim = 2;
  std::vector<ModelParam> params;
  ModelUnits units;
  solver::MeshSpec mesh;
  std::vector<ModelPart> parts;
  solver::SpaceSpec space; ///< its dirichlet values are filled in
  std::vector<std::string> unknowns, tests;
  std::vector<ModelTerm> terms;
  bool lacks_terms = false;   ///< a mistake left some out: what is in none may be in those
  bool lacks_columns = false; ///< the same of columns of tables, whose names are not known
  std::vector<std::string> lost_columns;   ///< those whose names are
  std::vector<solver::TensorSpec> tensors; ///< as they were written
  std::vector<ModelHistory> histories;
  std::vector<ModelLaw> laws;
  std::vector<ModelState> states;
  std::vector<ModelNote> notes;
  std::vector<ModelMaterial> materials;
  solver::TimeSpec time;
  bool has_time = false;
  bool starts_at_rest = false; ///< from the solution of the static problem at the initial time
  solver::SolverOptions options;
  std::optional<double> accuracy;
  std::string accuracy_of;
  solver::ReportSpec report;
  std::vector<Expectation> expectations;
  std::optional<ModelStudy> study;
  std::vector<std::string> files_read; ///< of tables
  std::vector<Span> origins;           ///< what a solver::Origin's id stands for

  solver::Origin origin(const Span& span) {
    origins.push_back(span);
    return {static_cast<int>(origins.size()) - 1};
  }
};

/// The typed model as text (hvi-run dump --model).
std::string to_string(const Model& model);

} // namespace hvi::lang
