// The laws of a plan as constants and as forms, for the hypotheses.
#pragma once

#include "solver/common/bracket.hpp"
#include "solver/discrete/contact.hpp"
#include "solver/linear/extremes.hpp"
#include "solver/time/run.hpp"

#include <vector>

namespace hvi::solver {

/// Constants of one law term: the worst over its part of space and over all times.
struct TermConstants {
  int term = 0;           ///< index into Problem::law_terms
  bool radial = false;    ///< of a vector, as friction
  Bracket m, c;           ///< m_J and c_J of H(J)
  double lipschitz = 0.0; ///< of the slope; infinite where it jumps
  bool regular = true;
  bool jumps_down = false;
  double at = 0.0; ///< the argument where m is attained
};
std::vector<TermConstants>
law_constants(const Problem& problem, const Discretisation& discretisation, const Contact& contact);

/// Largest eigenvalue against the Gram matrix of the traces on the parts with laws.
struct TraceNorms {
  double normal = 0.0, tangential = 0.0, full = 0.0;
};
TraceNorms trace_norms(const Problem& problem, const Discretisation& discretisation,
                       const StateLayout& layout, const GramForm& gram);

} // namespace hvi::solver
