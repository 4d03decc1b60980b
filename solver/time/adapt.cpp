// Adapted meshes; see adapt.hpp.
#include "solver/time/adapt.hpp"

#include "solver/discrete/discretisation.hpp"
#include "solver/fem/geometry.hpp"
#include "solver/mesh/bisect.hpp"
#include "solver/plan/couplings.hpp"
#include "solver/results/run_settings.hpp"
#include "solver/time/discretise.hpp"
#include "solver/time/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace hvi::solver {
namespace {

constexpr double bulk = 0.6; ///< of the squared indicator that is refined in a round
constexpr int first_steps = 4, most_steps = 256; ///< of the runs that are looked at
constexpr int most_rounds = 60;

/// Entries of D u of an unknown at a point of a cell from the shapes there: dim x dim, or dim for a
/// scalar; with the hoop's last.
class Strain {
public:
  Strain(const Space& space, int unknown)
      : space_(space), block_(space.blocks[static_cast<std::size_t>(unknown)]),
        dim_(space.mesh->dim), first_row_(block_.order < space.order ? linear_rows : 0),
        vector_(block_.components > 1), plane_(vector_ ? dim_ * dim_ : dim_),
        size_(plane_ + (has_hoop(space, block_) ? 1 : 0)) {}
  int size() const { return size_; }
  int order() const { return block_.order; }
  bool lives_in(int cell) const { return block_.lives_in(cell); }
  /// The nodes of a cell that functions of the unknown have.
  std::span<const std::int32_t> nodes(int cell) const {
    return space_.nodes_of_cell(cell).first(
        static_cast<std::size_t>(lagrange_size(dim_, block_.order)));
  }

  void at(int cell, const CellGeometry& geometry, const Barycentric& point, const Vector& u,
          double* out) {
    evaluate_shapes(space_, geometry, point, true, shapes_);
    const auto of_cell = nodes(cell);
    std::array<double, 9> slope{};
    for (int i = 0; i < block_.components; ++i)
      for (int j = 0; j < dim_; ++j)
        for (std::size_t k = 0; k < of_cell.size(); ++k)
          slope[i * dim_ + j] += shapes_.at(first_row_ + 1 + j, static_cast<int>(k)) *
                                 u[space_.dof(of_cell[k], block_.first + i)];
    for (int e = 0; e < plane_; ++e)
      out[e] = vector_ ? 0.5 * (slope[e] + slope[e % dim_ * dim_ + e / dim_]) : slope[e];
    if (size_ == plane_) return;
    out[plane_] = 0.0;
    for (std::size_t k = 0; k < of_cell.size(); ++k)
      out[plane_] += shapes_.at(first_row_ + hoop_row, static_cast<int>(k)) *
                     u[space_.dof(of_cell[k], block_.first)];
  }
  /// Of the k-th node at the point that was asked last.
  double shape(std::size_t k) const { return shapes_.at(first_row_, static_cast<int>(k)); }

private:
  const Space& space_;
  const SpaceBlock& block_;
  int dim_, first_row_;
  bool vector_;
  int plane_, size_;
  ShapeTable shapes_;
};

/// The corners and middles of edges where the nodes of the element lie.
std::vector<Barycentric> element_points(int dim, int order) {
  std::vector<Barycentric> out;
  for (int k = 0; k <= dim; ++k) {
    out.push_back({});
    out.back()[k] = 1.0;
  }
  for (const auto& edge : simplex_edges(dim)) {
    if (order < 2) break;
    out.push_back({});
    out.back()[edge[0]] = out.back()[edge[1]] = 0.5;
  }
  return out;
}

/// Averages of D u at the nodes, weighted by the cells' measures, for each kind of cells by itself.
class Recovery {
public:
  Recovery(const Space& space, const Vector& u, std::span<const int> kind, int unknown)
      : kind_(kind), strain_(space, unknown) {
    const auto points = element_points(space.mesh->dim, strain_.order());
    const int size = strain_.size();
    std::vector<double> here(size);
    for (std::size_t cell = 0; cell < space.mesh->cells.size(); ++cell) {
      const int c = static_cast<int>(cell);
      if (!strain_.lives_in(c)) continue;
      const auto geometry = cell_geometry(*space.mesh, c);
      const auto nodes = strain_.nodes(c);
      for (std::size_t k = 0; k < nodes.size(); ++k) {
        strain_.at(c, geometry, points[k], u, here.data());
        auto& sum = sums_[{nodes[k], kind_of(c)}];
        sum.resize(size + 1, 0.0);
        for (int e = 0; e < size; ++e) sum[e] += geometry.measure * here[e];
        sum[size] += geometry.measure;
      }
    }
    for (auto& [node, sum] : sums_)
      for (int e = 0; e < size; ++e) sum[e] /= sum[size];
  }

