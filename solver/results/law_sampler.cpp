// See law_sampler.hpp.
#include "solver/results/law_sampler.hpp"

#include "solver/assembly/point_form.hpp"
#include "solver/discrete/fields_read.hpp"
#include "solver/fem/highest_order.hpp"
#include "solver/plan/membership.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace hvi::solver {
namespace {

using slot::is_multiplier, slot::row_of, slot::term_of;

/// Where a multiplier or a state is known: the number of a law term, or behind these that of a
/// group of states in a body; -1: it is neither.
int place_of(const Contact& contact, Slot s) {
  if (is_multiplier(s)) return term_of(s);
  if (!slot::is_state(s)) return -1;
  for (std::size_t g = 0; g < contact.state_groups.size(); ++g) {
    const auto& group = contact.state_groups[g];
    if (std::ranges::find(group.states, s - slot::first_state) != group.states.end())
      return group.body ? static_cast<int>(contact.terms.size() + g) : group.host;
  }
  return -1;
}
/// All of them, once each.
std::vector<int> places_of(const Contact& contact, std::span<const Slot> slots) {
  std::vector<int> out;
  for (const Slot s : slots)
    if (const int place = place_of(contact, s); place >= 0 && !std::ranges::count(out, place))
      out.push_back(place);
  return out;
}
const BodyPoints* body_at(const Contact& contact, int place) {
  const int group = place - static_cast<int>(contact.terms.size());
  return group < 0 ? nullptr : contact.state_groups[static_cast<std::size_t>(group)].body.get();
}
const LawPoints& points_at(const Contact& contact, int place) {
  const BodyPoints* const body = body_at(contact, place);
  return body != nullptr ? body->points : contact.terms[static_cast<std::size_t>(place)].points;
}
const LawTerm& term_at(const Problem& problem, const Contact& contact, int place) {
  const BodyPoints* const body = body_at(contact, place);
  return body != nullptr ? body->term : problem.law_terms[static_cast<std::size_t>(place)];
}

/// A law that does nothing, to have the points of a part: those of the highest order.
LawTerm no_law(Origin origin, const Space& space) {
  LawTerm out;
  out.rule_of = unknown_of_highest_order(space);
  out.origin = origin;
  out.part = -1;
  out.rows.resize(1);
  out.rows.front().u[0] = 1.0;
  return out;
}

/// Of a body's points a midpoint may be enough; a boundary has values of u, too.
LawTerm on_boundary(LawTerm body, const Region& region) {
  if (region.kind == Group::Kind::facets) body.rule = Rule::gauss;
  return body;
}

/// First and last (exclusive) of a body's points in a cell: they stand cell by cell.
std::pair<int, int> points_in(const LawPoints& body, std::int32_t cell) {
  const auto [first, last] = std::equal_range(body.cell.begin(), body.cell.end(), cell);
  return {static_cast<int>(first - body.cell.begin()), static_cast<int>(last - body.cell.begin())};
}
bool has_cell(const LawPoints& body, std::int32_t cell) {
  return std::binary_search(body.cell.begin(), body.cell.end(), cell);
}

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Does a closed cell contain a point, but for rounding?
bool contains(const Mesh& mesh, int cell, const Point& x) {
  constexpr double outside = -1e-9;
  const auto at = barycentric_in_cell(mesh, cell, x);
  return std::all_of(at.begin(), at.begin() + mesh.dim + 1, [](double b) { return b >= outside; });
}

/// "; the nearest is (1, 0)", for the points at a few of which there is something.
std::string nearest_to(const LawPoints& points, const Point& place, int dim) {
  const auto nearest =
      std::ranges::min_element(points.x, {}, [&](const Point& x) { return distance(x, place); });
  if (points.kind == Group::Kind::cells || nearest == points.x.end()) return {};
  return fmt::format("; the nearest is {}", describe_point(*nearest, dim));
}

/// The points of a law at a place; those of a body in the cells there.
std::vector<int> points_near(const Mesh& mesh, const LawPoints& points, const Point& place) {
  std::vector<int> out;
  const double near = 1e-6 * mesh_quality(mesh).shortest_edge;
  for (int p = 0; p < static_cast<int>(points.x.size()); ++p)
    if (points.kind == Group::Kind::cells ? contains(mesh, points.cell[p], place)
                                          : distance(points.x[p], place) <= near)
      out.push_back(p);
  return out;
}

bool is_of_same_law(const LawTerm& a, const LawTerm& b) {
  return a.law == b.law && a.name == b.name && a.rows.size() == b.rows.size();
}

/// Multipliers of a law that acts on several parts: those of the first that has the place, where
/// the one that is written has not.
Expr at_parts_of(const Problem& problem, const Mesh& mesh, const Contact& contact,
                 const Expr& expression, const Point& place) {
  std::vector<std::pair<Slot, Expr>> there;
  const auto is_there = [&](std::size_t term) {
    return !points_near(mesh, contact.terms[term].points, place).empty();
  };
  for (const Slot s : slots_of(expression)) {
    if (!is_multiplier(s) || is_there(static_cast<std::size_t>(term_of(s)))) continue;
    const LawTerm& written = problem.law_terms[static_cast<std::size_t>(term_of(s))];
    for (std::size_t k = 0; k < problem.law_terms.size(); ++k) {
      if (!is_of_same_law(problem.law_terms[k], written) || !is_there(k)) continue;
      there.emplace_back(s, Expr::variable(slot::multiplier(static_cast<int>(k), row_of(s))));
      break;
    }
  }
  return substitute(expression, there);
}

} // namespace

