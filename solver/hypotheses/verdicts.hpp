// From the numbers of the theory to sentences: which theorem applies, and what it claims.
#pragma once

#include "solver/hypotheses/hypotheses.hpp"

namespace hvi::solver {

/// What the verdicts need beside the rows.
struct VerdictFacts {
  bool is_static = false;
  bool moves = false; ///< there is inertia
  bool has_laws = false, has_rate_laws = false,
       has_memory_laws = false;                   ///< on u; on u'; on memories
  double lipschitz = 0.0, lipschitz_memory = 0.0; ///< of the slopes of laws on u; on memories
  bool has_memory = false;                        ///< some of it acts
  bool integrable = true;                         ///< int |q| of every kernel is finite
  bool proved = true;         ///< m_J of the laws is bounded by proof, not sampled
  bool coupled = false;       ///< a law's bound is another law's multiplier
  bool reads = false;         ///< a law without such a bound reads the solution
  bool states = false;        ///< laws, forms or loads change with states
  bool only_time = false;     ///< with none but time
  bool loads_read = false;    ///< a load reads the solution
  bool semi_coercive = false; ///< no form and no value holds the body, laws do
  bool springs_hold = false;  ///< and these have slopes that rise everywhere, and do not soften
  bool multipliers = false;   ///< an unknown has no form of its own
  bool inf_sup = true;        ///< and the others see all of it
  std::string unseen_at_rest; ///< one that they do not see where laws with jumps hold them
  bool skew_rates = false;    ///< several unknowns, whose A is not symmetric
  double steps_margin = 0.0;  ///< no step has a smaller one
  double step_bound = 0.0;    ///< on the step, where A is coercive and (H0) fails
  /// (H0) in three sharpnesses, on ever finer meshes; where there is no estimate: of this mesh.
  std::optional<double> whole, split, against_b;
  std::optional<double> rate_against_a; ///< m_A > m_J ||M||^2 of the laws on u', against A itself
};

/// Sets both verdicts, and adds the rows `theorem`: one solution, its regularity, its error.
///
/// - Static: B coercive and (H0).
/// - No term with u': at each t a static problem whose load holds the memory. B coercive and (H0)
///   make its solution unique and Lipschitz in the load, with 1 / (m_B - m_J |M|^2), and the memory
///   of two functions differs at t by no more than ||E|| int |q(t, s)| |u_1 - u_2|(s) ds: a
///   history-dependent operator, which with that has one fixed point (Banach's theorem, as in
///   J. Ogorzaly, Quasistatic contact problem with unilateral constraint for elastic-viscoplastic
///   materials, 2016; S. Migorski, Y. Bai and S. Zeng, A new class of history-dependent quasi
///   variational-hemivariational inequalities with constraints, 2023). q need not be Lipschitz.
/// - A coercive in V: Theorem 3.2. Neither (H0) nor a coercive B is needed, for with
///   e = u_1 - u_2 the difference of the two problems, tested with e, gives
///   m_A |e(t)|^2 / 2 <= (m_J |M|^2 - m_B) int |e|^2 + c_E c_q (int |e|)^2, and Gronwall's lemma
///   e = 0; a step is as good for k < step_bound, and so are the bounds of Lemma 3.2.
/// - A coercive in H only: the same in the norm of H, for M is compact, so that
///   m_J |M e|^2 <= (m_B / 2) |e|^2 + C |e|_H^2 (Ehrling's lemma); B must be coercive. Then u' is
///   in L2(0, T; V*) only, and the error estimate, which tests with A in V, falls away.
/// - Laws on u': with w = u' the problem is one for w whose operators B, R and, where their slopes
///   are Lipschitz, the laws on u act on the history of w; one solution where A is coercive in V
///   and m_A > m_J |M|^2 of the laws on u' (the same fixed point; docs/theory.md).
/// - Inertia: the same for w = u' in the evolution triple V, H, V*, with a mass coercive in H; M is
///   compact, so that Ehrling's lemma takes the place of m_A > m_J |M|^2 (A. Kulig, Hyperbolic
///   hemivariational inequalities for dynamic viscoelastic contact problems, J. Elasticity 110
///   (2013) 1-31, for problems with long memory; docs/theory.md).
/// - Forms that leave rigid motions free: laws that rise everywhere and see them make the sum of B
///   and the laws coercive and monotone. Else the problem is semi-coercive, with a solution for
///   convex laws where <f, v> < J_inf(M v) for all these motions v (held_by_laws.hpp); its strains
///   are unique, the motion need not be.
void give_verdicts(const VerdictFacts& facts, HypothesisReport& report);

} // namespace hvi::solver