  /// The recovered values at the nodes of a cell.
  std::vector<const double*> of_cell(int cell) const {
    std::vector<const double*> out;
    for (const std::int32_t node : strain_.nodes(cell))
      out.push_back(sums_.at({node, kind_of(cell)}).data());
    return out;
  }

  /// Has no other cell of its kind a node of this one? Then the mean is its own.
  bool is_alone(int cell, double measure) const {
    return std::ranges::all_of(strain_.nodes(cell), [&](std::int32_t node) {
      return sums_.at({node, kind_of(cell)}).back() == measure;
    });
  }

private:
  int kind_of(int cell) const { return kind_.empty() ? 0 : kind_[cell]; }

  std::span<const int> kind_;
  Strain strain_;
  std::map<std::pair<std::int32_t, int>, std::vector<double>> sums_;
};

/// On intervals. Nothing there binds the sizes of neighbours to each other, as conformity does
/// elsewhere: a mean by their measures is that of the longer one, whose error nobody would see. And
/// D u of P2 nearly is continuous whatever its error. So the derivative of the element's own order,
/// which is constant in a cell, is recovered by lines between the middles of neighbours; what these
/// make of D u has the same mean in a cell.
class IntervalRecovery {
public:
  IntervalRecovery(const Space& space, const Vector& u, std::span<const int> kind, int unknown)
      : mesh_(*space.mesh), kind_(kind), strain_(space, unknown) {
    for (std::size_t cell = 0; cell < mesh_.cells.size(); ++cell) {
      const int c = static_cast<int>(cell);
      slopes_.push_back(0.0), sizes_.push_back(0.0);
      if (!strain_.lives_in(c)) continue;
      note(c, u);
      for (int k = 0; k < 2; ++k) {
        auto& [sum, weights, cells] = sums_[key(c, k)];
        sum += slopes_.back() / length(c), weights += 1.0 / length(c), ++cells;
      }
    }
  }

  RecoveryIndicator indicator() const {
    RecoveryIndicator out{std::vector<double>(mesh_.cells.size(), 0.0)};
    for (std::size_t cell = 0; cell < out.cells.size(); ++cell) {
      const int c = static_cast<int>(cell);
      if (!strain_.lives_in(c)) continue;
      const double h = length(c), a = off(c, 0), b = off(c, 1);
      // Of a linear function its square; of the integral of one, without its mean.
      out.cells[cell] = strain_.order() == 1 ? h * (a * a + a * b + b * b) / 3
                                             : h * h * h * (a * b / 12 + (b - a) * (b - a) / 45);
      if (sums_.at(key(c, 0)).cells + sums_.at(key(c, 1)).cells == 2)
        out.cells[cell] = sizes_[cell];
      out.size += sizes_[cell];
    }
    return out;
  }

private:
  /// At a node, over the cells of a kind.
  struct Sum {
    double slopes = 0.0, weights = 0.0;
    int cells = 0;
  };
  /// The slope of a cell, and int |D u|^2.
  void note(int cell, const Vector& u) {
    const auto geometry = cell_geometry(mesh_, cell);
    double first = 0.0, last = 0.0;
    strain_.at(cell, geometry, {1, 0, 0, 0}, u, &first);
    strain_.at(cell, geometry, {0, 1, 0, 0}, u, &last);
    const auto& nodes = mesh_.cells[static_cast<std::size_t>(cell)];
    slopes_.back() = strain_.order() == 1
                         ? first
                         : (last - first) / (mesh_.nodes[static_cast<std::size_t>(nodes[1])][0] -
                                             mesh_.nodes[static_cast<std::size_t>(nodes[0])][0]);
    sizes_.back() = length(cell) * (first * first + first * last + last * last) / 3;
  }
  double length(int cell) const { return cell_geometry(mesh_, cell).measure; }
  std::pair<std::int32_t, int> key(int cell, int end) const {
    const auto c = static_cast<std::size_t>(cell);
    return {mesh_.cells[c][static_cast<std::size_t>(end)], kind_.empty() ? 0 : kind_[c]};
  }
  /// The recovered slope at an end of a cell less its own.
  double off(int cell, int end) const {
    const Sum& s = sums_.at(key(cell, end));
    return s.slopes / s.weights - slopes_[static_cast<std::size_t>(cell)];
  }

