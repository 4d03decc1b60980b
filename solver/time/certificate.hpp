// Is a step solved? Two numbers, computed from the definitions and from nothing the solver claims.
#pragma once

#include "solver/time/contact.hpp"

#include <span>

namespace hvi::solver {

/// y -= A x. Four sums at a time: one would wait for its own last addition.
void subtract_product(const SparseMatrix& a, const Vector& x, Vector& y);

/// gap = b - K d and scale_i = (|K| |d|)_i + |b_i| in one reading of K.
void gap_and_scale(const SparseMatrix& k, const Vector& d, const Vector& b, Vector& gap,
                   Vector& scale);

/// max_i |R_i| / scale_i with R = gap - G^T W xi: the componentwise backward error of the
/// equilibrium on the unknowns (rows with R_i = 0 count 0). `work` is scratch of the same length.
double equilibrium_error(const Vector& gap, const Vector& scale, const SparseMatrix& force,
                         const Vector& xi, Vector& work);

/// Both in one reading of K: gap = b - K d, and the backward error. `contact`: the unknowns,
/// increasing, outside of which `force` has no entries.
double equilibrium_error(const SparseMatrix& k, const Vector& d, const Vector& b,
                         std::span<const int> contact, const SparseMatrix& force, const Vector& xi,
                         Vector& gap);

/// The same with the product K d given: gap = b - K d. Reads a row of K only where |K_ii d_i| +
/// |(K d)_i - K_ii d_i|, which |K| |d| cannot fall below, does not show that another row is worse.
double equilibrium_error(const SparseMatrix& k, const Vector& diagonal, const Vector& kd,
                         const Vector& d, const Vector& b, std::span<const int> contact,
                         const SparseMatrix& force, const Vector& xi, Vector& gap);

struct Inclusion {
  double worst = 0.0;   ///< max_p dist(xi_p, dj_p(z_p)) / max(|xi|_inf, slope scale of the law)
  int worst_term = -1;  ///< index into Plan::law_terms
  int worst_point = -1; ///< index into ReducedProblem::points
};
/// Inclusion xi_p in dj_p(z_p) at z = G u + offset, with |xi|_inf taken over the points of the law.
/// z within `tolerance` (relative to the largest |z| of its term) of a break counts as on it.
Inclusion inclusion_error(const Contact& contact, const Vector& u, const Vector& xi,
                          double tolerance, Vector& z);

} // namespace hvi::solver
