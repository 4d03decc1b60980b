// Points of laws with jumps, which take up any force up to the jump where they rest, beside
// unknowns that have no form of their own.
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/linear/sparse.hpp"

#include <string>

namespace hvi::solver {

/// The rows of the points whose laws may have jumps, at some time of the plan. `g`: rows of all
/// points; its columns are taken in these units, and left out where they are 0. The largest row of
/// a point becomes 1: of those of a tangential part one may be rounding.
SparseMatrix rows_at_rest(const Problem& problem, const Contact& contact, const SparseMatrix& g,
                          const Vector& units);

/// Two solutions of a step with one u differ by p with  S_pp p = 0  and  S_up p = -R^T dxi, where S
/// is the matrix of the step on the contact unknowns, p those without a form of their own, u the
/// others and R the rows at rest. Is p = 0 the only one? `s`: dense, of contact.unknowns.
///
/// Are the products of the columns of S_pp and of what R^T leaves of S_up positive definite, beyond
/// rounding? u is in units of S_uu's diagonal, p and its equations in those of S_up's columns and
/// S_pu's rows.
bool determines_multipliers(const Problem& problem, const Contact& contact, const DenseMatrix& s);

/// The names of unknowns without a form of their own; empty: there are none.
std::string names_of_multipliers(const Problem& problem);

} // namespace hvi::solver