  const Mesh& mesh_;
  std::span<const int> kind_;
  Strain strain_;
  std::vector<double> slopes_, sizes_;
  std::map<std::pair<std::int32_t, int>, Sum> sums_;
};

} // namespace

RecoveryIndicator recovery_indicator(const Space& space, const Vector& u, std::span<const int> kind,
                                     int unknown) {
  if (space.mesh->dim == 1) return IntervalRecovery(space, u, kind, unknown).indicator();
  const Recovery recovery(space, u, kind, unknown);
  Strain strain(space, unknown);
  const Quadrature rule = simplex_rule(space.mesh->dim, 2 * strain.order());
  RecoveryIndicator out{std::vector<double>(space.mesh->cells.size(), 0.0)};
  std::vector<double> here(strain.size());
  for (std::size_t cell = 0; cell < out.cells.size(); ++cell) {
    const int c = static_cast<int>(cell);
    if (!strain.lives_in(c)) continue;
    const auto geometry = cell_geometry(*space.mesh, c);
    const auto nodes = recovery.of_cell(c);
    const bool alone = recovery.is_alone(c, geometry.measure);
    for (std::size_t q = 0; q < rule.size(); ++q) {
      strain.at(c, geometry, rule.points[q], u, here.data());
      double square = 0.0, own = 0.0;
      for (int e = 0; e < strain.size(); ++e) {
        double off = -here[e];
        own += here[e] * here[e];
        for (std::size_t k = 0; k < nodes.size(); ++k) off += strain.shape(k) * nodes[k][e];
        square += off * off;
      }
      const double x = point_in_cell(*space.mesh, c, rule.points[q])[0];
      const double weight = geometry.measure * rule.weights[q] * circumference(*space.mesh, x);
      out.cells[cell] += weight * (alone ? own : square);
      out.size += weight * own;
    }
  }
  return out;
}

namespace {

/// Numbers for the sets of parts of cells that forms act on: materials may change between them.
std::vector<int> kinds_of_cells(const Problem& problem, const Discretisation& d) {
  std::vector<std::vector<bool>> inside(d.mesh.cells.size());
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    const bool used =
        std::any_of(problem.forms.begin(), problem.forms.end(),
                    [&](const FormTerm& form) { return form.part == static_cast<int>(p); });
    if (!used || d.parts[p].kind != Group::Kind::cells) continue;
    for (auto& cell : inside) cell.push_back(false);
    for (const std::int32_t cell : d.parts[p].entities) inside[cell].back() = true;
  }
  std::map<std::vector<bool>, int> known;
  std::vector<int> out;
  for (const auto& cell : inside)
    out.push_back(known.try_emplace(cell, static_cast<int>(known.size())).first->second);
  return out;
}

/// The plan whose runs are looked at: few steps, nothing reported.
Plan trial(const Plan& plan, int steps) {
  Plan out = plan;
  out.problem.mesh.adapted = 0;
  out.report = {};
  if (plan.problem.time.is_static || plan.problem.time.grid.size() < 2) return out;
  out.problem.time.scheme = Scheme::backward_euler;
  const double first = plan.problem.time.grid.front(), last = plan.problem.time.grid.back();
  out.problem.time.grid.clear();
  for (int n = 0; n <= steps; ++n)
    out.problem.time.grid.push_back(first + (last - first) * n / steps);
  out.problem.time.grid.back() = last;
  return out;
}

/// The largest indicators of each cell over the steps of a run.
class Indicators {
public:
  Indicators(const Problem& problem, const Discretisation& d, std::span<const int> kinds)
      : space_(d.space), kinds_(kinds), pressures_(multipliers_of(problem)),
        largest_(pressures_.size()) {
    forget();
  }

  void forget() {
    for (RecoveryIndicator& one : largest_) {
      one = {};
      one.cells.assign(space_.mesh->cells.size(), 0.0);
    }
  }

