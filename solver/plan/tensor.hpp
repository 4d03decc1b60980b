// A material's tensor as it was written: by its kind and its constants.
#pragma once

#include "solver/common/failure.hpp"
#include "solver/kernel/expr.hpp"
#include "solver/mesh/mesh.hpp"

#include <array>
#include <string>
#include <vector>

namespace hvi::solver {

struct TensorSpec {
  /// isotropic:   lambda, mu                     lambda d_ij d_kl + mu (d_ik d_jl + d_il d_jk)
  /// orthotropic: E_x, E_y, E_z, nu_xy, nu_yz, nu_xz, G_xy, G_yz, G_xz, along `axes`;
  ///              nu_ij/E_i = nu_ji/E_j
  /// transverse:  E, nu in the plane of the first two axes; E, nu, G along the third, nu the strain
  ///              in the plane for stress along the axis
  /// general:     all d^4 components
  enum class Kind { isotropic, orthotropic, transverse, general };
  std::string name; ///< "B"; empty: it has none
  Origin origin;
  Kind kind = Kind::isotropic;
  std::vector<Expr> constants; ///< of slot::x, slot::normal and states
  /// Rows: the material's axes, of length one.
  std::array<Point, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// How many constants a kind has, in d dimensions.
int count_constants(TensorSpec::Kind kind, int dim);
/// C_ijkl = C_klij, whatever the constants.
constexpr bool has_major_symmetry(TensorSpec::Kind kind) {
  return kind != TensorSpec::Kind::general;
}
/// C_ijkl, row-major, d^4 of them. Of a section (d = 2) the strains along z are 0.
std::vector<Expr> components(const TensorSpec& tensor, int dim);

/// C_izkl of a section, row-major in k, l: what the strains in it do across it, i = 2 for the
/// stress zz. Empty: not known.
std::vector<Expr> components_across(const TensorSpec& tensor, int i);
/// Do strains in a section make shears across it, xz or yz? Of a general tensor it is not known.
bool shears_across(const TensorSpec& tensor);

/// The tensor whose matrix on Voigt stresses and engineering strains is m, row-major; order: xx,
/// yy, xy and xx, yy, zz, yz, xz, xy.
std::vector<Expr> of_voigt_matrix(int dim, const std::vector<Expr>& m);

/// The same tensor, whatever it is called?
bool same_tensor(const TensorSpec& a, const TensorSpec& b);

} // namespace hvi::solver
