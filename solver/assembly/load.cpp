// Loads: f(t)_i = int sum_e F_e(x, t, nu) D_{test_e}(phi_i).
//
// F = sum_m g_m(t) h_m(x) is taken apart symbolically, so that a time step costs one vector sum per
// g_m. What does not separate becomes a sparse matrix P from values at quadrature points to dofs,
// and a time step runs the tape and multiplies.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/cut_integral.hpp"
#include "solver/assembly/degree.hpp"
#include "solver/assembly/knots.hpp"
#include "solver/fem/pointwise.hpp"
#include "solver/kernel/algebra.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// g(t) F with its time factor; F is a full vector.
struct Mode {
  Expr g;
  Vector f;
  Origin origin;
};

/// A load, or part of one, that is assembled at every step.
struct Lazy {
  PointBlock points;
  Pointwise tape;
  Eigen::SparseMatrix<double, Eigen::RowMajor> weights; ///< n_dofs x (entries * points)
  Origin origin;
  Vector values; ///< scratch
};

using LoadEntries = std::vector<LoadTerm::Entry>;

/// Weight of value e at point p in dof i:  w_p D_{test_e}(phi_i)(x_p).  Calls f(dof, e, p, weight).
template <class F>
void for_each_weight(const Space& space, const PointBlock& block, const LoadEntries& entries,
                     Origin origin, F&& f) {
  std::vector<Derivative> tests;
  bool gradients = false;
  for (const auto& entry : entries) {
    tests.push_back(decode(space, entry.test, origin));
    gradients = gradients || !slot::is_value(entry.test);
  }
  ShapeTable shapes;
  CellGeometry geometry;
  int cell = -1;
  for (std::size_t p = 0; p < block.size(); ++p) {
    if (gradients && block.cell[p] != cell) {
      geometry = cell_geometry(*space.mesh, block.cell[p]);
    }
    cell = block.cell[p];
    evaluate_shapes(space, geometry, block.barycentric[p], gradients, shapes);
    const auto nodes = space.nodes_of_cell(cell);
    for (std::size_t e = 0; e < entries.size(); ++e) {
      for (int i = 0; i < shapes.size; ++i) {
        const double weight = block.weight[p] * shapes.at(tests[e].row, i);
        if (weight != 0.0) {
          f(space.dof(nodes[i], tests[e].component), e, p, weight);
        }
      }
    }
  }
}

std::vector<Expr> values_of(const LoadEntries& entries) {
  std::vector<Expr> values;
  for (const auto& entry : entries) {
    values.push_back(entry.value);
  }
  return values;
}

RegionPoints points_of(const Space& space, const Region& region, const LoadTerm& term,
                       const LoadEntries& entries) {
  int degree = 0;
  for (const auto& entry : entries) {
    const int shapes = shape_degree(entry.test, space.order);
    if (!slot::is_value(entry.test) && region.kind == Group::Kind::points) {
      throw Failure(FailureKind::bad_value, term.origin,
                    "a gradient has no value at a single point; a point load acts on v itself");
    }
    degree = std::max(degree, exact_degree(entry.value, shapes, space.order));
  }
  return {space, region, term.rule, degree};
}

void check_finite(const PointBlock& block, std::span<const double> values, Origin origin, int dim,
                  const double* t) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k])) {
      continue;
    }
    throw_not_finite(origin, "the load", values[k], block.point(k % block.size()), dim, t);
  }
}

/// F for entries that do not depend on t.
Vector assemble_vector(const Space& space, const Region& region, const LoadTerm& term,
                       const LoadEntries& entries) {
  Vector out = Vector::Zero(space.n_dofs());
  Pointwise tape(values_of(entries));
  std::vector<double> values;
  points_of(space, region, term, entries).for_blocks([&](const PointBlock& block) {
    values.resize(block.size() * entries.size());
    tape.evaluate(block, 0.0, term.origin, values);
    check_finite(block, values, term.origin, space.mesh->dim, nullptr);
    for_each_weight(space, block, entries, term.origin, [&](int dof, auto e, auto p, double w) {
      out[dof] += w * values[e * block.size() + p];
    });
  });
  return out;
}

