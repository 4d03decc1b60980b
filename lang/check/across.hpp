// What plane strain has across its plane, carried beside what is computed with: the stress zz,
// which no equation needs and which equivalent stresses ask for.
//
// Field::across is, of a fourth-order tensor, its entries C_zzkl (row-major in k, l); of a matrix
// its entry zz; of scalars linear in v, what they have of the strains zz. That of v is a variable
// of its own (`strain_across`), which is zero and only tells where it stands. So A : eps(u) has
// C_zzkl eps_kl(u), and (A : eps(u)) : eps(v) that times the strain zz of v.
#pragma once

#include "lang/check/value.hpp"

namespace hvi::lang {

/// The strain zz of the test function of an unknown.
Symbol strain_across(int unknown);
/// The factor of the strain zz of an unknown's test function in a scalar linear in all of them;
/// empty: not known.
std::vector<Symbol> stress_across(const Field& f, int unknown);
/// Of left + sign right.
std::vector<Symbol> across_of_sum(const Field& left, const Field& right, double sign);
/// Of factor * body, the factor a scalar.
std::vector<Symbol> across_of_product(const Field& factor, const Field& body);
/// Of left : right.
std::vector<Symbol> across_of_contraction(const Field& left, const Field& right);
/// Of eps(f) and div(f), f a vector: no strain of u, and that of v itself.
std::vector<Symbol> across_of_strain(const Field& f);
/// What is known of f; of a scalar for which nothing was computed, what its gradients of test
/// functions leave open: squares, which nothing that is linear has.
std::vector<Symbol> across_of_scalar(const Field& f);

} // namespace hvi::lang