Expr away_from_states(const Problem& problem, Expr expression) {
  for (std::size_t i = 0; i < problem.states.size(); ++i)
    if (expression.depends_on(slot::state(static_cast<int>(i))))
      expression = away_from(expression, problem.states[i].part);
  return expression;
}

std::vector<int> parts_of_states(const Problem& problem, const Contact& contact,
                                 std::span<const Expr> expressions) {
  std::vector<int> out;
  for (const int place : places_of(contact, Pointwise(expressions).inputs()))
    if (body_at(contact, place) != nullptr) out.push_back(term_at(problem, contact, place).part);
  return out;
}

std::vector<std::vector<Expr>> on_parts_of_laws(const Problem& problem,
                                                std::span<const Expr> expressions) {
  std::set<Slot> read;
  for (const Expr& e : expressions)
    for (const Slot s : slots_of(e))
      if (is_multiplier(s)) read.insert(s);
  const auto& terms = problem.law_terms;
  std::vector<std::vector<Expr>> out;
  std::set<int> seen;
  for (const LawTerm& first : terms) {
    if (!seen.insert(first.part).second) continue;
    std::vector<std::pair<Slot, Expr>> here;
    for (const Slot s : read) {
      const LawTerm& written = terms[static_cast<std::size_t>(term_of(s))];
      const auto found = std::ranges::find_if(terms, [&](const LawTerm& one) {
        return one.part == first.part && is_of_same_law(one, written);
      });
      if (found == terms.end()) break;
      here.emplace_back(
          s, Expr::variable(slot::multiplier(static_cast<int>(found - terms.begin()), row_of(s))));
    }
    if (read.empty() || here.size() < read.size()) continue;
    auto& all = out.emplace_back();
    for (const Expr& e : expressions) all.push_back(substitute(e, here));
  }
  if (out.empty()) out.emplace_back(expressions.begin(), expressions.end());
  return out;
}

bool lives_in_bodies(const Contact& contact, std::span<const Expr> expressions) {
  return std::ranges::all_of(places_of(contact, Pointwise(expressions).inputs()),
                             [&](int place) { return body_at(contact, place) != nullptr; });
}

LawSampler::LawSampler(const Problem& problem, const Contact& contact,
                       std::vector<Expr> expressions, Origin origin)
    : expressions_(expressions), origin_(origin) {
  for (const int place : places_of(contact, expressions_.inputs())) {
    const auto needed = [&](Slot s) {
      return std::ranges::any_of(expressions, [&](const Expr& e) {
        const bool state = slot::is_state(s) && body_at(contact, place) != nullptr;
        return (state ? away_from(e, term_at(problem, contact, place).part) : e).depends_on(s);
      });
    };
    if (std::ranges::none_of(expressions_.inputs(),
                             [&](Slot s) { return place_of(contact, s) == place && needed(s); }))
      guarded_.insert(place);
  }
}