Lazy make_lazy(const Space& space, const Region& region, const LoadTerm& term,
               const LoadEntries& entries) {
  PointBlock points;
  const RegionPoints source = points_of(space, region, term, entries);
  source.fill(0, source.entities(), points);
  const auto n = static_cast<Eigen::Index>(points.size());
  std::vector<Eigen::Triplet<double>> triplets;
  for_each_weight(space, points, entries, term.origin, [&](int dof, auto e, auto p, double w) {
    triplets.emplace_back(dof, static_cast<int>(Eigen::Index(e) * n + Eigen::Index(p)), w);
  });
  Eigen::SparseMatrix<double, Eigen::RowMajor> weights(space.n_dofs(),
                                                       n * Eigen::Index(entries.size()));
  weights.setFromTriplets(triplets.begin(), triplets.end());
  return {std::move(points), Pointwise(values_of(entries)), std::move(weights), term.origin, {}};
}

bool is_time(Slot slot) { return slot == slot::t; }

/// In so many pieces of a step changes of sign are looked for.
constexpr int looks_for_signs = 100;
/// Functions of time, and of time and place, whose values cost more.
constexpr CutLimits of_time{5, 75, 1e-15}, of_fields{0, 5, 1e-12};
/// Of the integral's size: |t - c|^-a leaves more from a = 2/3 on, 1/(t - c) a tenth.
constexpr double most_unsettled = 1e-4;

} // namespace

struct LoadAssembler::Impl {
  int dim = 2;
  std::vector<Mode> modes;
  std::vector<Lazy> lazy;
  std::vector<Pointwise> factors; ///< g of all modes; one element, none without modes
  std::vector<double> g_values;
  std::vector<std::pair<Origin, Cost>> costs; ///< by load
  Knots knots;                                ///< sorted
  IntervalRule rule = gauss_jacobi(4, 0);     ///< degree 7

  std::optional<Pointwise> signs; ///< Knots::signs

  std::vector<double> knots_between(double t0, double t1);
  bool change_sign(std::size_t k, double t0, double t1);
  void add_term(const Space& space, const Region& region, const LoadTerm& term);
  void add_mode(const Expr& time_factor, Vector f, Origin origin);
  void evaluate_factors(double t);
  void integrate_factors(double begin, double end);
  void add_modes(double scale, Vector& out) const;
  void evaluate(Lazy& part, double t) const;
  void add_lazy(double t, double scale, Vector& out);
};

void LoadAssembler::Impl::add_term(const Space& space, const Region& region, const LoadTerm& term) {
  std::vector<std::pair<Expr, LoadEntries>> separated; // by time factor
  LoadEntries rest;
  for (const auto& entry : term.entries) {
    if (entry.value.is(0.0)) {
      continue;
    }
    collect_knots(entry.value, knots);
    const auto products = split_separable(entry.value, is_time);
    if (!products) {
      rest.push_back(entry);
      continue;
    }
    for (const auto& [h, g] : *products) {
      auto same = std::find_if(separated.begin(), separated.end(),
                               [&, &factor = g](auto& part) { return part.first == factor; });
      if (same == separated.end()) {
        same = separated.insert(separated.end(), {g, {}});
      }
      same->second.push_back({entry.test, h});
    }
  }
  for (const auto& [g, entries] : separated) {
    add_mode(g, assemble_vector(space, region, term, entries), term.origin);
  }
  if (!rest.empty()) {
    lazy.push_back(make_lazy(space, region, term, rest));
  }
  const bool constant = std::all_of(separated.begin(), separated.end(),
                                    [](const auto& part) { return part.first.is_constant(); });
  costs.emplace_back(term.origin, !rest.empty()       ? Cost::every_step
                                  : !constant         ? Cost::once_per_factor
                                  : separated.empty() ? Cost::nothing
                                                      : Cost::once);
}

void LoadAssembler::Impl::add_mode(const Expr& time_factor, Vector f, Origin origin) {
  for (Mode& mode : modes) {
    if (mode.g == time_factor) {
      mode.f += f;
      return;
    }
  }
  modes.push_back({time_factor, std::move(f), origin});
}

