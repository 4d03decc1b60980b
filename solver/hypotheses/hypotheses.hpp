// The hypotheses of the existence theorem as numbers, for one plan on one mesh.
#pragma once

#include "solver/common/bracket.hpp"
#include "solver/time/run.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

enum class Answer { holds, fails, open };

/// One line of the report: `value` is the number that decides, where there is one.
struct Hypothesis {
  std::string name, what;
  std::optional<double> value;
  Answer answer = Answer::open;
  Origin origin; ///< what in the script decides it
  std::string note;
  std::optional<Bracket> known{}; ///< how `value` was found, where that is told
};

/// Numbers relative to the norm of V, || eps(v) || (scalar: || grad v ||, with the mass where
/// nothing is fixed). Not a number: not declared, or not found.
struct TheoryConstants {
  double m_1, m_2;              ///< least eigenvalues of the tensors of A and B, pointwise
  double m_A, m_B;              ///< coercivity of A and of B on this mesh
  double c_E, c_q, lipschitz_q; ///< of the memory: ||E||, sup |q|, Lipschitz in t
  double memory_step;           ///< largest sum ||E_m|| int over a step of |q_m(t_n, s)| ds
  double m_nu, m_tau, m_J, c_J; ///< of the laws on u: m_J = m_nu + m_tau as in the paper
  double norm_normal, norm_tangential, norm_full; ///< ||M||^2 on the parts with laws
  double norm_script; ///< ||M||^2 of the script's own M: the arguments of all laws on u together
  double longest_step;
  Bracket m_J_known, c_J_known; ///< m_J and c_J with how they were found
};

/// The same condition in several sharpnesses; each holds when positive.
struct Margins {
  double paper;     ///< m_B - (m_nu + m_tau) ||M||^2, full trace
  double largest;   ///< m_B - max m_i ||M||^2 with the script's own M, whose parts are orthogonal
  double split;     ///< m_B - lambda_max(sum m_i M_i^T W M_i, Gram)
  double against_b; ///< 1 - lambda_max(sum m_i M_i^T W M_i, sym B)
  double step;      ///< 1 - lambda_max(sum m_i M_i^T W M_i, sym K), K of the worst step
  /// Of the laws on u', against A: m_A - lambda_max(sum m_i M_i^T W M_i, Gram), and against A
  /// itself; m_A and 1 where there are none. The others are of the laws on u.
  double rate_split = 0.0, rate_against_a = 0.0;
};

/// What the form A of u' is: it decides which theorem there is for the evolution.
enum class RateForm {
  none, ///< there is none
  in_v, ///< coercive in V: Theorem 3.2
  in_h, ///< coercive in H = L2 only: a parabolic problem
  weak  ///< neither, or not known
};

struct HypothesisReport {
  std::vector<Hypothesis> hypotheses;
  TheoryConstants constants;
  Margins margins;
  int worst_step = 1; ///< the step of `margins.step`, the first with its matrix
  RateForm rate_form = RateForm::none;
  std::vector<std::pair<std::string, double>> tau_0; ///< bounds on the step, by the paper's formula
  /// m_A / k + m_B - m_J ||M||^2 - memory_step with the sharpest of the margins, of the worst step
  double usable;
  bool discrete = false;   ///< every step has exactly one solution, on this mesh: by proof
  bool continuous = false; ///< a theorem applies, as far as a mesh and its refinement can tell
  std::string discrete_verdict, continuous_verdict;
};

/// Eigenvalues by Lanczos with the factored Gram matrix. `extrapolate`: the trace norms also on the
/// refined mesh, for the continuous problem (a mesh bounds them from below only).
HypothesisReport check_hypotheses(const Plan& plan, const Discretisation& discretisation,
                                  bool extrapolate = true);

} // namespace hvi::solver
