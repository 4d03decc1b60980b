// The laws of a plan as the reduced problem of one step; see contact.hpp.
#include "solver/time/contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

// Beyond these the dense Schur complement (n_c^2 doubles, n_c^3 / 3 operations) does not pay.
constexpr int most_condensed = 12000;
constexpr int always_condensed = 300;
constexpr double most_condensed_share = 0.3;

void make_laws(const Problem& problem, Contact& out) {
  for (const auto& spec : problem.laws) out.laws.push_back(std::make_unique<Law>(spec));
  for (const auto& law : out.laws) out.problem.laws.push_back(law.get());
}

/// Points of all terms, with a graph each, or one per law that is the same everywhere.
void add_points(const Problem& problem, Contact& out, const ContactTerm& term, double t) {
  const int law = problem.law_terms[term.points.law_term].law;
  const auto& graph_of = *out.laws[law];
  auto& inequality = out.problem;
  for (int p = 0; p < term.n_points(); ++p) {
    if (p == 0 || graph_of.depends_on_x())
      inequality.graphs.push_back(graph_of.graph(term.points.x[p], t));
    inequality.points.push_back({law, term.points.law_term, term.first_row + p * term.points.rows,
                                 term.points.rows, term.points.weight[p],
                                 static_cast<int>(inequality.graphs.size()) - 1});
  }
}

/// The steepest descent of a law's slope; of one that depends on place or time, over a sample.
double softening(const Law& law, const ContactTerm& term, const TimeSpec& time) {
  constexpr int most = 16;
  const int stride = law.depends_on_x() ? std::max(1, term.n_points() / most) : term.n_points();
  double out = 0;
  for (int p = 0; p < term.n_points(); p += stride)
    for (const double part : {0.0, 0.5, 1.0}) {
      if (part > 0 && (!law.depends_on_t() || time.is_static)) break;
      const double t =
          time.is_static ? 0.0 : time.grid.front() + part * (time.grid.back() - time.grid.front());
      out = std::max(out, law.constants(term.points.x[p], t).m);
    }
  return out;
}

/// Finds the rows whose multipliers coupled laws read: of a scalar law at the very same points.
void couple(const Problem& problem, Contact& out) {
  for (auto& term : out.terms) {
    const auto& spec = problem.law_terms[term.points.law_term];
    const std::string& wanted = problem.laws[spec.law].coupled;
    if (wanted.empty()) continue;
    out.coupled = true;
    for (const auto& other : out.terms) {
      const auto& there = problem.law_terms[other.points.law_term];
      if (there.name == wanted && other.points.rows == 1 && other.points.x == term.points.x)
        term.coupled_row = other.first_row;
    }
    if (term.coupled_row < 0)
      throw Failure(
          FailureKind::bad_law, spec.origin,
          fmt::format("`{}` reads the multiplier of `{}`, which does not act at its points",
                      spec.name, wanted),
          "put both laws on the same part with the same rule; the other one is scalar");
    for (int p = 0; p < term.n_points(); ++p)
      out.problem.coupled.push_back({term.first_point + p, term.coupled_row + p, term.points.x[p]});
  }
}

SparseMatrix stacked(const std::vector<ContactTerm>& terms, const StateLayout& layout, int n_rows) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& term : terms) {
    const SparseMatrix g = restrict_columns(term.points.g, layout);
    for (int r = 0; r < g.rows(); ++r)
      for (SparseMatrix::InnerIterator it(g, r); it; ++it)
        if (it.value() != 0.0)
          entries.emplace_back(term.first_row + r, static_cast<int>(it.col()), it.value());
  }
  SparseMatrix out(n_rows, layout.n_state);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// Unknowns with a non-zero column of G, or all of them.
void choose_unknowns(Contact& out, int n_unknowns) {
  std::vector<char> touched(n_unknowns, 0);
  for (int r = 0; r < out.g.rows(); ++r)
    for (SparseMatrix::InnerIterator it(out.g, r); it; ++it)
      if (it.col() < n_unknowns) touched[it.col()] = 1;
  const auto count = static_cast<int>(std::count(touched.begin(), touched.end(), 1));
  out.whole = count > most_condensed ||
              (count > always_condensed && count > most_condensed_share * n_unknowns);
  for (int i = 0; i < n_unknowns; ++i)
    if (out.whole || touched[i] != 0) out.unknowns.push_back(i);
}

/// The columns of G on the contact unknowns, and G^T W on all unknowns.
void restrict_to_unknowns(Contact& out, int n_unknowns) {
  std::vector<int> position(n_unknowns, -1);
  for (std::size_t c = 0; c < out.unknowns.size(); ++c)
    position[out.unknowns[c]] = static_cast<int>(c);
  std::vector<Eigen::Triplet<double>> columns, forces;
  for (const auto& point : out.problem.points)
    for (int r = point.first_row; r < point.first_row + point.rows; ++r)
      for (SparseMatrix::InnerIterator it(out.g, r); it; ++it) {
        const auto col = static_cast<int>(it.col());
        if (col >= n_unknowns) continue;
        columns.emplace_back(r, position[col], it.value());
        forces.emplace_back(col, r, point.weight * it.value());
      }
  out.problem.g.resize(out.g.rows(), static_cast<Eigen::Index>(out.unknowns.size()));
  out.problem.g.setFromTriplets(columns.begin(), columns.end());
  out.force.resize(n_unknowns, out.g.rows());
  out.force.setFromTriplets(forces.begin(), forces.end());
}

} // namespace

