// Errors against an exact solution or a finer run; see reference.hpp.
#include "solver/study/reference.hpp"

#include "solver/fem/element.hpp"
#include "solver/fem/geometry.hpp"
#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>

namespace hvi::solver {

std::vector<UnknownNorm> norms_of(const Problem& problem, const Discretisation& d) {
  if (!d.space.is_product()) return std::vector<UnknownNorm>(1);
  const auto multiplier = multipliers_of(problem), loose = d.dofs.needs_mass();
  std::vector<UnknownNorm> out;
  for (std::size_t b = 0; b < multiplier.size(); ++b)
    out.push_back({multiplier[b] == 0, multiplier[b] != 0 || loose[b] != 0});
  return out;
}

StudyError together(std::span<const StudyError> errors) {
  if (errors.size() == 1) return errors.front();
  StudyError out;
  out.size = 1.0;
  out.l2_max = out.l2_final = std::numeric_limits<double>::quiet_NaN();
  for (const StudyError& e : errors) {
    const double size = e.size > 0.0 ? e.size : 1.0;
    out.v_max = std::hypot(out.v_max, e.v_max / size);
    out.v_final = std::hypot(out.v_final, e.v_final / size);
  }
  return out;
}

void Gauge::note(int unknown, const Squares& s) {
  const UnknownNorm& norm = norms_[static_cast<std::size_t>(unknown)];
  const auto root = [&](double slopes, double values) {
    // Rounding cannot make a norm NaN.
    return std::sqrt(std::max((norm.slopes ? slopes : 0.0) + (norm.values ? values : 0.0), 0.0));
  };
  StudyError& error = errors_[static_cast<std::size_t>(unknown)];
  error.v_final = root(s.slopes, s.values);
  error.l2_final = std::sqrt(std::max(s.values, 0.0));
  error.v_max = std::max(error.v_max, error.v_final);
  error.l2_max = std::max(error.l2_max, error.l2_final);
  error.size = std::max(error.size, root(s.size_slopes, s.size_values));
}

namespace {

/// || eps(w) ||^2 or || grad w ||^2 pointwise, from the gradient entries of w; (2, 2): the hoop's.
template <class Entry>
Expr v_density(const Space& space, const SpaceBlock& block, Entry&& gradient) {
  const int d = space.mesh->dim;
  Expr sum(0.0);
  for (int i = 0; i < block.components; ++i)
    for (int j = 0; j < d; ++j) {
      const Expr entry =
          block.components == 1 ? gradient(0, j) : Expr(0.5) * (gradient(i, j) + gradient(j, i));
      sum = sum + entry * entry;
    }
  if (has_hoop(space, block)) {
    const Expr along = gradient(2, 2);
    sum = sum + along * along;
  }
  return sum;
}

class ExactGauge final : public Gauge {
public:
  ExactGauge(const Discretisation& d, std::span<const Expr> exact, std::vector<UnknownNorm> norms)
      : Gauge(std::move(norms)), integrator_(d.space, resolve(d.mesh, RegionSpec{}), Rule::exact,
                                             integrands(d.space, exact)) {}

  void step(double t, const Vector& u) override {
    const std::array<const Vector*, 1> fields = {&u};
    std::vector<double> s(static_cast<std::size_t>(4 * n_unknowns()));
    integrator_.integrate({fields, t}, s);
    for (int b = 0; b < n_unknowns(); ++b) {
      const auto i = static_cast<std::size_t>(4 * b);
      note(b, {s[i], s[i + 1], s[i + 2], s[i + 3]});
    }
  }

private:
  /// Of each unknown: those of Squares.
  static std::vector<Expr> integrands(const Space& space, std::span<const Expr> exact) {
    std::vector<Expr> out;
    for (int b = 0; b < hvi::solver::n_unknowns(space); ++b) {
      const SpaceBlock& block = space.blocks[static_cast<std::size_t>(b)];
      const auto of = exact.subspan(static_cast<std::size_t>(block.first),
                                    static_cast<std::size_t>(block.components));
      const auto slope = [&](int i, int j) {
        return i == 2 && block.components == 2 ? of[0] / Expr::variable(slot::x(0))
                                               : derivative(of[i], slot::x(j));
      };
      const auto field = [&](int derivative) {
        return Expr::variable(slot::field(field_of_u(0), slot::of_unknown(b, derivative)));
      };
      const auto error = [&](int i, int j) { return field(slot::gradient(i, j)) - slope(i, j); };
      Expr l2(0.0), size(0.0);
      for (int i = 0; i < block.components; ++i) {
        const Expr off = field(slot::value(i)) - of[i];
        l2 = l2 + off * off, size = size + of[i] * of[i];
      }
      const Expr here = block.domain ? Expr::variable(slot::inside(block.domain->part)) : Expr(1.0);
      for (const Expr& density :
           {v_density(space, block, error), l2, v_density(space, block, slope), size})
        out.push_back(here * density);
    }
    return out;
  }

