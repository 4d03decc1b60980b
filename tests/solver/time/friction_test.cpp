// The slab with friction against a second solver: total form instead of increments, the memory as a
// plain sum, dense elimination, and nonlinear block Gauss-Seidel instead of Newton. It shares the
// assembly of the matrices with the engine and nothing else.
#include "tests/solver/time/plans.hpp"

#include <Eigen/Dense>

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

double layer_slope(double r) {
  if (r < 0) return 0;
  if (r < 0.02) return 100 * r;
  return r < 0.08 ? 2 - 15 * (r - 0.02) : 1.1;
}
double friction_bound(double s) { return 0.5 + 0.2 * std::exp(-20 * s); }

/// The root of an increasing function on [low, high], to the last bit.
template <class F>
double bisect(F&& f, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (f(middle) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

struct Node {
  std::vector<int> tangential; ///< contact unknowns
  int normal;
  double weight;
};

/// S c + forces = r node by node: the normal value, then the tangential vector with the curvature
/// bounded by its largest diagonal sum. Returns the last change.
double sweep(const DenseMatrix& s, const Vector& r, const std::vector<Node>& nodes, Vector& c) {
  double change = 0;
  for (const auto& node : nodes) {
    const int i = node.normal;
    const double rest = r[i] - s.row(i).dot(c) + s(i, i) * c[i];
    // u_nu = -u_y: a positive u_nu is pushed back, so the force on u_y is -slope.
    const double y = bisect(
        [&](double v) { return s(i, i) * v - node.weight * layer_slope(-v) - rest; }, -10, 10);
    change = std::max(change, std::abs(y - c[i]));
    c[i] = y;
    const auto m = static_cast<Eigen::Index>(node.tangential.size());
    Vector old(m), target(m);
    double curvature = 0;
    for (Eigen::Index a = 0; a < m; ++a) {
      double sum = 0;
      for (Eigen::Index b = 0; b < m; ++b)
        sum += std::abs(s(node.tangential[a], node.tangential[b]));
      curvature = std::max(curvature, sum);
    }
    for (Eigen::Index a = 0; a < m; ++a) {
      const int row = node.tangential[a];
      old[a] = c[row];
      target[a] = curvature * c[row] + r[row] - s.row(row).dot(c);
    }
    const double size = target.norm();
    double length = 0;
    if (size > node.weight * friction_bound(0))
      length = bisect(
          [&](double v) { return curvature * v + node.weight * friction_bound(v) - size; }, 0, 10);
    for (Eigen::Index a = 0; a < m; ++a) {
      const double value = size > 0 ? length * target[a] / size : 0.0;
      change = std::max(change, std::abs(value - old[a]));
      c[node.tangential[a]] = value;
    }
  }
  return change;
}

struct Reference {
  std::vector<double> u_y, u_x; ///< of the ground node (1, 0), per step
  Vector u;
};

Reference reference_slab(const Plan& plan, const Discretisation& d, int steps) {
  const int dim = d.mesh.dim, n = d.dofs.n_unknowns();
  const auto free = [&](const SparseMatrix& full) {
    const DenseMatrix dense = full;
    DenseMatrix out(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) out(i, j) = dense(d.dofs.free[i], d.dofs.free[j]);
    return out;
  };
  const DenseMatrix a = free(assemble_form(d.space, d.parts[body], plan.problem.forms[0]));
  const DenseMatrix b = free(assemble_form(d.space, d.parts[body], plan.problem.forms[1]));
  const double k = 1.0 / steps, tau = 0.5;
  const auto weight = [&](int step, int j) {
    return tau * (std::exp(-(step - j) * k / tau) - std::exp(-(step - j + 1) * k / tau));
  };
  const DenseMatrix matrix = a / k + b - weight(1, 1) * b;

  // Contact unknowns and lumped weights: a third (half) of the facets around a node.
  std::map<int, double> lumped;
  for (const int f : d.parts[ground].entities)
    for (int v = 0; v < dim; ++v)
      lumped[d.mesh.facets[f].nodes[v]] += facet_measure(d.mesh, f) / dim;
  std::vector<int> contact, inner, position(n, -1);
  std::vector<Node> nodes;
  for (const auto& [node, w] : lumped) {
    Node out{{}, 0, w};
    for (int i = 0; i < dim; ++i) {
      if (i == 1)
        out.normal = static_cast<int>(contact.size());
      else
        out.tangential.push_back(static_cast<int>(contact.size()));
      contact.push_back(d.dofs.unknown_of[d.space.dof(node, i)]);
    }
    nodes.push_back(out);
  }
  for (const int c : contact) position[c] = 0;
  for (int i = 0; i < n; ++i)
    if (position[i] < 0) inner.push_back(i);
  const DenseMatrix k_ii = matrix(inner, inner), k_ic = matrix(inner, contact);
  const Eigen::LLT<DenseMatrix> factor(k_ii);
  const DenseMatrix coupling = factor.solve(k_ic);
  const DenseMatrix s = DenseMatrix(matrix(contact, contact)) - k_ic.transpose() * coupling;

  Reference out;
  std::vector<Vector> u{Vector::Zero(n)};
  const LoadAssembler loads(d.space, d.parts, plan.problem.loads);
  int probe = -1;
  for (int node = 0; node < static_cast<int>(d.space.nodes.size()); ++node)
    if (d.space.nodes[node] == plan.report.probes[0].point) probe = node;
  for (int step = 1; step <= steps; ++step) {
    Vector full = Vector::Zero(d.space.n_dofs());
    loads.add(step * k, full);
    Vector rhs(n), memory = Vector::Zero(n);
    for (int i = 0; i < n; ++i) rhs[i] = full[d.dofs.free[i]];
    for (int j = 1; j < step; ++j) memory += weight(step, j) * u[j];
    rhs += a * u[step - 1] / k + b * memory;
    const Vector rhs_i = rhs(inner);
    const Vector r = Vector(rhs(contact)) - coupling.transpose() * rhs_i;
    Vector c = u[step - 1](contact);
    for (int i = 0; i < 200000 && sweep(s, r, nodes, c) > 1e-17; ++i) {
    }
    Vector next(n);
    next(contact) = c;
    next(inner) = factor.solve(rhs_i) - coupling * c;
    u.push_back(next);
    out.u_y.push_back(next[d.dofs.unknown_of[d.space.dof(probe, 1)]]);
    out.u_x.push_back(next[d.dofs.unknown_of[d.space.dof(probe, 0)]]);
  }
  out.u = u.back();
  return out;
}

void compare(int n, int steps, int dim) {
  auto plan = slab(n, steps, dim, true);
  const Point middle{1, 0, dim == 3 ? 0.5 : 0.0};
  plan.report.probes = {at_point("u_y", u_value(1), middle), at_point("u_x", u_value(0), middle)};
  plan.report.tables = {{{}, {0, 1}, 1, false, ""}};
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  const auto result = run(plan, d, {});
  const auto reference = reference_slab(plan, d, steps);
  double scale = reference.u.lpNorm<Eigen::Infinity>();
  for (int i = 0; i < d.dofs.n_unknowns(); ++i)
    EXPECT_NEAR(result.u[d.dofs.free[i]], reference.u[i], 1e-10 * scale) << "unknown " << i;
  for (int step = 0; step < steps; ++step) {
    EXPECT_NEAR(result.columns.at("u_y")[step], reference.u_y[step], 1e-10 * scale);
    EXPECT_NEAR(result.columns.at("u_x")[step], reference.u_x[step], 1e-10 * scale);
  }
  EXPECT_TRUE(result.certificate.certified);
}

TEST(Friction, Slab2DEqualsTheIndependentSolver) { compare(4, 16, 2); }
TEST(Friction, Slab3DEqualsTheIndependentSolver) { compare(2, 8, 3); }

} // namespace
} // namespace hvi::solver