LawSampler::LawSampler(const Problem& problem, const Discretisation& d, const Contact& contact,
                       std::vector<Expr> expressions, Origin origin, int part)
    : LawSampler(problem, contact, std::move(expressions), origin) {
  // Laws before bodies, whose states are found from the points of a law, too.
  const auto rank = [&](int place) {
    const bool there = term_at(problem, contact, place).part == part;
    return 2 * static_cast<int>(!there) + static_cast<int>(body_at(contact, place) != nullptr);
  };
  for (const int place : places_of(contact, expressions_.inputs()))
    if (place_ < 0 || rank(place) < rank(place_)) place_ = place;
  const LawTerm none = no_law(origin, d.space);
  const auto& term = place_ < 0 ? none : term_at(problem, contact, place_);
  part_ = part >= 0 ? part : term.part;
  in_body_ = place_ >= 0 && body_at(contact, place_) != nullptr;
  LawPoints other;
  if (place_ < 0)
    other = assemble_law(d.space, d.parts[part], term, -1, false);
  else if (part_ != term.part)
    other = assemble_law(d.space, d.parts[part], in_body_ ? on_boundary(term, d.parts[part]) : term,
                         place_, !points_at(contact, place_).frames.empty());
  const auto& points = other.x.empty() ? points_at(contact, place_) : other;
  std::vector<int> all(points.x.size());
  std::iota(all.begin(), all.end(), 0);
  take_points(points, term, all);
  match_all(d, contact);
}

std::optional<LawSampler> LawSampler::at(const Problem& problem, const Discretisation& d,
                                         const Contact& contact, const Expr& written, Origin origin,
                                         const Point& place) {
  const Expr expression = at_parts_of(problem, d.mesh, contact, written, place);
  LawSampler out(problem, contact, {expression}, origin);
  auto places = places_of(contact, out.expressions_.inputs());
  // First those without which there is no value; of them laws before bodies.
  const auto rank = [&](int known) {
    return 2 * static_cast<int>(out.guarded_.contains(known)) +
           static_cast<int>(body_at(contact, known) != nullptr);
  };
  std::ranges::stable_sort(places, {}, rank);
  const auto lacks = [&](int known) {
    return points_near(d.mesh, points_at(contact, known), place).empty();
  };
  out.place_ = places.front();
  if (out.guarded_.contains(out.place_)) {
    const auto there = std::ranges::find_if_not(places, lacks);
    if (there == places.end()) return std::nullopt;
    out.place_ = *there;
  }
  const auto& points = points_at(contact, out.place_);
  const LawTerm& term = term_at(problem, contact, out.place_);
  out.part_ = term.part;
  out.in_body_ = body_at(contact, out.place_) != nullptr;
  out.take_place(d, contact, points, term, place,
                 out.in_body_ ? "ask inside its part, or for an integral"
                              : "ask at a node of the contact part, or for an integral");
  return out;
}

/// Keeps the points at one place.
void LawSampler::take_place(const Discretisation& d, const Contact& contact,
                            const LawPoints& points, const LawTerm& term, const Point& place,
                            const std::string& help) {
  const auto chosen = points_near(d.mesh, points, place);
  if (chosen.empty())
    throw Failure(
        FailureKind::bad_value, origin_,
        fmt::format("what lives at the points of `{}` is known there only, and {} is none of "
                    "them{}",
                    term.name, describe_point(place, d.mesh.dim),
                    nearest_to(points, place, d.mesh.dim)),
        help);
  take_points(points, term, chosen);
  const double total = std::accumulate(block_.weight.begin(), block_.weight.end(), 0.0);
  for (auto& weight : block_.weight) weight /= total;
  match_all(d, contact);
}