  Integrator integrator_;
};

class TrajectoryGauge final : public Gauge {
public:
  TrajectoryGauge(std::shared_ptr<const Trajectory> reference, const Discretisation& coarse,
                  std::vector<UnknownNorm> norms)
      : Gauge(std::move(norms)), reference_(std::move(reference)),
        transfer_(transfer(coarse.space, space())), mass_(mass(space())) {
    for (int b = 0; b < n_unknowns(); ++b) gram_.push_back(gram_of_unknown(space(), b, false));
  }

  void step(double t, const Vector& u) override {
    const Vector exact = reference_->at(t);
    const Vector error = transfer_ * u - exact;
    if (n_unknowns() == 1) {
      note(0, {error.dot(gram_[0] * error), error.dot(mass_ * error), exact.dot(gram_[0] * exact),
               exact.dot(mass_ * exact)});
      return;
    }
    for (int b = 0; b < n_unknowns(); ++b) {
      const Vector e = only(b, error), of = only(b, exact);
      const SparseMatrix& gram = gram_[static_cast<std::size_t>(b)];
      note(b, {e.dot(gram * e), e.dot(mass_ * e), of.dot(gram * of), of.dot(mass_ * of)});
    }
  }

private:
  const Space& space() const { return reference_->discretisation->space; }
  /// The part of a function that is of one unknown.
  Vector only(int unknown, Vector w) const {
    for (int i = 0; i < w.size(); ++i)
      if (space().block_of(i % space().components) != unknown) w[i] = 0.0;
    return w;
  }

  std::shared_ptr<const Trajectory> reference_;
  SparseMatrix transfer_, mass_;
  std::vector<SparseMatrix> gram_;
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
  PointGauge(std::shared_ptr<const Trajectory> reference, const Discretisation& coarse,
             std::vector<UnknownNorm> norms)
      : Gauge(std::move(norms)), reference_(std::move(reference)),
        fine_(reference_->discretisation->space), coarse_(coarse.space),
        rule_(simplex_rule(fine_.mesh->dim, 4)) {
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
    std::vector<Squares> sums(static_cast<std::size_t>(n_unknowns()));
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
        evaluate_shapes(coarse_, there, seen_[k].at, true, coarse_shapes_);
        evaluate_shapes(fine_, here, rule_.points[q], true, fine_shapes_);
        for (int b = 0; b < n_unknowns(); ++b)
          if (fine_.blocks[static_cast<std::size_t>(b)].lives_in(c))
            add(b, values(coarse_, coarse_shapes_, b, before, u),
                values(fine_, fine_shapes_, b, c, exact), w, sums[static_cast<std::size_t>(b)]);
      }
    }
    for (int b = 0; b < n_unknowns(); ++b) note(b, sums[static_cast<std::size_t>(b)]);
  }

private:
  struct Seen {
    int cell = -1;
    Barycentric at{};
  };
  using Values = std::array<double, 12>; ///< u_i, then d u_i / d x_j at 3 + 3 i + j

