// The rows of a report of hypotheses, one after the other; internal to solver/hypotheses.
#pragma once

#include "solver/formulation/step_weights.hpp"
#include "solver/hypotheses/hypotheses.hpp"
#include "solver/hypotheses/numbers.hpp"
#include "solver/hypotheses/tensors.hpp"
#include "solver/hypotheses/variation.hpp"
#include "solver/hypotheses/verdicts.hpp"

#include <cmath>
#include <map>

namespace hvi::solver {

inline constexpr int most_load_times = 65;

/// A number of a kernel or of a state with how it was found.
std::string with_word(double value, const Bracket& known);

class Judgement {
public:
  Judgement(const Plan& plan, const Discretisation& d)
      : plan_(plan), problem_(plan.problem), d_(d), numbers_(plan, d) {
    facts_.is_static = problem_.time.is_static;
    facts_.moves = in_motion(problem_);
    for (const auto& term : problem_.law_terms)
      (term.field == field_of_u(0) ? facts_.has_laws
       : is_memory(term.field)     ? facts_.has_memory_laws
                                   : facts_.has_rate_laws) = true;
  }
  HypothesisReport report(bool extrapolate);

private:
  Hypothesis& row(std::string name, std::string what, std::optional<double> value, Answer answer,
                  Origin origin = {}, std::string note = {});
  static Answer yes(bool holds) { return holds ? Answer::holds : Answer::fails; }
  static Answer positive(double v) { return std::isnan(v) ? Answer::open : yes(v > 0.0); }
  TheoryConstants& c() { return out_.constants; }

  // Forms, memories and loads: hypotheses.cpp
  void longest_step();
  std::string place(const Ellipticity& e) const;
  void judge_space();
  void judge_inertia();
  void judge_a();
  /// Coercive in V or in H? A tensor that is elliptic everywhere is the former's proof; else the
  /// least eigenvalue goes to 0 under refinement where it is the latter only.
  void judge_rate();
  std::optional<std::string> falls_with_the_mesh() const;
  void judge_b();
  void judge_memory();
  /// The modulus B + E int q after a jump of the strain, against B: told where it leaves (0, 1].
  void judge_modulus(int m);
  /// How many times B is E: where one is no multiple of the other, by their traces.
  double memory_against_elasticity(int m) const;
  void judge_loads();
  void judge_given();
  /// Whether a load was found that is no functional on V.
  bool judge_load_places();
  /// Whether a load was found that is not bounded in time: then it must be square integrable.
  bool judge_load_times();
  Origin form_origin(int field) const;

  // held_rows.cpp
  /// Unknowns without a form of their own: a pressure.
  void judge_multipliers();
  /// A pair of elements is stable where the constant keeps off 0 on ever finer meshes.
  void refine_inf_sup(const Numbers& finer);
  /// What the forms leave free has to be held by laws, and these need the load's help.
  void judge_free_body();
  /// At some times of the grid, for laws that are the same at all times.
  void judge_balance(const FreeBody& body);

  // law_rows.cpp
  /// The steepest descent of laws on the unknown and on its rate.
  struct Descents {
    Bracket normal, tangential, on_rate;
  };
  bool is_beyond(const LawTerm& term);
  void judge_law(const TermConstants& law, const LawTerm& term, Descents& descents);
  void judge_traces();
  void judge_laws();
  /// Lipschitz constants of the rates, by the state itself and by what they read.
  void judge_states();
  std::map<std::string, Variation> variations_of(const LoadTerm& load) const;
  void judge_load(const LoadTerm& load);
  /// Those of a law by the states, the values and the multiplier that it reads.
  void judge_readings(const TermConstants& law, const LawTerm& term);
  void judge_variation(const char* name, const std::string& what, const Variation& found,
                       const Origin& origin);
  Origin law_on_memory() const;
  Origin law_origin(int field) const;
  std::string not_compact(bool on_rates) const;
  /// The law that softens most: it decides (H0).
  Origin worst_law() const;
  void judge_smallness();
  /// Laws on memories, which are a part of the history, and laws on u', against A in place of B.
  void judge_other_laws();

  // step_rows.cpp
  /// The step whose matrix leaves the least room, of all that differ.
  void judge_steps();
  const Vector& weights_of(int step) const;
  /// The paper's bounds on the step, the one that A alone gives, and the usable one.
  void bound_steps();

  // refined_rows.cpp
  /// Trace norms grow under refinement: twice the step from this mesh to the refined one is taken
  /// off the margins (as for order one, so rather too much).
  void refine_norms();
  void refine_margins(const Numbers& finer);

  const Plan& plan_;
  const Problem& problem_;
  const Discretisation& d_;
  Numbers numbers_;
  HypothesisReport out_;
  VerdictFacts facts_;
  StepWeights steps_;
  std::size_t rate_row_ = 0;                             ///< of "A is coercive in V"
  double product_ = 0.0;                                 ///< sum c_E c_q over the kernels
  std::vector<double> memory_norms_;                     ///< ||E_m||
  std::vector<std::pair<int, std::size_t>> multipliers_; ///< unknowns, and their rows
  std::vector<double> a_finer_;                          ///< on the refined mesh, by unknown
  std::optional<double> m_h_finer_;                      ///< there
};

} // namespace hvi::solver