  void take(const Vector& u) {
    for (std::size_t b = 0; b < largest_.size(); ++b) {
      if (left_out(b)) continue;
      const RecoveryIndicator now = recovery_indicator(space_, u, kinds_, static_cast<int>(b));
      RecoveryIndicator& all = largest_[b];
      std::ranges::transform(all.cells, now.cells, all.cells.begin(),
                             [](double x, double y) { return std::max(x, y); });
      all.size = std::max(all.size, now.size);
    }
  }

  /// Of several unknowns the sum, each by its own size.
  std::vector<double> by_cell() const {
    if (largest_.size() == 1) return largest_.front().cells;
    std::vector<double> out(largest_.front().cells.size(), 0.0);
    for (std::size_t b = 0; b < largest_.size(); ++b)
      for (std::size_t c = 0; c < out.size() && !left_out(b) && largest_[b].size > 0.0; ++c)
        out[c] += largest_[b].cells[c] / largest_[b].size;
    return out;
  }

private:
  bool left_out(std::size_t unknown) const {
    return largest_.size() > 1 && pressures_[unknown] != 0;
  }

  const Space& space_;
  std::span<const int> kinds_;
  std::vector<char> pressures_;
  std::vector<RecoveryIndicator> largest_;
};

/// Largest indicator of each cell over the steps of a trial run.
std::vector<double> look(const Plan& plan, const Mesh& mesh, const std::atomic<bool>* stop,
                         int& steps) {
  Discretisation d;
  const auto failures = discretise_on(trial(plan, steps), mesh, d);
  if (!failures.empty()) throw failures.front();
  const auto kinds = kinds_of_cells(plan.problem, d);
  for (;;) {
    Indicators seen(plan.problem, d, kinds);
    RunSettings settings;
    settings.stop = stop;
    settings.on_step = [&](int, double, const Vector& u, const Vector&) { seen.take(u); };
    settings.on_restart = [&] { seen.forget(); };
    try {
      run(trial(plan, steps), d, settings);
      return seen.by_cell();
    } catch (const Failure& failure) {
      // Laws that soften need short steps; failures for other reasons remain.
      const bool uncertain = failure.kind == FailureKind::not_certified ||
                             failure.kind == FailureKind::mostly_rounding;
      const bool shorter = uncertain && !plan.problem.time.is_static;
      if (!shorter || steps >= most_steps) throw;
      steps *= 2;
    }
  }
}

} // namespace

std::vector<std::int32_t> marked_cells(std::span<const double> indicators, double part) {
  std::vector<std::int32_t> order(indicators.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return indicators[a] > indicators[b]; });
  const double wanted = part * std::accumulate(indicators.begin(), indicators.end(), 0.0);
  std::size_t count = 0;
  for (double sum = 0.0; count < order.size() && (count == 0 || sum < wanted); ++count)
    sum += indicators[order[count]];
  order.resize(count);
  return order;
}

Mesh adapted_mesh(const Plan& plan, const std::atomic<bool>* stop) {
  MeshSpec spec = plan.problem.mesh;
  spec.adapted = 0;
  const Mesh first = make_mesh(spec);
  const auto most = static_cast<std::size_t>(std::max(plan.problem.mesh.adapted, 0));
  Bisection now(first);
  Mesh mesh = first;
  int steps = first_steps, round = 0;
  for (; round < most_rounds && now.n_cells() < most; ++round) {
    const auto marked = marked_cells(look(plan, mesh, stop, steps), bulk);
    Bisection next = now;
    next.bisect(marked, mesh.dim); // edges are halved
    if (next.n_cells() > most) {
      // As many of the marked cells, the worst first, as the wanted number of cells allows.
      std::size_t fits = 0, too_many = marked.size();
      next = now;
      while (fits + 1 < too_many) {
        const std::size_t middle = (fits + too_many) / 2;
        Bisection tried = now;
        tried.bisect({marked.data(), middle}, mesh.dim);
        if (tried.n_cells() <= most)
          fits = middle, next = std::move(tried);
        else
          too_many = middle;
      }
      mesh = next.mesh();
      ++round;
      break;
    }
    now = std::move(next);
    mesh = now.mesh();
  }
  mesh.description = fmt::format("{}, bisected in {} rounds", first.description, round);
  return mesh;
}

std::string adapted_key(const Plan& plan) {
  Plan key = trial(plan, 1);
  key.problem.mesh.adapted = plan.problem.mesh.adapted;
  key.options = {};
  key.problem.effects.clear();
  return to_string(key);
}

} // namespace hvi::solver