  static Values values(const Space& space, const ShapeTable& shapes, int unknown, int cell,
                       const Vector& u) {
    const SpaceBlock& block = space.blocks[static_cast<std::size_t>(unknown)];
    const int first_row = block.order < space.order ? linear_rows : 0;
    Values out{};
    const auto nodes = space.nodes_of_cell(cell);
    for (std::size_t n = 0; n < nodes.size(); ++n)
      for (int i = 0; i < block.components; ++i) {
        const double c = u[space.dof(nodes[n], block.first + i)];
        out[i] += c * shapes.at(first_row, static_cast<int>(n));
        for (int j = 0; j < space.mesh->dim; ++j)
          out[3 + 3 * i + j] += c * shapes.at(first_row + 1 + j, static_cast<int>(n));
        if (i == 0 && has_hoop(space, block))
          out[slot::hoop] += c * shapes.at(first_row + hoop_row, static_cast<int>(n));
      }
    return out;
  }

  void add(int unknown, const Values& mine, const Values& right, double weight,
           Squares& sums) const {
    const SpaceBlock& block = fine_.blocks[static_cast<std::size_t>(unknown)];
    const int d = fine_.mesh->dim;
    const auto strain = [&](const Values& x, int i, int j) {
      return block.components == 1 ? x[3 + j] : 0.5 * (x[3 + 3 * i + j] + x[3 + 3 * j + i]);
    };
    const auto slope = [&](double of_mine, double e) {
      const double off = of_mine - e;
      sums.slopes += weight * off * off, sums.size_slopes += weight * e * e;
    };
    for (int i = 0; i < block.components; ++i) {
      sums.values += weight * (mine[i] - right[i]) * (mine[i] - right[i]);
      sums.size_values += weight * right[i] * right[i];
      for (int j = 0; j < d; ++j) slope(strain(mine, i, j), strain(right, i, j));
    }
    if (has_hoop(fine_, block)) slope(mine[slot::hoop], right[slot::hoop]);
  }

  std::shared_ptr<const Trajectory> reference_;
  const Space& fine_;
  const Space& coarse_;
  Quadrature rule_;
  std::vector<Seen> seen_;
  ShapeTable coarse_shapes_, fine_shapes_;
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
  const auto vertices = fine.mesh->nodes.size();
  std::vector<Eigen::Triplet<double>> entries;
  std::array<double, max_cell_nodes> shapes{};
  for (std::size_t node = 0; node < fine.nodes.size(); ++node) {
    std::array<double, 4> barycentric{};
    const int cell = locator.find(fine.nodes[node], piece_of[node], barycentric);
    if (cell < 0) other_body(fine.nodes[node], fine.mesh->dim);
    const auto nodes = coarse.nodes_of_cell(cell);
    for (std::size_t b = 0; b < fine.blocks.size(); ++b) {
      const SpaceBlock &to = fine.blocks[b], &from = coarse.blocks[b];
      if (to.order < fine.order && node >= vertices) continue; // no functions of its own there
      lagrange_values(coarse.mesh->dim, from.order, barycentric, shapes.data());
      const auto size = static_cast<std::size_t>(lagrange_size(coarse.mesh->dim, from.order));
      for (std::size_t k = 0; k < size; ++k)
        for (int c = 0; c < to.components; ++c)
          if (shapes[k] != 0.0)
            entries.emplace_back(fine.dof(static_cast<int>(node), to.first + c),
                                 coarse.dof(nodes[k], from.first + c), shapes[k]);
    }
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
                                   std::span<const Expr> exact, std::vector<UnknownNorm> norms) {
  return std::make_unique<ExactGauge>(discretisation, exact, std::move(norms));
}

std::unique_ptr<Gauge> trajectory_gauge(std::shared_ptr<const Trajectory> reference,
                                        const Discretisation& coarse,
                                        std::vector<UnknownNorm> norms) {
  const Space& fine = reference->discretisation->space;
  bool contained = is_nested(coarse.mesh, *fine.mesh);
  for (std::size_t b = 0; b < fine.blocks.size(); ++b)
    contained = contained && coarse.space.blocks[b].order <= fine.blocks[b].order;
  if (!contained)
    return std::make_unique<PointGauge>(std::move(reference), coarse, std::move(norms));
  return std::make_unique<TrajectoryGauge>(std::move(reference), coarse, std::move(norms));
}

} // namespace hvi::solver
