// Expressions that read multipliers, at the laws' own quadrature points; see law_sampler.hpp.
#include "solver/time/law_sampler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace hvi::solver {
namespace {

bool is_multiplier(Slot s) { return s >= slot::first_multiplier && s < slot::first_inside; }
bool is_field(Slot s) { return s >= slot::first_field && s < slot::first_multiplier; }
int term_of(Slot s) { return (s - slot::first_multiplier) / 4; }
/// The term at whose points a multiplier or a state is known; -1: it is neither.
int term_of(const Contact& contact, Slot s) {
  if (is_multiplier(s)) return term_of(s);
  if (!slot::is_state(s)) return -1;
  for (const auto& group : contact.state_groups)
    if (std::ranges::find(group.states, s - slot::first_state) != group.states.end())
      return group.host;
  return -1;
}
int component_of(Slot s) { return (s - slot::first_multiplier) % 4; }

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Barycentric coordinates of a point in a cell, from the gradients and the centroid.
Barycentric barycentric_of(const Mesh& mesh, int cell, const Point& x) {
  const auto geometry = cell_geometry(mesh, cell);
  Barycentric out{};
  for (int k = 0; k <= mesh.dim; ++k) out[k] = 1.0 / (mesh.dim + 1);
  const Point centroid = point_in_cell(mesh, cell, out);
  for (int k = 0; k <= mesh.dim; ++k)
    for (int i = 0; i < mesh.dim; ++i) out[k] += geometry.gradient[k][i] * (x[i] - centroid[i]);
  return out;
}

} // namespace

LawSampler::LawSampler(const Problem& problem, const Discretisation& d, const Contact& contact,
                       std::vector<Expr> expressions, Origin origin, int part)
    : expressions_(expressions), origin_(origin) {
  for (const auto s : expressions_.inputs())
    if (law_term_ < 0) law_term_ = term_of(contact, s);
  const auto& term = problem.law_terms[law_term_];
  const auto& own = contact.terms[law_term_].points;
  LawPoints other;
  if (part >= 0 && part != term.part)
    other = assemble_law(d.space, d.parts[part], term, law_term_, !own.frames.empty());
  const auto& points = other.x.empty() ? own : other;
  std::vector<int> all(points.x.size());
  std::iota(all.begin(), all.end(), 0);
  take_points(points, term, all);
  for (const auto s : expressions_.inputs()) {
    if (const int known = term_of(contact, s); known >= 0) match(contact, known, d.mesh.dim);
    if (is_field(s)) prepare_field(d.space, s);
  }
}

LawSampler LawSampler::at(const Problem& problem, const Discretisation& d, const Contact& contact,
                          const Expr& expression, Origin origin, const Point& place) {
  LawSampler out(problem, d, contact, {expression}, origin);
  const auto& points = contact.terms[out.law_term_].points;
  const auto quality = mesh_quality(d.mesh);
  std::vector<int> chosen;
  for (int p = 0; p < static_cast<int>(points.x.size()); ++p)
    if (distance(points.x[p], place) <= 1e-6 * quality.shortest_edge) chosen.push_back(p);
  if (chosen.empty())
    throw Failure(
        FailureKind::bad_value, origin,
        fmt::format("what lives at the points of `{}` is known there only, and {} is none of "
                    "them",
                    problem.law_terms[out.law_term_].name, describe_point(place, d.mesh.dim)),
        "ask at a node of the contact part, or for an integral");
  out.take_points(points, problem.law_terms[out.law_term_], chosen);
  const double total = std::accumulate(out.block_.weight.begin(), out.block_.weight.end(), 0.0);
  for (auto& weight : out.block_.weight) weight /= total;
  for (const auto s : out.expressions_.inputs()) {
    if (const int known = term_of(contact, s); known >= 0) out.match(contact, known, d.mesh.dim);
    if (is_field(s)) out.prepare_field(d.space, s);
  }
  return out;
}

void LawSampler::take_points(const LawPoints& points, const LawTerm& term,
                             const std::vector<int>& chosen) {
  block_.clear();
  nodes_.clear();
  for (const int p : chosen) {
    for (int i = 0; i < 3; ++i) {
      block_.x[i].push_back(points.x[p][i]);
      block_.normal[i].push_back(points.normal[p][i]);
    }
    block_.weight.push_back(points.weight[p]);
    block_.cell.push_back(points.cell[p]);
    block_.entity.push_back(points.facet[p]);
    nodes_.push_back(points.node[p]);
  }
  block_.kind = points.kind;
  block_.indicators = points.indicators;
  const std::vector<Expr> factor{term.factor};
  values_.assign(std::max<std::size_t>(block_.size(), 1), 0.0);
  Pointwise(factor).evaluate(block_, 0.0, term.origin, values_);
  for (std::size_t p = 0; p < block_.size(); ++p) block_.weight[p] /= values_[p];
}

