// What plane strain has across its plane, carried beside what is computed with: the stress zz,
// which no equation needs and which equivalent stresses ask for.
//
// Field::across is, of a fourth-order tensor, its entries C_zzkl (row-major in k, l); of a matrix
// its entry zz; of scalars linear in v, what they have of the strains zz. That of v is a variable
// of its own (`strain_across`), which is zero and only tells where it stands. So A : eps(u) has
// C_zzkl eps_kl(u), and (A : eps(u)) : eps(v) that times the strain zz of v.
//
// A material whose axes stand oblique to the plane makes shears across it as well. They ride along
// as factors of two more variables (`shear_across`): what stands for C_zzkl is then
// C_zzkl + e_xz C_xzkl + e_yz C_yzkl, and what became of it the stress zz with e = 0, and the shear
// iz as its derivative by e_iz.
#pragma once

#include "lang/check/value.hpp"
#include "solver/plan/tensor.hpp"

namespace hvi::lang {

/// Of a tensor; empty: not known.
std::vector<Symbol> across_of_tensor(const solver::TensorSpec& tensor);
/// The stress zz of what is known across a plane, and its shear iz, i < 2.
Symbol normal_across(const Symbol& across);
Symbol shear_across(const Symbol& across, int i);
/// The entries zz, xz, yz of a matrix in plane strain where they are known; of anything else none.
std::vector<Symbol> entries_across_plane(const Field& f);
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
