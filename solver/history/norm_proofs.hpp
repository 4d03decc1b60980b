// Norms of a kernel by interval arithmetic, for the hypotheses.
#pragma once

#include "solver/common/bracket.hpp"
#include "solver/history/history.hpp"

namespace hvi::solver {

/// What is proved of q(t, lag) over t0 <= t <= t1, 0 <= lag <= t - t0. Infinite upper ends: nothing
/// (a singularity, a function without an interval rule).
struct NormProofs {
  Bracket sup;       ///< of |q|
  Bracket lipschitz; ///< sup |q_t + q_lag|: the constant of H(q); sampled where q has breaks
  Bracket l1;        ///< sup over t of int |q(t, lag)| dlag
};

/// sup by branch and bound (largest.hpp). l1 on cells of the lag: where q keeps its sign and
/// depends on the lag only, by the midpoint rule with its remainder h^3 q'' / 24 (R. E. Moore,
/// R. B. Kearfott and M. J. Cloud, Introduction to Interval Analysis, 2009, chapter 9); else by the
/// enclosure of |q|.
///
/// `seen`: the norms by samples and quadrature, which the brackets hold.
NormProofs prove_norms(const Expr& q, const KernelNorms& seen, double t0, double t1);

} // namespace hvi::solver