/// Finds for each of our points the point of `term` at the same place with the same normal.
void LawSampler::match(const Contact& contact, int term, int dim) {
  const auto& theirs = contact.terms[term].points;
  std::map<Point, std::vector<int>> by_place;
  for (int p = 0; p < static_cast<int>(theirs.x.size()); ++p) by_place[theirs.x[p]].push_back(p);
  std::vector<int> found;
  for (std::size_t p = 0; p < block_.size(); ++p) {
    const Point normal{block_.normal[0][p], block_.normal[1][p], block_.normal[2][p]};
    const auto there = by_place.find(block_.point(p));
    if (there != by_place.end())
      for (const int candidate : there->second)
        if (found.size() == p && distance(theirs.normal[candidate], normal) <= 1e-9)
          found.push_back(candidate);
    if (found.size() == p)
      throw Failure(FailureKind::bad_value, origin_,
                    fmt::format("what lives at the points of a law is not known at {}",
                                describe_point(block_.point(p), dim)),
                    "integrate a multiplier over the part where its law acts");
  }
  point_of_[term] = std::move(found);
}

/// Rows that take a full vector to the values of a field's derivative at our points.
void LawSampler::prepare_field(const Space& space, Slot s) {
  const int index = (s - slot::first_field) % slot::field_stride;
  const auto derivative = decode(space, index, origin_);
  std::vector<Eigen::Triplet<double>> entries;
  ShapeTable shapes;
  for (std::size_t p = 0; p < block_.size(); ++p) {
    const int cell = block_.cell[p];
    evaluate_shapes(space, cell_geometry(*space.mesh, cell),
                    barycentric_of(*space.mesh, cell, block_.point(p)), true, shapes);
    const auto nodes = space.nodes_of_cell(cell);
    for (int i = 0; i < shapes.size; ++i)
      entries.emplace_back(static_cast<int>(p), space.dof(nodes[i], derivative.component),
                           shapes.at(derivative.row, i));
  }
  auto& rows = rows_[s];
  rows.resize(static_cast<Eigen::Index>(block_.size()), space.n_dofs());
  rows.setFromTriplets(entries.begin(), entries.end());
}

void LawSampler::evaluate(const Contact& contact, const Snapshot& snapshot, std::span<double> out) {
  for (const auto s : expressions_.inputs()) {
    if (is_field(s)) {
      const int k = (s - slot::first_field) / slot::field_stride;
      columns_[s] = rows_.at(s) * snapshot.field(k);
    } else if (slot::is_state(s)) {
      auto& column = columns_[s];
      column.resize(size());
      const auto& theirs = point_of_.at(term_of(contact, s));
      const int first = contact.first_state[static_cast<std::size_t>(s - slot::first_state)];
      for (int p = 0; p < size(); ++p) column[p] = snapshot.states()[first + theirs[p]];
    } else if (is_multiplier(s)) {
      auto& column = columns_[s];
      column.resize(size());
      const auto& theirs = point_of_.at(term_of(s));
      for (int p = 0; p < size(); ++p)
        column[p] =
            global_multiplier(contact.terms[term_of(s)], snapshot.xi(), theirs[p])[component_of(s)];
    }
  }
  expressions_.evaluate(block_, snapshot.t(), origin_, out, [&](Slot s) -> const double* {
    const auto column = columns_.find(s);
    return column == columns_.end() ? nullptr : column->second.data();
  });
}

double LawSampler::integral(const Contact& contact, const Snapshot& snapshot) {
  if (size() == 0) return 0.0;
  values_.resize(block_.size());
  evaluate(contact, snapshot, values_);
  return std::inner_product(values_.begin(), values_.end(), block_.weight.begin(), 0.0);
}

namespace {

/// Does an expression read the multiplier of a law that acts on another part?
bool reads_from_elsewhere(const Problem& problem, const Expr& expression, int part) {
  for (int term = 0; term < static_cast<int>(problem.law_terms.size()); ++term) {
    const Slot first = slot::first_multiplier + 4 * term;
    if (problem.law_terms[term].part != part && expression.depends_on_any(first, first + 4))
      return true;
  }
  for (std::size_t i = 0; i < problem.states.size(); ++i)
    if (problem.states[i].part != part && expression.depends_on(slot::state(static_cast<int>(i))))
      return true;
  return false;
}

} // namespace

std::vector<Failure> misplaced_multipliers(const Plan& plan, const Discretisation& d) {
  std::vector<Failure> failures;
  std::optional<Contact> contact; // made where somebody asks
  const auto collect = [&](const auto& make) {
    try {
      if (!contact) contact = make_contact(plan.problem, d, make_layout(d.space, d.dofs));
      make();
    } catch (const Failure& failure) {
      failures.push_back(failure);
    }
  };
  for (const Probe& probe : plan.report.probes) {
    const Expr& e = probe.expression;
    if (probe.kind == Probe::Kind::integral && reads_from_elsewhere(plan.problem, e, probe.part))
      collect([&] { LawSampler(plan.problem, d, *contact, {e}, probe.origin, probe.part); });
    if (probe.kind == Probe::Kind::at_point && reads_multiplier(e))
      collect([&] { LawSampler::at(plan.problem, d, *contact, e, probe.origin, probe.point); });
  }
  for (const FieldsSpec& fields : plan.report.fields)
    for (const FieldSpec& field : fields.fields)
      if (plan.problem.law_terms.size() > 1 &&
          std::ranges::any_of(field.components, reads_multiplier))
        collect([&] { LawSampler(plan.problem, d, *contact, field.components, field.origin); });
  return failures;
}

} // namespace hvi::solver
