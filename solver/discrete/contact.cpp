// The laws of a plan as the reduced problem of one step; see contact.hpp.
#include "solver/discrete/contact.hpp"

#include "solver/discrete/certificate.hpp"
#include "solver/discrete/contact_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace hvi::solver {
namespace {

void make_laws(const Problem& problem, Contact& out) {
  for (const auto& spec : problem.laws) out.laws.push_back(std::make_unique<Law>(spec));
  for (const auto& law : out.laws) out.problem.laws.push_back(law.get());
}

/// Points of all terms, with a graph each, or one per law that is the same everywhere.
void add_points(const Problem& problem, Contact& out, const ContactTerm& term, double t) {
  const int law = problem.law_terms[term.points.law_term].law;
  const auto& graph_of = *out.laws[law];
  const auto times = initial_law_times(problem, graph_of, term.points, t, term.first_readings);
  auto& inequality = out.problem;
  for (int p = 0; p < term.n_points(); ++p) {
    if (p == 0 || graph_of.depends_on_x())
      inequality.graphs.push_back(graph_of.graph(term.points.x[p], times[p]));
    inequality.points.push_back({law, term.points.law_term, term.first_row + p * term.points.rows,
                                 term.points.rows, term.points.weight[p],
                                 static_cast<int>(inequality.graphs.size()) - 1});
  }
}

bool have_same_row(const LawPoints& points, int a, int b) {
  if (!points.frames.empty() && points.frames[a] != points.frames[b]) return false;
  for (int c = 0; c < points.rows; ++c) {
    SparseMatrix::InnerIterator x(points.g, a * points.rows + c), y(points.g, b * points.rows + c);
    for (; x && y; ++x, ++y)
      if (x.col() != y.col() || x.value() != y.value()) return false;
    if (x || y) return false;
  }
  return true;
}

/// Points at one node with the same argument, as where facets meet at an angle under a law on u.y.
/// Of a law with a jump they may share their force in any way: the graph's sets are convex.
std::vector<std::vector<int>> points_alike(const LawTerm& spec, const Law& law,
                                           const LawPoints& points) {
  const auto reads_normal = [](const LawTerm::Row& row) {
    return row.offset.depends_on_any(slot::normal(0), slot::normal(2) + 1);
  };
  if (law.reads() || points.jump || std::ranges::any_of(spec.rows, reads_normal)) return {};
  std::unordered_map<std::int32_t, std::vector<int>> at_node;
  for (int p = 0; p < std::ssize(points.x); ++p)
    if (points.node[p] >= 0) at_node[points.node[p]].push_back(p);
  std::vector<std::vector<int>> out;
  for (const auto& [node, here] : at_node)
    for (const int p : here) {
      if (here.size() == 1) continue;
      out.resize(points.x.size());
      for (const int other : here)
        if (have_same_row(points, p, other)) out[p].push_back(other);
    }
  return out;
}

/// The steepest descent of a law's slope; of one that depends on place or time, over a sample.
double softening(const Problem& problem, const Law& law, const ContactTerm& term) {
  const TimeSpec& time = problem.time;
  constexpr int most = 16;
  const int stride = law.depends_on_x() ? std::max(1, term.n_points() / most) : term.n_points();
  auto times = initial_law_times(problem, law, term.points, 0.0, term.first_readings);
  double out = 0;
  for (int p = 0; p < term.n_points(); p += stride)
    for (const double part : {0.0, 0.5, 1.0}) {
      if (part > 0 && (!law.depends_on_t() || time.is_static)) break;
      if (!time.is_static)
        times[p].t = time.grid.front() + part * (time.grid.back() - time.grid.front());
      out = std::max(out, law.constants(term.points.x[p], times[p]).m);
    }
  return out;
}

/// What a law reads of the initial state; of multipliers, rates and memories nothing is known then.
std::vector<Readings> first_readings(const Problem& problem, const Discretisation& d,
                                     const StateLayout& layout, LawReadings& readings,
                                     std::size_t points) {
  const Vector u = initial_state(problem, d, layout);
  LawFields fields(u);
  for (const int field : readings.fields())
    if (field != field_of_u(0)) fields.add(field, 0.0, Vector::Zero(u.size()));
  readings.read(problem.time.is_static ? 0.0 : problem.time.grid.front(), fields,
                [](int, int, int) { return 0.0; });
  std::vector<Readings> out;
  for (std::size_t p = 0; p < points; ++p) out.push_back(readings.at(static_cast<int>(p)));
  return out;
}

/// Throws Failure(bad_law) where a law reads the multiplier of one at other points.
void check_readings(const Problem& problem, const Contact& contact) {
  for (const auto& term : contact.terms) {
    const auto& spec = problem.law_terms[term.points.law_term];
    for (const int other : terms_read(problem.laws[spec.law]))
      if (contact.terms[static_cast<std::size_t>(other)].points.x != term.points.x)
        throw Failure(FailureKind::bad_law, spec.origin,
                      fmt::format("`{}` reads the multiplier of `{}`, which does not act at its "
                                  "points",
                                  spec.name,
                                  problem.law_terms[static_cast<std::size_t>(other)].name),
                      "put both on the same part with the same rule");
  }
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

} // namespace

const LawPoints& points_of(const Contact& contact, const StateGroup& group) {
  return group.body ? group.body->points
                    : contact.terms[static_cast<std::size_t>(group.host)].points;
}

Contact make_contact(const Problem& problem, const Discretisation& d, const StateLayout& layout,
                     bool keep_all) {
  Contact out;
  const double t = problem.time.is_static ? 0.0 : problem.time.grid.front();
  make_laws(problem, out);
  out.scales.assign(out.laws.size(), 0.0);
  out.softening.assign(out.laws.size(), 0.0);
  int n_rows = 0;
  for (std::size_t l = 0; l < problem.law_terms.size(); ++l) {
    const auto& spec = problem.law_terms[l];
    const Law& law = *out.laws[spec.law];
    ContactTerm term{assemble_law(d.space, d.parts[spec.part], spec, static_cast<int>(l),
                                  law.spec().radial, law.reads()),
                     spec.field,
                     static_cast<int>(out.problem.points.size()),
                     n_rows,
                     -1,
                     {},
                     false,
                     {},
                     {}};
    if (law.reads()) {
      out.readings.emplace_back(law.spec(), spec.law, term.points, layout);
      term.first_readings =
          first_readings(problem, d, layout, out.readings.back(), term.points.x.size());
    }
    add_points(problem, out, term, t);
    if (spec.rule == Rule::nodal) term.alike = points_alike(spec, law, term.points);
    n_rows += term.n_rows();
    if (term.n_points() > 0) {
      const auto numbers = out.laws[spec.law]->constants(
          term.points.x[0],
          initial_law_times(problem, law, term.points, t, term.first_readings).front());
      out.scales[spec.law] = std::max(out.scales[spec.law], numbers.slope_scale);
      if (law.reads()) out.readings.back().first_scale = numbers.slope_scale;
      out.softening[spec.law] =
          std::max(out.softening[spec.law], softening(problem, *out.laws[spec.law], term));
    }
    auto& others = out.other_fields;
    const auto needs = [&](int field) {
      if (field != field_of_u(0) && std::ranges::find(others, field) == others.end())
        others.push_back(field);
    };
    needs(spec.field);
    for (const auto& row : spec.seen)
      for (const SeenField& seen : row) needs(seen.field);
    if (law.reads())
      for (const int field : out.readings.back().fields()) needs(field);
    out.mixed = out.mixed || term.mixed();
    out.terms.push_back(std::move(term));
  }
  couple(problem, out);
  check_readings(problem, out);
  add_states(problem, d, layout, out);
  for (ContactTerm& term : out.terms) // states live at points with a normal each
    if (!term.first_states.empty() || term.offset_of_states) term.alike.clear();
  out.g = stacked(out.terms, layout, n_rows);
  out.offset = out.problem.offset = Vector::Zero(n_rows);
  find_unknowns(problem, d.space, layout, out, keep_all);
  return out;
}

std::vector<double> law_factors(const Contact& contact, const Vector& of_fields) {
  const auto sees_u_once = [](const ContactTerm& term) { return term.points.seen.empty(); };
  if (contact.other_fields.empty() && std::ranges::all_of(contact.terms, sees_u_once)) return {};
  std::vector<double> out;
  for (const auto& term : contact.terms)
    for (int row = 0; row < slot::most_arguments; ++row) {
      double sum = 0.0;
      term.for_seen(std::min(row, term.points.rows - 1),
                    [&](int field, double times) { sum += times * of_fields[field]; });
      out.push_back(sum);
    }
  return out;
}

void add_arguments(const Contact& contact, const LawFields& fields, Vector& z) {
  for (const auto& term : contact.terms) {
    if (term.points.seen.empty()) {
      z.segment(term.first_row, term.n_rows()).noalias() +=
          contact.g.middleRows(term.first_row, term.n_rows()) * fields[term.field];
      continue;
    }
    for (int row = 0; row < term.n_rows(); ++row)
      term.for_seen(row % term.points.rows, [&](int field, double times) {
        z[term.first_row + row] += times * contact.g.row(term.first_row + row).dot(fields[field]);
      });
  }
}

void read_solution(Contact& contact, double t, const LawFields& fields, const Vector& xi) {
  const auto multiplier = [&](int term, int component, int point) {
    return global_multiplier(contact.terms[static_cast<std::size_t>(term)], xi,
                             point)[static_cast<std::size_t>(component)];
  };
  const auto size = [&](int term) {
    return multiplier_scale(contact, contact.terms[static_cast<std::size_t>(term)], fields, xi);
  };
  for (LawReadings& readings : contact.readings) {
    readings.read(t, fields, multiplier);
    double& scale = contact.scales[static_cast<std::size_t>(readings.law())];
    scale = std::max(readings.first_scale, readings.slope_scale(fields, contact.reach, size));
  }
}

void offsets_of(const Contact& contact, const Problem& problem, const ContactTerm& term, double t,
                const Vector& states, Vector& out) {
  const auto& spec = problem.law_terms[term.points.law_term];
  law_offsets(term.points, spec, t, out, [&](Slot s) -> const double* {
    if (!slot::is_state(s)) return nullptr;
    return states.data() + contact.first_state[s - slot::first_state];
  });
}

namespace {

/// When the law of point p is asked.
LawTime law_time(const Contact& contact, const ContactTerm& term, int p, double t, const Vector& xi,
                 const LawReadings* readings) {
  LawTime out(t, term.coupled_row < 0 ? 0.0 : xi[term.coupled_row + p],
              readings ? readings->at(p) : Readings{});
  for (std::size_t k = 0; k < term.first_states.size(); ++k)
    out.states[k] = contact.state_values[term.first_states[k] + p];
  return out;
}

} // namespace

void prepare(Contact& contact, const Problem& problem, double t, const LawFields& known,
             const Vector& xi, const Vector* moved) {
  auto read = contact.readings.begin();
  for (auto& term : contact.terms) {
    const auto& spec = problem.law_terms[term.points.law_term];
    Vector& values = term.offsets;
    offsets_of(contact, problem, term, t, contact.state_values, values);
    contact.offset.segment(term.first_row, term.n_rows()) = values;
    const auto& law = *contact.laws[spec.law];
    if (!law.depends_on_t()) continue;
    const LawReadings* readings = law.reads() ? &*read++ : nullptr;
    for (int p = 0; p < term.n_points(); ++p) {
      const int graph = contact.problem.points[term.first_point + p].graph;
      if (p == 0 || law.depends_on_x())
        contact.problem.graphs[graph] =
            law.graph(term.points.x[p], law_time(contact, term, p, t, xi, readings));
    }
  }
  auto& offset = contact.problem.offset;
  auto& size = contact.problem.offset_size;
  offset = contact.offset;
  add_arguments(contact, known, offset);
  size = contact.offset.cwiseAbs();
  for (const auto& term : contact.terms)
    for (int row = term.first_row; row < term.first_row + term.n_rows(); ++row)
      term.for_seen((row - term.first_row) % term.points.rows, [&](int field, double times) {
        const Vector& values = known[field];
        const double factor = known.factor(field);
        for (SparseMatrix::InnerIterator it(contact.g, row); it; ++it) {
          double all = std::abs(values[it.col()]);
          if (it.col() < contact.force.rows()) // no imposed value
            all += std::abs(factor) *
                   contact.least_reach[contact.unknown_of(static_cast<int>(it.col()))];
          if (moved != nullptr && it.col() < moved->size())
            all += std::abs(factor * (*moved)[it.col()]);
          size[row] += std::abs(times * it.value()) * all;
        }
      });
}

void arguments_of(const Contact& contact, const Problem& problem, double t, const LawFields& fields,
                  Vector& z) {
  z.setZero(contact.n_rows());
  add_arguments(contact, fields, z);
  Vector offsets;
  for (const auto& term : contact.terms) {
    offsets_of(contact, problem, term, t, contact.state_values, offsets);
    z.segment(term.first_row, term.n_rows()) += offsets;
  }
}

std::array<double, slot::most_arguments> global_multiplier(const ContactTerm& term,
                                                           const Vector& xi, int point) {
  std::array<double, slot::most_arguments> out{};
  const int rows = term.points.rows;
  const auto of_point = [&](int p) { return xi.segment(term.first_row + p * rows, rows); };
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, slot::most_arguments, 1> values = of_point(point);
  if (!term.alike.empty() && term.alike[point].size() > 1) {
    double weight = 0.0;
    values.setZero();
    for (const int p : term.alike[point]) {
      values += term.points.weight[p] * of_point(p);
      weight += term.points.weight[p];
    }
    values /= weight;
  }
  if (term.points.frames.empty()) {
    out[0] = values[0];
    return out;
  }
  const DenseMatrix& frame = term.points.frames[point];
  Eigen::Map<Vector>(out.data(), frame.rows()) = frame * values;
  return out;
}

} // namespace hvi::solver