LawSampler LawSampler::at_pair(const Problem& problem, const Discretisation& d,
                               const Contact& contact, const Probe& probe) {
  LawTerm none = no_law(probe.origin, d.space);
  std::optional<LawSampler> out;
  for (int part = 0; part < static_cast<int>(d.parts.size()); ++part) {
    const Region& region = d.parts[static_cast<std::size_t>(part)];
    if (!region.is_pair() || (probe.part >= 0 && part != probe.part)) continue;
    none.name = problem.parts[static_cast<std::size_t>(part)].name;
    const LawPoints points = assemble_law(d.space, region, none, -1, false);
    if (probe.part < 0 && points_near(d.mesh, points, probe.point).empty()) continue;
    if (out && out->part_ != part &&
        d.parts[static_cast<std::size_t>(out->part_)].second != region.second)
      throw Failure(
          FailureKind::bad_value, probe.origin,
          fmt::format("{} is a point of two pairs", describe_point(probe.point, d.mesh.dim)),
          "say which by `gap(..)`, or take an integral");
    out.emplace(problem, d, contact, std::vector<Expr>{probe.expression}, probe.origin, part);
    out->take_place(d, contact, points, none, probe.point,
                    "ask at a node of the pair's first side, or for an integral");
  }
  if (!out)
    throw Failure(FailureKind::bad_value, probe.origin,
                  fmt::format("{} is no point of a pair", describe_point(probe.point, d.mesh.dim)),
                  "ask at a node of the pair's first side, or for an integral");
  return std::move(*out);
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
    if (points.jump) block_.gap.push_back(points.gap[static_cast<std::size_t>(p)]);
    if (points.jump) block_.pair_point.push_back(p);
    nodes_.push_back(points.node[p]);
  }
  block_.kind = points.kind;
  block_.jump = points.jump;
  block_.indicators = points.indicators;
  const std::vector<Expr> factor{term.factor};
  values_.assign(std::max<std::size_t>(block_.size(), 1), 0.0);
  Pointwise(factor).evaluate(block_, 0.0, term.origin, values_);
  for (std::size_t p = 0; p < block_.size(); ++p) block_.weight[p] /= values_[p];
}

/// All that our expressions read, at our points.
void LawSampler::match_all(const Discretisation& d, const Contact& contact) {
  const auto places = places_of(contact, expressions_.inputs());
  for (const int place : places)
    if (body_at(contact, place) != nullptr && !guarded_.contains(place))
      go_to_cells(d.mesh, points_at(contact, place));
  for (const int place : places) match(contact, place, d.mesh.dim);
  for (const auto s : expressions_.inputs())
    if (slot::is_field(s)) prepare_field(d.space, s);
}

/// Facets within the mesh whose cell has no states of the body are read from the other side.
void LawSampler::go_to_cells(const Mesh& mesh, const LawPoints& body) {
  if (block_.kind != Group::Kind::facets) return;
  for (std::size_t p = 0; p < block_.size(); ++p) {
    const std::int32_t other = mesh.facets[static_cast<std::size_t>(block_.entity[p])].other;
    if (!has_cell(body, block_.cell[p]) && has_cell(body, other)) block_.cell[p] = other;
  }
}

/// The nearest point of a body in the cell of ours, where ours is none of a body; else -1.
int LawSampler::match_in_cell(const Contact& contact, int place, std::size_t p) const {
  if ((in_body_ && block_.kind == Group::Kind::cells) || body_at(contact, place) == nullptr)
    return -1;
  const auto& theirs = points_at(contact, place);
  const auto [first, last] = points_in(theirs, block_.cell[p]);
  int nearest = -1;
  for (int q = first; q < last; ++q)
    if (nearest < 0 ||
        distance(theirs.x[q], block_.point(p)) < distance(theirs.x[nearest], block_.point(p)))
      nearest = q;
  return nearest;
}

