// Components of materials; see tensor.hpp.
#include "solver/plan/tensor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::solver {
namespace {

/// lambda d_ij d_kl + mu (d_ik d_jl + d_il d_jk)
std::vector<Expr> isotropic(int d, const Expr& lambda, const Expr& mu) {
  std::vector<Expr> c;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      for (int k = 0; k < d; ++k)
        for (int l = 0; l < d; ++l) {
          Expr entry = 0.0;
          if (i == j && k == l) entry = entry + lambda;
          if (i == k && j == l) entry = entry + mu;
          if (i == l && j == k) entry = entry + mu;
          c.push_back(entry);
        }
  return c;
}

using Axes = std::array<Point, 3>;

/// c_ijkl = sum a_ip a_jq a_kr a_ls C_pqrs, rows of `axes` the material axes.
Expr rotated(const std::vector<Expr>& material, const Axes& axes, int i, int j, int k, int l) {
  Expr sum = 0.0;
  for (int p = 0; p < 3; ++p)
    for (int q = 0; q < 3; ++q)
      for (int r = 0; r < 3; ++r)
        for (int s = 0; s < 3; ++s) {
          const double weight = axes[p][i] * axes[q][j] * axes[r][k] * axes[s][l];
          if (weight != 0.0) sum = sum + Expr(weight) * material[((p * 3 + q) * 3 + r) * 3 + s];
        }
  return sum;
}

/// The rotated tensor, restricted to d.
std::vector<Expr> rotate(int d, const std::vector<Expr>& material, const Axes& axes) {
  std::vector<Expr> c;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      for (int k = 0; k < d; ++k)
        for (int l = 0; l < d; ++l) c.push_back(rotated(material, axes, i, j, k, l));
  return c;
}

using Exprs3 = std::array<Expr, 3>;

/// Stiffness of an orthotropic material along the coordinate axes, by inverting its compliance,
/// symbolically 3 x 3. poisson = (nu_xy, nu_yz, nu_xz), shear = (G_xy, G_yz, G_xz).
std::vector<Expr> orthotropic(const Exprs3& young, const Exprs3& poisson, const Exprs3& shear) {
  const Expr &ex = young[0], &ey = young[1], &ez = young[2];
  const Expr &nxy = poisson[0], &nyz = poisson[1], &nxz = poisson[2];
  const Expr nyx = nxy * ey / ex, nzy = nyz * ez / ey, nzx = nxz * ez / ex;
  const Expr one = 1.0;
  const Expr delta = one - nxy * nyx - nyz * nzy - nxz * nzx - Expr(2.0) * nxy * nyz * nzx;
  std::vector<Expr> m(36, Expr(0.0));
  auto set = [&](int i, int j, const Expr& v) { m[i * 6 + j] = m[j * 6 + i] = v; };
  set(0, 0, ex * (one - nyz * nzy) / delta);
  set(1, 1, ey * (one - nxz * nzx) / delta);
  set(2, 2, ez * (one - nxy * nyx) / delta);
  set(0, 1, ex * (nyx + nzx * nyz) / delta);
  set(0, 2, ex * (nzx + nyx * nzy) / delta);
  set(1, 2, ey * (nzy + nxy * nzx) / delta);
  set(3, 3, shear[1]);
  set(4, 4, shear[2]);
  set(5, 5, shear[0]);
  return of_voigt_matrix(3, m);
}

/// Isotropic in the plane normal to the third axis.
std::vector<Expr> transverse(const std::vector<Expr>& c) {
  const Expr in_plane = c[0] / (Expr(2.0) * (Expr(1.0) + c[1]));
  // c[3] is nu_zx; nu_xz = nu_zx E_p / E_a.
  const Expr nu_xz = c[3] * c[0] / c[2];
  return orthotropic({c[0], c[0], c[2]}, {c[1], nu_xz, nu_xz}, {in_plane, c[4], c[4]});
}

/// Of an orthotropic or transverse material, in its own axes.
std::vector<Expr> along_axes(const TensorSpec& tensor) {
  const std::vector<Expr>& c = tensor.constants;
  if (tensor.kind == TensorSpec::Kind::transverse) return transverse(c);
  return orthotropic({c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]});
}

