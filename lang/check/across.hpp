// What plane strain has across its plane, carried beside what is computed with: the stress zz,
// which no equation needs and which equivalent stresses ask for.
//
// Field::across is, of a fourth-order tensor, its entries C_zzkl (row-major in k, l); of a matrix
// that is not of v, its entry zz; of eps(v) and of scalars linear in v, the factor of the strain zz
// of v. So A : eps(u) has C_zzkl eps_kl(u), and (A : eps(u)) : eps(v) as well.
#pragma once

#include "lang/check/value.hpp"

namespace hvi::lang {

/// Of left + sign right.
std::vector<Symbol> across_of_sum(const Field& left, const Field& right, double sign);
/// Of factor * body, the factor a scalar.
std::vector<Symbol> across_of_product(const Field& factor, const Field& body);
/// Of left : right.
std::vector<Symbol> across_of_contraction(const Field& left, const Field& right);
/// Of eps(f) and div(f), f a vector: no strain of u, and that of v itself.
std::vector<Symbol> across_of_strain(const Field& f);
/// The same of a scalar linear in v that no gradient of v is in: zero. Else what is known.
std::vector<Symbol> across_of_scalar(const Field& f);

} // namespace hvi::lang