/// Finds for each of our points the one of another place where it is, with the same normal; -1:
/// none, and none is needed.
void LawSampler::match(const Contact& contact, int place, int dim) {
  const auto& theirs = points_at(contact, place);
  std::map<Point, std::vector<int>> by_place;
  for (int p = 0; p < static_cast<int>(theirs.x.size()); ++p) by_place[theirs.x[p]].push_back(p);
  auto cells = theirs.cell;
  std::ranges::sort(cells);
  std::vector<int> found;
  for (std::size_t p = 0; p < block_.size(); ++p) {
    const Point normal{block_.normal[0][p], block_.normal[1][p], block_.normal[2][p]};
    const auto there = by_place.find(block_.point(p));
    if (there != by_place.end())
      for (const int candidate : there->second)
        if (found.size() == p && distance(theirs.normal[candidate], normal) <= 1e-9)
          found.push_back(candidate);
    if (found.size() > p) continue;
    const int near = match_in_cell(contact, place, p);
    if (near < 0 &&
        !(guarded_.contains(place) && !std::ranges::binary_search(cells, block_.cell[p])))
      refuse(contact, place, p, dim);
    found.push_back(near);
  }
  point_of_[place] = std::move(found);
}

void LawSampler::refuse(const Contact& contact, int place, std::size_t p, int dim) const {
  const std::string where = describe_point(block_.point(p), dim);
  if (const BodyPoints* const body = body_at(contact, place))
    throw Failure(
        FailureKind::bad_value, origin_,
        fmt::format("the state `{}` does not live in the cell at {}", body->term.name, where),
        "ask inside its part, or on a boundary of it");
  throw Failure(FailureKind::bad_value, origin_,
                fmt::format("what lives at the points of a law is not known at {}", where),
                "integrate a multiplier over the part where its law acts");
}

/// Rows that take a full vector to the values of a field's derivative at our points.
void LawSampler::prepare_field(const Space& space, Slot s) {
  rows_[s] = derivative_rows(space, block_, slot::derivative_of(s), origin_);
}

void LawSampler::evaluate(const Contact& contact, const Snapshot& snapshot, std::span<double> out) {
  for (const auto s : expressions_.inputs()) {
    if (slot::is_field(s)) {
      columns_[s] = rows_.at(s) * snapshot.field(slot::field_of(s));
    } else if (slot::is_state(s)) {
      auto& column = columns_[s];
      column.resize(size());
      const auto& theirs = point_of_.at(place_of(contact, s));
      const int first = contact.first_state[static_cast<std::size_t>(s - slot::first_state)];
      for (int p = 0; p < size(); ++p)
        column[p] = theirs[p] < 0 ? 0.0 : snapshot.states()[first + theirs[p]];
    } else if (is_multiplier(s)) {
      auto& column = columns_[s];
      column.resize(size());
      const auto& theirs = point_of_.at(term_of(s));
      for (int p = 0; p < size(); ++p)
        column[p] =
            global_multiplier(contact.terms[term_of(s)], snapshot.xi(), theirs[p])[row_of(s)];
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
    const Slot first = slot::multiplier(term, 0);
    if (problem.law_terms[term].part != part &&
        expression.depends_on_any(first, first + slot::most_arguments))
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
    const bool on_region = probe.kind == Probe::Kind::integral ||
                           probe.kind == Probe::Kind::largest ||
                           probe.kind == Probe::Kind::smallest;
    if (on_region && reads_from_elsewhere(plan.problem, e, probe.part))
      collect([&] { LawSampler(plan.problem, d, *contact, {e}, probe.origin, probe.part); });
    if (probe.kind == Probe::Kind::at_point && probe.on_pair)
      collect([&] { LawSampler::at_pair(plan.problem, d, *contact, probe); });
    else if (probe.kind == Probe::Kind::at_point && reads_multiplier(e))
      collect([&] { LawSampler::at(plan.problem, d, *contact, e, probe.origin, probe.point); });
  }
  for (const FieldsSpec& fields : plan.report.fields)
    for (const FieldSpec& field : fields.fields)
      if (plan.problem.law_terms.size() > 1 &&
          std::ranges::any_of(field.components, reads_multiplier))
        collect([&] {
          for (auto& here : on_parts_of_laws(plan.problem, field.components))
            LawSampler(plan.problem, d, *contact, std::move(here), field.origin);
        });
  return failures;
}

} // namespace hvi::solver