constexpr double rounding = 1e-12; ///< of axes and of moduli, relative

/// Is the section a mirror of the material, whatever its constants? It is where one of the axes
/// stands across it; of a transverse one also where its third axis lies in it.
bool mirrored_by_section(const TensorSpec& tensor) {
  const auto across = [](const Point& axis) { return std::hypot(axis[0], axis[1]) <= rounding; };
  const Point& third = tensor.axes[2];
  if (tensor.kind == TensorSpec::Kind::transverse)
    return across(third) || std::abs(third[2]) <= rounding;
  return std::ranges::any_of(tensor.axes, across);
}

double largest_constant(const std::vector<Expr>& entries) {
  double largest = 0.0;
  for (const Expr& c : entries)
    if (c.is_constant()) largest = std::max(largest, std::abs(c.value()));
  return largest;
}

/// Index of the pair (i, j) in Voigt order: xx yy xy in 2D, xx yy zz yz xz xy in 3D.
int voigt_index(int d, int i, int j) {
  if (i == j) return i;
  return d == 2 ? 2 : (d == 1 ? 0 : 6 - i - j);
}

} // namespace

std::vector<Expr> of_voigt_matrix(int d, const std::vector<Expr>& m) {
  const int n = d * (d + 1) / 2;
  std::vector<Expr> c;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      for (int k = 0; k < d; ++k)
        for (int l = 0; l < d; ++l) c.push_back(m[voigt_index(d, i, j) * n + voigt_index(d, k, l)]);
  return c;
}

int count_constants(TensorSpec::Kind kind, int dim) {
  switch (kind) {
  case TensorSpec::Kind::isotropic:
    return 2;
  case TensorSpec::Kind::orthotropic:
    return 9;
  case TensorSpec::Kind::transverse:
    return 5;
  case TensorSpec::Kind::general:
    break;
  }
  return dim * dim * dim * dim;
}

std::vector<Expr> components(const TensorSpec& tensor, int dim) {
  const std::vector<Expr>& c = tensor.constants;
  switch (tensor.kind) {
  case TensorSpec::Kind::isotropic:
    return isotropic(dim, c[0], c[1]);
  case TensorSpec::Kind::orthotropic:
  case TensorSpec::Kind::transverse:
    return rotate(dim, along_axes(tensor), tensor.axes);
  case TensorSpec::Kind::general:
    break;
  }
  return c;
}

std::vector<Expr> components_across(const TensorSpec& tensor, int i) {
  switch (tensor.kind) {
  case TensorSpec::Kind::isotropic:
    if (i < 2) return std::vector<Expr>(4, Expr(0.0));
    return {tensor.constants[0], 0.0, 0.0, tensor.constants[0]};
  case TensorSpec::Kind::orthotropic:
  case TensorSpec::Kind::transverse:
    break;
  case TensorSpec::Kind::general:
    return {};
  }
  const std::vector<Expr> material = along_axes(tensor);
  std::vector<Expr> out;
  for (int k = 0; k < 2; ++k)
    for (int l = 0; l < 2; ++l) out.push_back(rotated(material, tensor.axes, i, 2, k, l));
  return out;
}

bool shears_across(const TensorSpec& tensor) {
  using Kind = TensorSpec::Kind;
  if (tensor.kind == Kind::isotropic || tensor.kind == Kind::general) return false;
  if (mirrored_by_section(tensor)) return false;
  const std::vector<Expr> material = along_axes(tensor);
  const double scale = largest_constant(material);
  for (int in_plane = 0; in_plane < 8; ++in_plane) {
    const Expr c = rotated(material, tensor.axes, in_plane / 4, 2, in_plane / 2 % 2, in_plane % 2);
    if (!c.is_constant() || std::abs(c.value()) > rounding * scale) return true;
  }
  return false;
}

bool same_tensor(const TensorSpec& a, const TensorSpec& b) {
  return a.kind == b.kind && a.axes == b.axes && a.constants == b.constants;
}

} // namespace hvi::solver
