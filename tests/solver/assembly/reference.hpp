// A slow assembler that shares nothing with the engine's: shape functions as monomials in physical
// coordinates from a Vandermonde matrix, conical Gauss rules, trees walked point by point, dense
// matrices.
#pragma once

#include "solver/assembly/assembly.hpp"
#include "tests/solver/fem/meshes.hpp"

#include <Eigen/Dense>

namespace hvi::solver::test {

class SlowCell {
public:
  SlowCell(const Space& space, int cell) : dim_(space.mesh->dim), order_(space.order) {
    const auto nodes = space.nodes_of_cell(cell);
    const auto n = static_cast<Eigen::Index>(nodes.size());
    Eigen::MatrixXd vandermonde(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      vandermonde.row(i) = monomials(space.nodes[nodes[i]], -1).transpose();
    }
    coefficients_ = vandermonde.fullPivLu().inverse();
  }
  /// phi_i (axis -1) or d phi_i / d x_axis at a point.
  Eigen::VectorXd shapes(const Point& p, int axis) const {
    return coefficients_.transpose() * monomials(p, axis);
  }
  /// Column 0 the values, column 1 + axis the derivatives.
  Eigen::MatrixXd all_shapes(const Point& p) const {
    Eigen::MatrixXd out(coefficients_.cols(), dim_ + 1);
    for (int axis = -1; axis < dim_; ++axis) out.col(1 + axis) = shapes(p, axis);
    return out;
  }

private:
  Eigen::VectorXd monomials(const Point& p, int axis) const {
    std::vector<double> out;
    for (int a = 0; a <= order_; ++a) {
      for (int b = 0; a + b <= order_ && (b == 0 || dim_ > 1); ++b) {
        for (int c = 0; a + b + c <= order_ && (c == 0 || dim_ > 2); ++c) {
          std::array<int, 3> power{a, b, c};
          double value = 1;
          if (axis >= 0) value = power[axis]--;
          for (int j = 0; j < 3; ++j) value *= power[j] < 0 ? 0 : std::pow(p[j], power[j]);
          out.push_back(value);
        }
      }
    }
    return Eigen::Map<Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()));
  }
  int dim_, order_;
  Eigen::MatrixXd coefficients_;
};

/// Conical product of n-point Gauss rules by Newton's iteration on Legendre polynomials, on the
/// simplex with these corners: points and weights (with measure).
inline std::vector<std::pair<Point, double>> slow_points(const std::vector<Point>& corners) {
  const int n = 6, dim = static_cast<int>(corners.size()) - 1;
  std::vector<double> at, weight;
  for (int k = 0; k < n; ++k) {
    double s = std::cos(M_PI * (k + 0.75) / (n + 0.5)), slope = 1;
    for (int it = 0; it < 50; ++it) {
      slope = n * (s * std::legendre(n, s) - std::legendre(n - 1, s)) / (s * s - 1);
      s -= std::legendre(n, s) / slope;
    }
    at.push_back(0.5 * (1 + s));
    weight.push_back(1 / ((1 - s * s) * slope * slope));
  }
  // Measure from the Gram determinant, so that facets in space work too.
  Eigen::MatrixXd edges(3, dim);
  for (int k = 0; k < dim; ++k) {
    for (int j = 0; j < 3; ++j) edges(j, k) = corners[k + 1][j] - corners[0][j];
  }
  const double jacobian = dim == 0 ? 1 : std::sqrt((edges.transpose() * edges).determinant());
  std::vector<std::pair<Point, double>> out;
  const auto total = static_cast<int>(std::pow(n, dim));
  for (int q = 0; q < total; ++q) {
    Point p = corners[0];
    double w = jacobian, rest = 1;
    for (int k = 0, digits = q; k < dim; ++k, digits /= n) {
      const double s = at[digits % n];
      w *= weight[digits % n] * std::pow(1 - s, dim - 1 - k);
      for (int j = 0; j < 3; ++j) p[j] += rest * s * (corners[k + 1][j] - corners[0][j]);
      rest *= 1 - s;
    }
    out.emplace_back(p, w);
  }
  return out;
}