Contact make_contact(const Problem& problem, const Discretisation& d, const StateLayout& layout) {
  Contact out;
  const double t = problem.time.is_static ? 0.0 : problem.time.grid.front();
  make_laws(problem, out);
  out.scales.assign(out.laws.size(), 0.0);
  out.softening.assign(out.laws.size(), 0.0);
  int n_rows = 0;
  for (std::size_t l = 0; l < problem.law_terms.size(); ++l) {
    const auto& spec = problem.law_terms[l];
    ContactTerm term{assemble_law(d.space, d.parts[spec.part], spec, static_cast<int>(l),
                                  out.laws[spec.law]->spec().radial),
                     spec.field,
                     static_cast<int>(out.problem.points.size()),
                     n_rows,
                     -1,
                     {}};
    add_points(problem, out, term, t);
    n_rows += term.n_rows();
    if (term.n_points() > 0) {
      const auto numbers = out.laws[spec.law]->constants(term.points.x[0], t);
      out.scales[spec.law] = std::max(out.scales[spec.law], numbers.slope_scale);
      out.softening[spec.law] =
          std::max(out.softening[spec.law], softening(*out.laws[spec.law], term, problem.time));
    }
    out.terms.push_back(std::move(term));
    auto& others = out.other_fields;
    if (spec.field != field_of_u(0) && std::ranges::find(others, spec.field) == others.end())
      others.push_back(spec.field);
  }
  couple(problem, out);
  out.g = stacked(out.terms, layout, n_rows);
  out.offset = out.problem.offset = Vector::Zero(n_rows);
  choose_unknowns(out, layout.n_unknowns);
  restrict_to_unknowns(out, layout.n_unknowns);
  return out;
}

void LawFields::add(int field, double factor, Vector value) {
  others_.push_back({field, factor, std::move(value)});
}

const LawFields::Other& LawFields::other(int field) const {
  return *std::ranges::find(others_, field, &Other::field);
}

const Vector& LawFields::operator[](int field) const {
  return field == field_of_u(0) ? u_ : other(field).value;
}

double LawFields::factor(int field) const {
  return field == field_of_u(0) ? 1.0 : other(field).factor;
}

std::vector<double> law_factors(const Contact& contact, const Vector& of_fields) {
  if (contact.other_fields.empty()) return {};
  std::vector<double> out;
  for (const auto& term : contact.terms) out.push_back(of_fields[term.field]);
  return out;
}

void add_arguments(const Contact& contact, const LawFields& fields, Vector& z) {
  for (const auto& term : contact.terms)
    z.segment(term.first_row, term.n_rows()).noalias() +=
        contact.g.middleRows(term.first_row, term.n_rows()) * fields[term.field];
}

void prepare(Contact& contact, const Problem& problem, double t, const LawFields& known,
             const Vector& xi) {
  for (auto& term : contact.terms) {
    const auto& spec = problem.law_terms[term.points.law_term];
    Vector& values = term.offsets;
    law_offsets(term.points, spec, t, values);
    contact.offset.segment(term.first_row, term.n_rows()) = values;
    const auto& law = *contact.laws[spec.law];
    if (!law.depends_on_t()) continue;
    for (int p = 0; p < term.n_points(); ++p) {
      const int graph = contact.problem.points[term.first_point + p].graph;
      if (p == 0 || law.depends_on_x())
        contact.problem.graphs[graph] =
            law.graph(term.points.x[p], {t, term.coupled_row < 0 ? 0.0 : xi[term.coupled_row + p]});
    }
  }
  contact.problem.t = t;
  auto& offset = contact.problem.offset;
  auto& size = contact.problem.offset_size;
  offset = contact.offset;
  add_arguments(contact, known, offset);
  size = contact.offset.cwiseAbs();
  for (const auto& term : contact.terms) {
    const Vector& field = known[term.field];
    for (int row = term.first_row; row < term.first_row + term.n_rows(); ++row)
      for (SparseMatrix::InnerIterator it(contact.g, row); it; ++it)
        size[row] += std::abs(it.value() * field[it.col()]);
  }
}

void arguments_of(const Contact& contact, const Problem& problem, double t, const LawFields& fields,
                  Vector& z) {
  z.setZero(contact.n_rows());
  add_arguments(contact, fields, z);
  Vector offsets;
  for (const auto& term : contact.terms) {
    law_offsets(term.points, problem.law_terms[term.points.law_term], t, offsets);
    z.segment(term.first_row, term.n_rows()) += offsets;
  }
}

std::array<double, 3> global_multiplier(const ContactTerm& term, const Vector& xi, int point) {
  std::array<double, 3> out{};
  const int rows = term.points.rows;
  const auto values = xi.segment(term.first_row + point * rows, rows);
  if (term.points.frames.empty()) {
    out[0] = values[0];
    return out;
  }
  const Vector global = term.points.frames[point] * values;
  for (int i = 0; i < std::min<int>(3, static_cast<int>(global.size())); ++i) out[i] = global[i];
  return out;
}

} // namespace hvi::solver
