// See frames.hpp.
#include "solver/results/frames.hpp"

#include "solver/step/run_state.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace hvi::solver {
namespace {

int components_of_xi(const ContactTerm& term, const LawTerm& spec) {
  return term.points.frames.empty() ? 1 : static_cast<int>(spec.rows.size());
}

/// xi, the coefficients of every row, u: what the points of a law are shown with.
std::vector<Expr> shown_at_points(const LawTerm& spec, int law_term, int n_xi, int dim,
                                  bool on_pair) {
  std::vector<Expr> out;
  for (int c = 0; c < n_xi; ++c) out.push_back(Expr::variable(slot::multiplier(law_term, c)));
  for (const auto& row : spec.rows)
    for (int i = 0; i < dim; ++i) out.push_back(row.u[static_cast<std::size_t>(i)]);
  const auto u = [&](int derivative) {
    return Expr::variable(slot::field(field_of_u(0), slot::of_unknown(spec.unknown, derivative)));
  };
  for (int i = 0; i < dim; ++i) // of a pair its first side, on which the forces act
    out.push_back(on_pair ? u(slot::mean(i)) + 0.5 * u(slot::value(i)) : u(slot::value(i)));
  return out;
}

/// z counts as on a break within this part of the largest argument.
constexpr double on_a_break = 1e-9;

BranchKind branch_of_scalar(const Law& law, const LawGraph& graph, double z, double xi,
                            double near) {
  for (std::size_t k = 0; k < graph.breaks.size(); ++k) {
    const double low = std::min(graph.left[k], graph.right[k]);
    const double high = std::max(graph.left[k], graph.right[k]);
    if (std::abs(z - graph.breaks[k]) <= near && xi > low && xi < high) return BranchKind::held;
  }
  if (xi == 0.0) return BranchKind::open;
  const double slope = law.curvature(graph, piece_of(graph, z), z);
  return slope < 0.0 ? BranchKind::softened : BranchKind::loaded;
}

BranchKind branch_of_radial(const Law& law, const LawGraph& graph, double z, double near) {
  if (z <= near) return BranchKind::stick;
  const double slope = law.curvature(graph, piece_of(graph, z), z);
  return slope < 0.0 ? BranchKind::slip_softened : BranchKind::slip;
}

} // namespace

std::vector<BranchKind> branches_of(const RunState& run, int law_term) {
  const Contact& contact = run.contact();
  const ContactTerm& term = contact.terms[static_cast<std::size_t>(law_term)];
  const int rows = term.points.rows;
  const auto z = run.trial.z.segment(term.first_row, term.n_rows());
  const auto xi = run.xi().segment(term.first_row, term.n_rows());
  const double near = z.size() == 0 ? 0.0 : on_a_break * z.cwiseAbs().maxCoeff();
  std::vector<BranchKind> out;
  for (int p = 0; p < term.n_points(); ++p) {
    const auto& point = contact.problem.points[static_cast<std::size_t>(term.first_point + p)];
    const Law& law = *contact.problem.laws[static_cast<std::size_t>(point.law)];
    const LawGraph& graph = contact.problem.graphs[static_cast<std::size_t>(point.graph)];
    out.push_back(law.spec().radial
                      ? branch_of_radial(law, graph, z.segment(p * rows, rows).norm(), near)
                      : branch_of_scalar(law, graph, z[p], xi[p], near));
  }
  return out;
}

LawGrid::LawGrid(const Problem& problem, const Discretisation& d, const Contact& contact,
                 int law_term)
    : contact_(contact), term_(problem.law_terms[static_cast<std::size_t>(law_term)]),
      name_(term_.name),
      dim_(unknowns_of(problem.space)[static_cast<std::size_t>(term_.unknown)].vector ? d.mesh.dim
                                                                                      : 0),
      n_xi_(components_of_xi(contact.terms[static_cast<std::size_t>(law_term)], term_)),
      law_term_(law_term),
      expressions_(shown_at_points(term_, law_term, n_xi_, dim_,
                                   d.parts[static_cast<std::size_t>(term_.part)].is_pair())),
      sampler_(problem, d, contact, expressions_, term_.origin) {}

FieldGrid LawGrid::at(const Snapshot& snapshot, const RunState* run) {
  FieldGrid out;
  out.name = name_;
  VtuGrid& grid = out.grid;
  grid.cell = VtkCell::vertex;
  grid.time = snapshot.t();
  const auto size = static_cast<std::size_t>(sampler_.size());
  std::vector<double> values(expressions_.size() * size);
  sampler_.evaluate(contact_, snapshot, values);
  const auto value = [&](int e, std::size_t p) { return values[e * size + p]; };
  const int rows = static_cast<int>(term_.rows.size()), first_u = n_xi_ + rows * dim_;
  std::vector<double> xi, force, moved;
  for (std::size_t p = 0; p < size; ++p) {
    grid.points.push_back(sampler_.points().point(p));
    grid.connectivity.push_back(static_cast<std::int64_t>(p));
    for (int c = 0; c < n_xi_; ++c) xi.push_back(value(c, p));
    for (int i = 0; i < dim_; ++i) {
      double sum = 0.0;
      for (int c = 0; c < n_xi_; ++c) sum -= value(c, p) * value(n_xi_ + c * dim_ + i, p);
      force.push_back(sum);
      moved.push_back(value(first_u + i, p));
    }
  }
  grid.point_data.push_back(vtk_array(multiplier_array, n_xi_, xi));
  if (dim_ > 0) {
    grid.point_data.push_back(vtk_array(force_array, dim_, force));
    grid.point_data.push_back(vtk_array(displacement_array, dim_, moved));
  }
  if (run == nullptr) return out;
  std::vector<double> kinds;
  for (const BranchKind kind : branches_of(*run, law_term_))
    kinds.push_back(static_cast<double>(kind));
  if (kinds.size() == size) grid.point_data.push_back({branch_array, 1, std::move(kinds)});
  return out;
}

FrameMaker::FrameMaker(const Problem& problem, const Discretisation& d, const Contact& contact,
                       std::span<const FieldSpec> fields, std::span<const int> law_terms)
    : fields_(problem, d, contact, fields, FieldGrids::OfStates::on_the_mesh) {
  for (const int term : law_terms) laws_.emplace_back(problem, d, contact, term);
}

FrameMaker FrameMaker::of_picture(const Problem& problem, const Discretisation& d,
                                  const Contact& contact, const FieldSpec& field) {
  std::vector<FieldSpec> fields;
  for (FieldSpec& unknown : unknown_fields(problem, d.mesh.dim))
    if (unknown.name == displacement_array) fields.push_back(std::move(unknown));
  fields.push_back(field);
  std::set<int> terms;
  for (int l = 0; l < static_cast<int>(contact.terms.size()); ++l)
    for (const Expr& e : field.components)
      if (e.depends_on_any(slot::multiplier(l, 0), slot::multiplier(l, slot::most_arguments)))
        terms.insert(l);
  const std::vector<int> chosen(terms.begin(), terms.end());
  return {problem, d, contact, fields, chosen};
}

std::vector<Expr> FrameMaker::expressions() const {
  auto out = fields_.expressions();
  for (const LawGrid& law : laws_) {
    const auto more = law.expressions();
    out.insert(out.end(), more.begin(), more.end());
  }
  return out;
}

FieldFrame FrameMaker::at(const Snapshot& snapshot, const RunState* run) {
  FieldFrame out{snapshot.t(), snapshot.step(), fields_.fill(snapshot)};
  for (LawGrid& law : laws_) out.grids.push_back(law.at(snapshot, run));
  return out;
}

} // namespace hvi::solver
