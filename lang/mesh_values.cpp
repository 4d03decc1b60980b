// See mesh_values.hpp.
#include "lang/mesh_values.hpp"

#include "solver/fem/pointwise.hpp"
#include "solver/linear/dense.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hvi::lang {

namespace {

std::string place(const solver::Point& x, int dim) {
  std::string out = fmt::format("{:.6g}", x[0]);
  for (int a = 1; a < dim; ++a) out += fmt::format(", {:.6g}", x[a]);
  return "(" + out + ")";
}

/// Whether tau : C : tau > 0 for every symmetric tau: Cholesky of the Mandel matrix.
bool is_elliptic(int d, const std::vector<double>& c) {
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < d; ++i) pairs.emplace_back(i, i);
  for (int i = 0; i < d; ++i)
    for (int j = i + 1; j < d; ++j) pairs.emplace_back(i, j);
  const int n = static_cast<int>(pairs.size());
  solver::DenseMatrix mandel(n, n);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const auto [i, j] = pairs[a];
      const auto [k, l] = pairs[b];
      const double weight = (i == j ? 1.0 : std::sqrt(2.0)) * (k == l ? 1.0 : std::sqrt(2.0));
      mandel(a, b) = weight * c[((i * d + j) * d + k) * d + l];
    }
  return solver::DenseCholesky(0.5 * (mandel + mandel.transpose())).positive();
}

/// What is wrong with a material at the points of a block; empty: nothing.
std::string mistake(const ModelMaterial& material, int dim, const solver::PointBlock& block,
                    solver::Pointwise& values) {
  const std::size_t n = block.size(), n_components = material.value.components.size();
  std::vector<double> out(n * n_components), here(n_components);
  values.evaluate(block, 0.0, {}, out);
  for (std::size_t p = 0; p < n; ++p) {
    bool finite = true;
    for (std::size_t k = 0; k < n_components; ++k) {
      here[k] = out[k * n + p];
      finite = finite && std::isfinite(here[k]);
    }
    if (finite && (!material.elliptic || is_elliptic(material.value.rows, here))) continue;
    return fmt::format("the tensor is not {} at {}", finite ? "elliptic" : "finite",
                       place(block.point(p), dim));
  }
  return {};
}

} // namespace

void check_materials(Script& script, const solver::Discretisation& d) {
  for (const ModelMaterial& material : script.model->materials) {
    solver::Pointwise values(material.value.components);
    std::string found;
    for (int part : material.parts) {
      const solver::Region& region = d.parts[part];
      if (!found.empty() || region.kind != solver::Group::Kind::cells) continue;
      solver::RegionPoints(d.space, region, solver::Rule::midpoint, 0)
          .for_blocks([&](const solver::PointBlock& block) {
            if (found.empty()) found = mistake(material, d.mesh.dim, block, values);
          });
    }
    if (!found.empty()) script.diagnostics.add("E0504", material.span, found);
  }
}

} // namespace hvi::lang