void LoadAssembler::Impl::evaluate_factors(double t) {
  if (modes.empty()) {
    return;
  }
  g_values.resize(modes.size());
  const auto columns = [&](Slot slot) { return is_time(slot) ? &t : nullptr; };
  factors.front().evaluate(1, columns, modes.front().origin, g_values);
  for (std::size_t m = 0; m < modes.size(); ++m) {
    if (std::isfinite(g_values[m])) {
      continue;
    }
    const double shown = std::isnan(g_values[m]) ? std::abs(g_values[m]) : g_values[m];
    throw Failure(FailureKind::bad_value, modes[m].origin,
                  fmt::format("the load is {} at t = {:.6g}: its factor is {}", shown, t,
                              to_string(modes[m].g)));
  }
}

/// g_values = the integral of each g over [begin, end].
void LoadAssembler::Impl::integrate_factors(double begin, double end) {
  std::vector<double> integrals(modes.size());
  for (std::size_t m = 0; m < modes.size(); ++m) {
    const auto g = [&](double t) {
      evaluate_factors(t);
      return g_values[m];
    };
    const auto found = cut_integral(of_time, rule, g, begin, end);
    if (found.unsettled > most_unsettled)
      throw Failure(FailureKind::bad_value, modes[m].origin,
                    fmt::format("the load has no mean from t = {:.6g} to {:.6g} that could be "
                                "found: its factor is {}",
                                begin, end, to_string(modes[m].g)),
                    "where it is infinite it grows too fast for an integral");
    integrals[m] = found.value;
  }
  g_values = std::move(integrals);
}

/// out += scale sum_m g_values_m F_m.
void LoadAssembler::Impl::add_modes(double scale, Vector& out) const {
  // In blocks that stay in the cache: every vector is read once.
  constexpr Eigen::Index block = 1024;
  for (Eigen::Index from = 0; from < out.size() && !modes.empty(); from += block) {
    const Eigen::Index n = std::min(block, out.size() - from);
    for (std::size_t m = 0; m < modes.size(); ++m) {
      out.segment(from, n) += (scale * g_values[m]) * modes[m].f.segment(from, n);
    }
  }
}

/// Sets the values of a part that does not separate, at t.
void LoadAssembler::Impl::evaluate(Lazy& part, double t) const {
  part.values.resize(part.weights.cols());
  const std::span<double> values(part.values.data(), std::size_t(part.values.size()));
  part.tape.evaluate(part.points, t, part.origin, values);
  check_finite(part.points, values, part.origin, dim, &t);
}

void LoadAssembler::Impl::add_lazy(double t, double scale, Vector& out) {
  for (Lazy& part : lazy) {
    evaluate(part, t);
    out += scale * (part.weights * part.values);
  }
}

/// Has function k of `signs` another sign at t1 than at t0?
bool LoadAssembler::Impl::change_sign(std::size_t k, double t0, double t1) {
  std::vector<double> values(knots.signs.size());
  const auto positive = [&](double t) {
    const auto columns = [&](Slot slot) { return is_time(slot) ? &t : nullptr; };
    signs->evaluate(1, columns, {}, values);
    return values[k] > 0.0;
  };
  return positive(t0) != positive(t1);
}

/// The knots inside a step, increasing.
std::vector<double> LoadAssembler::Impl::knots_between(double t0, double t1) {
  std::vector<double> out;
  const double margin = 1e-12 * (t1 - t0);
  for (const double knot : knots.times)
    if (knot > t0 + margin && knot < t1 - margin) out.push_back(knot);
  if (!knots.signs.empty() && !signs) signs.emplace(knots.signs);
  for (std::size_t k = 0; k < knots.signs.size(); ++k)
    for (int i = 0; i < looks_for_signs; ++i) {
      double low = t0 + (t1 - t0) * i / looks_for_signs;
      double high = t0 + (t1 - t0) * (i + 1) / looks_for_signs;
      if (!change_sign(k, low, high)) continue;
      while (high - low > margin) {
        const double middle = 0.5 * (low + high);
        (change_sign(k, low, middle) ? high : low) = middle;
      }
      if (low > t0 + margin && high < t1 - margin) out.push_back(0.5 * (low + high));
    }
  std::sort(out.begin(), out.end());
  return out;
}

