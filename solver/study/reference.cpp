// Errors against an exact solution or a finer run; see reference.hpp.
#include "solver/study/reference.hpp"

#include "solver/fem/element.hpp"
#include "solver/fem/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

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

/// || eps(w) ||^2 or || grad w ||^2 pointwise, from the gradient entries of w; (2, 2): the hoop's.
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
  if (has_hoop(space)) {
    const Expr along = gradient(2, 2);
    sum = sum + along * along;
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
    const auto slope = [&](int i, int j) {
      return i == 2 && space.components == 2 ? exact[0] / Expr::variable(slot::x(0))
                                             : derivative(exact[i], slot::x(j));
    };
    const auto error = [&](int i, int j) {
      return Expr::variable(slot::field(field_of_u(0), slot::gradient(i, j))) - slope(i, j);
    };
    Expr l2(0.0);
    for (int i = 0; i < space.components; ++i) {
      const Expr off = Expr::variable(slot::field(field_of_u(0), slot::value(i))) - exact[i];
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
        gram_(gram_of_unknown(reference_->discretisation->space, 0, false)),
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

constexpr double inside = 1e-9; ///< barycentric coordinates of a point of a cell, at least minus

[[noreturn]] void other_body(const Point& p, int dim) {
  throw Failure(FailureKind::bad_value, {},
                "the meshes of a study do not cover the same body: " + describe_point(p, dim) +
                    " lies outside");
}

/// Finds points of a piece of another mesh in the same piece of this one: where bodies touch or lie
/// over each other, a point alone does not say which is meant.
class PieceLocator {
public:
  explicit PieceLocator(const Mesh& mesh) {
    std::vector<std::int32_t> first = mesh.pieces;
    if (first.empty()) first.push_back(0);
    for (std::size_t i = 0; i < first.size(); ++i) {
      const auto past = i + 1 < first.size() ? first[i + 1] : static_cast<int>(mesh.cells.size());
      first_.push_back(first[i]);
      Mesh& piece = meshes_.emplace_back();
      if (first.size() > 1) {
        piece.dim = mesh.dim;
        piece.nodes = mesh.nodes;
        piece.cells.assign(mesh.cells.begin() + first[i], mesh.cells.begin() + past);
      }
      locators_.emplace_back(first.size() > 1 ? piece : mesh);
    }
  }
  int find(const Point& p, int piece, Barycentric& at) const {
    const auto i = static_cast<std::size_t>(piece);
    const int found = i < locators_.size() ? locators_[i].find(p, at) : -1;
    return found < 0 ? found : first_[i] + found;
  }

private:
  std::deque<Mesh> meshes_; // locators point to them
  std::vector<CellLocator> locators_;
  std::vector<int> first_;
};

/// By node of a space: the piece of the mesh it belongs to.
std::vector<int> pieces_of_nodes(const Space& space) {
  std::vector<int> out(space.nodes.size(), 0);
  for (std::size_t c = 0; c < space.mesh->cells.size(); ++c)
    for (const auto node : space.nodes_of_cell(static_cast<int>(c)))
      out[static_cast<std::size_t>(node)] = space.mesh->piece_of_cell(static_cast<std::int32_t>(c));
  return out;
}

/// Both functions at the quadrature points of the finer mesh, one after the other.
class PointGauge final : public Gauge {
public:
  PointGauge(std::shared_ptr<const Trajectory> reference, const Discretisation& coarse)
      : reference_(std::move(reference)), fine_(reference_->discretisation->space),
        coarse_(coarse.space), rule_(simplex_rule(fine_.mesh->dim, 4)) {
    const PieceLocator locator(*coarse_.mesh);
    const auto n_cells = static_cast<int>(fine_.mesh->cells.size());
    for (int cell = 0; cell < n_cells; ++cell)
      for (const auto& at : rule_.points) {
        const Point p = point_in_cell(*fine_.mesh, cell, at);
        Seen seen;
        seen.cell = locator.find(p, fine_.mesh->piece_of_cell(cell), seen.at);
        if (seen.cell < 0) other_body(p, fine_.mesh->dim);
        seen_.push_back(seen);
      }
  }

  void step(double t, const Vector& u) override {
    const Vector exact = reference_->at(t);
    double v = 0.0, l2 = 0.0, size = 0.0;
    int before = -1;
    CellGeometry there;
    for (std::size_t cell = 0, k = 0; cell < fine_.mesh->cells.size(); ++cell) {
      const int c = static_cast<int>(cell);
      const auto here = cell_geometry(*fine_.mesh, c);
      for (std::size_t q = 0; q < rule_.size(); ++q, ++k) {
        if (seen_[k].cell != before)
          before = seen_[k].cell, there = cell_geometry(*coarse_.mesh, before);
        const double x = point_in_cell(*fine_.mesh, c, rule_.points[q])[0];
        const double w = here.measure * rule_.weights[q] * circumference(*fine_.mesh, x);
        const auto mine = values(coarse_, before, there, seen_[k].at, u);
        const auto right = values(fine_, c, here, rule_.points[q], exact);
        add(mine, right, w, v, l2, size);
      }
    }
    note(v, l2, size);
  }

private:
  struct Seen {
    int cell = -1;
    Barycentric at{};
  };
  using Values = std::array<double, 12>; ///< u_i, then d u_i / d x_j at 3 + 3 i + j

  Values values(const Space& space, int cell, const CellGeometry& geometry, const Barycentric& at,
                const Vector& u) {
    evaluate_shapes(space, geometry, at, true, shapes_);
    Values out{};
    const auto nodes = space.nodes_of_cell(cell);
    for (std::size_t n = 0; n < nodes.size(); ++n)
      for (int i = 0; i < space.components; ++i) {
        const double c = u[space.dof(nodes[n], i)];
        out[i] += c * shapes_.at(0, static_cast<int>(n));
        for (int j = 0; j < space.mesh->dim; ++j)
          out[3 + 3 * i + j] += c * shapes_.at(1 + j, static_cast<int>(n));
        if (i == 0 && has_hoop(space))
          out[slot::hoop] += c * shapes_.at(hoop_row, static_cast<int>(n));
      }
    return out;
  }

  void add(const Values& mine, const Values& right, double weight, double& v, double& l2,
           double& size) const {
    const int d = fine_.mesh->dim;
    const auto strain = [&](const Values& x, int i, int j) {
      return fine_.components == 1 ? x[3 + j] : 0.5 * (x[3 + 3 * i + j] + x[3 + 3 * j + i]);
    };
    for (int i = 0; i < fine_.components; ++i) {
      l2 += weight * (mine[i] - right[i]) * (mine[i] - right[i]);
      for (int j = 0; j < d; ++j) {
        const double e = strain(right, i, j), off = strain(mine, i, j) - e;
        v += weight * off * off, size += weight * e * e;
      }
    }
    if (!has_hoop(fine_)) return;
    const double e = right[slot::hoop], off = mine[slot::hoop] - e;
    v += weight * off * off, size += weight * e * e;
  }

  std::shared_ptr<const Trajectory> reference_;
  const Space& fine_;
  const Space& coarse_;
  Quadrature rule_;
  std::vector<Seen> seen_;
  ShapeTable shapes_;
};

} // namespace

bool is_nested(const Mesh& coarse, const Mesh& fine) {
  const PieceLocator locator(coarse);
  Barycentric at{};
  for (std::size_t cell = 0; cell < fine.cells.size(); ++cell) {
    Barycentric centre{};
    for (int k = 0; k <= fine.dim; ++k) centre[k] = 1.0 / (fine.dim + 1);
    const int number = static_cast<int>(cell);
    const int around =
        locator.find(point_in_cell(fine, number, centre), fine.piece_of_cell(number), at);
    if (around < 0) return false;
    const auto geometry = cell_geometry(coarse, around);
    const Point& origin = coarse.nodes[coarse.cells[around][0]];
    for (int k = 0; k <= fine.dim; ++k)
      for (int l = 0; l <= fine.dim; ++l) {
        double lambda = l == 0 ? 1.0 : 0.0;
        for (int a = 0; a < fine.dim; ++a)
          lambda += geometry.gradient[l][a] * (fine.nodes[fine.cells[cell][k]][a] - origin[a]);
        if (lambda < -inside) return false;
      }
  }
  return true;
}

SparseMatrix transfer(const Space& coarse, const Space& fine) {
  const PieceLocator locator(*coarse.mesh);
  const auto piece_of = pieces_of_nodes(fine);
  std::vector<Eigen::Triplet<double>> entries;
  std::array<double, max_cell_nodes> shapes{};
  for (std::size_t node = 0; node < fine.nodes.size(); ++node) {
    std::array<double, 4> barycentric{};
    const int cell = locator.find(fine.nodes[node], piece_of[node], barycentric);
    if (cell < 0) other_body(fine.nodes[node], fine.mesh->dim);
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
  const Space& fine = reference->discretisation->space;
  if (coarse.space.order > fine.order || !is_nested(coarse.mesh, *fine.mesh))
    return std::make_unique<PointGauge>(std::move(reference), coarse);
  return std::make_unique<TrajectoryGauge>(std::move(reference), coarse);
}

} // namespace hvi::solver
