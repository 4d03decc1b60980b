// Is a step solved? Two numbers, computed from the definitions, not from the solver's own
// residuals.
#pragma once

#include "solver/discrete/contact.hpp"

#include <functional>
#include <span>

namespace hvi::solver {

/// y -= A x. Four sums at a time: one would wait for its own last addition.
void subtract_product(const SparseMatrix& a, const Vector& x, Vector& y);

/// gap = b - K d and scale_i = (|K| |d|)_i + |b_i| in one reading of K.
void gap_and_scale(const SparseMatrix& k, const Vector& d, const Vector& b, Vector& gap,
                   Vector& scale);

/// max_i |R_i| / (scale + |G^T W| |xi| + s / 100)_i with R = gap - G^T W xi: the componentwise
/// backward error of the equilibrium on the unknowns (W. Oettli, W. Prager, "Compatibility of
/// approximate solution of linear equations with given error bounds for coefficients and right-hand
/// sides", Numer. Math. 6, 1964). s_i = K_ii max |d_j| + (|G^T W| 1)_i max |xi| with the d_j of the
/// row is the size its terms would have with rotated axes: in a row where they vanish the residual
/// is rounding of the other rows, and which rows vanish depends on the axes.
double equilibrium_error(const SparseMatrix& k, const Vector& d, const Vector& gap,
                         const Vector& scale, const Reactions& reactions, const Vector& xi);
/// The same with K_ii max |d_j| by row (MatrixRows::whole_sizes).
double equilibrium_error(const std::function<double(int)>& whole_size, const Vector& gap,
                         const Vector& scale, const Reactions& reactions, const Vector& xi);

/// Both in one reading of K: gap = b - K d, and the backward error. `contact`: the unknowns,
/// increasing, outside of which `force` has no entries.
double equilibrium_error(const SparseMatrix& k, const Vector& d, const Vector& b,
                         std::span<const int> contact, const Reactions& reactions, const Vector& xi,
                         Vector& gap);

/// The same with the product K d given: gap = b - K d. Reads a row of K only where |K_ii d_i| +
/// |(K d)_i - K_ii d_i|, which |K| |d| cannot fall below, does not show that another row is worse.
double equilibrium_error(const SparseMatrix& k, const Vector& diagonal, const Vector& kd,
                         const Vector& d, const Vector& b, std::span<const int> contact,
                         const Reactions& reactions, const Vector& xi, Vector& gap);

/// Sets contact.reach_i = |d_i| + (|(K d)_i - K_ii d_i| + |b_i|) / K_ii: how far the forces of its
/// own equation would move unknown i if the others were fixed. The scale of displacements where all
/// of them are rounding (a body that sticks everywhere).
/// `diagonal`: K_ii of the contact unknowns i, in their order.
void find_reach(const Vector& diagonal, const Vector& kd, const Vector& d, const Vector& b,
                Contact& contact);

/// The largest entry of |offset| + |G| (|w| + s reach) on the rows of a point of the term: what its
/// argument is made of.
double argument_scale(const Contact& contact, const ContactTerm& term, const ContactPoint& point,
                      const LawFields& fields);

/// The largest multiplier of a term, or what its law makes of the sizes of its arguments.
double multiplier_scale(const Contact& contact, const ContactTerm& term, const LawFields& fields,
                        const Vector& xi);

struct Inclusion {
  double worst = 0.0;   ///< max_p dist(xi_p, dj_p(z_p)) / max(|xi|_inf, slope scale of the law)
  int worst_term = -1;  ///< index into Problem::law_terms
  int worst_point = -1; ///< index into ReducedProblem::points
};
/// Inclusion xi_p in dj_p(z_p) at z = G w + offset, w the field the law acts on and s its factor,
/// with |xi|_inf taken over the points of the law. An argument is known up to `tolerance` times the
/// largest entry of |offset| + |G| (|w| + s reach) on its rows: what it is made of, however much of
/// that cancels, and the displacement that the forces at its unknowns amount to. A relative error
/// of that size in the data of the step moves it so far.
Inclusion inclusion_error(const Contact& contact, const LawFields& fields, const Vector& xi,
                          double tolerance, Vector& z);

} // namespace hvi::solver