LoadAssembler::LoadAssembler(const Space& space, std::span<const Region> parts,
                             std::span<const LoadTerm> loads)
    : impl_(std::make_unique<Impl>()) {
  impl_->dim = space.mesh->dim;
  for (const LoadTerm& term : loads) {
    impl_->add_term(space, parts[term.part], term);
  }
  std::sort(impl_->knots.times.begin(), impl_->knots.times.end());
  std::vector<Expr> factors;
  for (const Mode& mode : impl_->modes) {
    factors.push_back(mode.g);
  }
  if (!factors.empty()) {
    impl_->factors.emplace_back(factors);
  }
}
LoadAssembler::~LoadAssembler() = default;
LoadAssembler::LoadAssembler(LoadAssembler&&) noexcept = default;

void LoadAssembler::add(double t, Vector& out) const {
  impl_->evaluate_factors(t);
  impl_->add_modes(1.0, out);
  impl_->add_lazy(t, 1.0, out);
}

void LoadAssembler::add_mean(double t0, double t1, Vector& out) const {
  const double length = t1 - t0;
  double begin = t0;
  const auto add_piece = [&](double end) {
    impl_->integrate_factors(begin, end);
    impl_->add_modes(1.0 / length, out);
    for (Lazy& part : impl_->lazy) {
      const auto values = [&](double t) -> const Vector& {
        impl_->evaluate(part, t);
        return part.values;
      };
      out += 1.0 / length *
             (part.weights * cut_integral(of_fields, impl_->rule, values, begin, end).value);
    }
    begin = end;
  };
  for (const double knot : impl_->knots_between(t0, t1)) add_piece(knot);
  add_piece(t1);
}

namespace {

/// Rows of links are added to the rows that they are one with.
Eigen::SparseMatrix<double, Eigen::RowMajor>
moved(const Eigen::SparseMatrix<double, Eigen::RowMajor>& weights, std::span<const DofLink> links) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < weights.rows(); ++i) entries.emplace_back(i, i, 1.0);
  for (const DofLink& link : links) entries.emplace_back(link.to, link.dof, 1.0);
  Eigen::SparseMatrix<double, Eigen::RowMajor> sums(weights.rows(), weights.rows());
  sums.setFromTriplets(entries.begin(), entries.end());
  return sums * weights;
}

} // namespace

void LoadAssembler::restrict_to(std::span<const std::int32_t> dofs,
                                std::span<const DofLink> links) {
  const auto n = static_cast<Eigen::Index>(dofs.size());
  for (Mode& mode : impl_->modes) {
    for (const DofLink& link : links) mode.f[link.to] += mode.f[link.dof];
    Vector kept(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      kept[i] = mode.f[dofs[static_cast<std::size_t>(i)]];
    }
    mode.f = std::move(kept);
  }
  for (Lazy& part : impl_->lazy) {
    if (!links.empty()) part.weights = moved(part.weights, links);
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index i = 0; i < n; ++i) {
      using Row = Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator;
      for (Row it(part.weights, dofs[static_cast<std::size_t>(i)]); it; ++it) {
        entries.emplace_back(static_cast<int>(i), static_cast<int>(it.col()), it.value());
      }
    }
    Eigen::SparseMatrix<double, Eigen::RowMajor> kept(n, part.weights.cols());
    kept.setFromTriplets(entries.begin(), entries.end());
    part.weights = std::move(kept);
  }
}

void LoadAssembler::map(const std::function<Vector(const Vector&)>& map) {
  for (Mode& mode : impl_->modes) {
    mode.f = map(mode.f);
  }
}

bool LoadAssembler::separable() const { return impl_->lazy.empty(); }
LoadAssembler::Cost LoadAssembler::cost(Origin origin) const {
  for (const auto& [of, cost] : impl_->costs) {
    if (of == origin) return cost;
  }
  return Cost::nothing;
}

} // namespace hvi::solver