struct SlowEntity {
  int cell;
  std::vector<Point> corners;
  Point normal{};
};
inline std::vector<SlowEntity> slow_entities(const Mesh& mesh, const Region& region) {
  std::vector<SlowEntity> out;
  for (const auto e : region.entities) {
    SlowEntity entity{e, {}, {}};
    if (region.kind == Group::Kind::cells) {
      for (int k = 0; k <= mesh.dim; ++k) entity.corners.push_back(mesh.nodes[mesh.cells[e][k]]);
    } else {
      entity.cell = mesh.facets[e].cell;
      entity.normal = facet_normal(mesh, e);
      for (int k = 0; k < mesh.dim; ++k) {
        entity.corners.push_back(mesh.nodes[mesh.facets[e].nodes[k]]);
      }
    }
    out.push_back(entity);
  }
  return out;
}

inline double slow_value(const Expr& e, const Point& p, const Point& normal, double time) {
  return evaluate(e, [&](Slot s) {
    if (s == slot::t) return time;
    return s < 3 ? p[s] : normal[s - slot::normal(0)];
  });
}

inline int component_of(int index) { return index < 3 ? index : (index - 3) / 3; }
inline int axis_of(int index) { return index < 3 ? -1 : (index - 3) % 3; }

inline Eigen::MatrixXd slow_form(const Space& space, const Region& region, const FormTerm& term) {
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(space.n_dofs(), space.n_dofs());
  for (const auto& entity : slow_entities(*space.mesh, region)) {
    const SlowCell cell(space, entity.cell);
    const auto nodes = space.nodes_of_cell(entity.cell);
    for (const auto& [p, w] : slow_points(entity.corners)) {
      const Eigen::MatrixXd shapes = cell.all_shapes(p);
      for (const auto& e : term.entries) {
        const double c = slow_value(e.coefficient, p, entity.normal, 0);
        const auto test = shapes.col(1 + axis_of(e.test)), trial = shapes.col(1 + axis_of(e.trial));
        for (std::size_t i = 0; i < nodes.size(); ++i) {
          for (std::size_t j = 0; j < nodes.size(); ++j) {
            k(space.dof(nodes[i], component_of(e.test)),
              space.dof(nodes[j], component_of(e.trial))) +=
                w * c * test[Eigen::Index(i)] * trial[Eigen::Index(j)];
          }
        }
      }
    }
  }
  return k;
}

inline Vector slow_load(const Space& space, const Region& region, const LoadTerm& term,
                        double time) {
  Vector f = Vector::Zero(space.n_dofs());
  for (const auto& entity : slow_entities(*space.mesh, region)) {
    const SlowCell cell(space, entity.cell);
    const auto nodes = space.nodes_of_cell(entity.cell);
    for (const auto& [p, w] : slow_points(entity.corners)) {
      const Eigen::MatrixXd shapes = cell.all_shapes(p);
      for (const auto& e : term.entries) {
        const auto test = shapes.col(1 + axis_of(e.test));
        const double value = slow_value(e.value, p, entity.normal, time);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
          f[space.dof(nodes[i], component_of(e.test))] += w * value * test[Eigen::Index(i)];
        }
      }
    }
  }
  return f;
}

/// lambda tr(eps(u)) tr(eps(v)) + 2 mu eps(u) : eps(v).
inline FormTerm elasticity(int dim, const Expr& lambda, const Expr& mu) {
  FormTerm term;
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      term.entries.push_back({slot::gradient(i, i), slot::gradient(j, j), lambda});
      term.entries.push_back({slot::gradient(i, j), slot::gradient(i, j), mu});
      term.entries.push_back({slot::gradient(i, j), slot::gradient(j, i), mu});
    }
  }
  return term;
}

} // namespace hvi::solver::test
