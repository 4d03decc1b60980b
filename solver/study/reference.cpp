// Errors against an exact solution or a finer run; see reference.hpp.
#include "solver/study/reference.hpp"

#include "solver/fem/element.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {

void Gauge::note(double v_squared, double l2_squared, double size_squared) {
  // Rounding cannot make a norm NaN.
  error_.v_final = std::sqrt(std::max(v_squared, 0.0));
  error_.l2_final = std::sqrt(std::max(l2_squared, 0.0));
  error_.v_max = std::max(error_.v_max, error_.v_final);
  error_.l2_max = std::max(error_.l2_max, error_.l2_final);
  error_.size = std::max(error_.size, std::sqrt(std::max(size_squared, 0.0)));
}

namespace {

/// || eps(w) ||^2 or || grad w ||^2 pointwise, from the gradient entries of w.
template <class Entry>
Expr v_density(const Space& space, Entry&& gradient) {
  const int d = space.mesh->dim;
  Expr sum(0.0);
  for (int i = 0; i < space.components; ++i)
    for (int j = 0; j < d; ++j) {
      const Expr entry =
          space.components == 1 ? gradient(0, j) : Expr(0.5) * (gradient(i, j) + gradient(j, i));
      sum = sum + entry * entry;
    }
  return sum;
}

class ExactGauge final : public Gauge {
public:
  ExactGauge(const Discretisation& d, std::span<const Expr> exact)
      : integrator_(d.space, resolve(d.mesh, RegionSpec{}), Rule::exact,
                    integrands(d.space, exact)) {}

  void step(double t, const Vector& u) override {
    const std::array<const Vector*, 1> fields = {&u};
    std::array<double, 3> squares{};
    integrator_.integrate({fields, t}, squares);
    note(squares[0], squares[1], squares[2]);
  }

private:
  static std::vector<Expr> integrands(const Space& space, std::span<const Expr> exact) {
    const auto slope = [&](int i, int j) { return derivative(exact[i], slot::x(j)); };
    const auto error = [&](int i, int j) {
      return Expr::variable(slot::field(field_u, slot::gradient(i, j))) - slope(i, j);
    };
    Expr l2(0.0);
    for (int i = 0; i < space.components; ++i) {
      const Expr off = Expr::variable(slot::field(field_u, slot::value(i))) - exact[i];
      l2 = l2 + off * off;
    }
    return {v_density(space, error), l2, v_density(space, slope)};
  }

  Integrator integrator_;
};

class TrajectoryGauge final : public Gauge {
public:
  TrajectoryGauge(std::shared_ptr<const Trajectory> reference, const Discretisation& coarse)
      : reference_(std::move(reference)),
        transfer_(transfer(coarse.space, reference_->discretisation->space)),
        gram_(gram_v(reference_->discretisation->space, false)),
        mass_(mass(reference_->discretisation->space)) {}

  void step(double t, const Vector& u) override {
    const Vector exact = reference_->at(t);
    const Vector error = transfer_ * u - exact;
    note(error.dot(gram_ * error), error.dot(mass_ * error), exact.dot(gram_ * exact));
  }

private:
  std::shared_ptr<const Trajectory> reference_;
  SparseMatrix transfer_, gram_, mass_;
};

} // namespace

SparseMatrix transfer(const Space& coarse, const Space& fine) {
  const CellLocator locator(*coarse.mesh);
  std::vector<Eigen::Triplet<double>> entries;
  std::array<double, max_cell_nodes> shapes{};
  for (std::size_t node = 0; node < fine.nodes.size(); ++node) {
    std::array<double, 4> barycentric{};
    const int cell = locator.find(fine.nodes[node], barycentric);
    if (cell < 0)
      throw Failure(FailureKind::bad_value, {},
                    "the meshes of a study do not cover the same body: node " +
                        describe_point(fine.nodes[node], fine.mesh->dim) + " lies outside");
    lagrange_values(coarse.mesh->dim, coarse.order, barycentric, shapes.data());
    const auto nodes = coarse.nodes_of_cell(cell);
    for (std::size_t k = 0; k < nodes.size(); ++k)
      for (int c = 0; c < fine.components; ++c)
        if (shapes[k] != 0.0)
          entries.emplace_back(fine.dof(static_cast<int>(node), c), coarse.dof(nodes[k], c),
                               shapes[k]);
  }
  SparseMatrix out(fine.n_dofs(), coarse.n_dofs());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

Vector Trajectory::at(double t) const {
  const auto after = std::lower_bound(times.begin(), times.end(), t);
  if (after == times.end()) return states.back();
  const auto n = static_cast<std::size_t>(after - times.begin());
  if (n == 0 || times[n] == t) return states[n];
  const double theta = (t - times[n - 1]) / (times[n] - times[n - 1]);
  return (1.0 - theta) * states[n - 1] + theta * states[n];
}

std::unique_ptr<Gauge> exact_gauge(const Discretisation& discretisation,
                                   std::span<const Expr> exact) {
  return std::make_unique<ExactGauge>(discretisation, exact);
}

std::unique_ptr<Gauge> trajectory_gauge(std::shared_ptr<const Trajectory> reference,
                                        const Discretisation& coarse) {
  return std::make_unique<TrajectoryGauge>(std::move(reference), coarse);
}

} // namespace hvi::solver
