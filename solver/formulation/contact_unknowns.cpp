// Which unknowns are kept with the laws; see contact.hpp.
#include "solver/discrete/contact.hpp"
#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace hvi::solver {
namespace {

// Beyond these the dense Schur complement (n_c^2 doubles, n_c^3 / 3 operations) does not pay.
constexpr int most_condensed = 12000;
constexpr int always_condensed = 300;
constexpr double most_condensed_share = 0.3;

/// Rows on states, in the unknowns that are eliminated: in `room`, or as they are.
const SparseMatrix& in_changed(const Contact& contact, const SparseMatrix& rows,
                               SparseMatrix& room) {
  if (!contact.change) return rows;
  room = contact.change->columns(rows);
  return room;
}

/// Unknowns with a non-zero column of G, what laws and rates of states read, or all of them.
void choose_unknowns(Contact& out, int n_unknowns, bool keep_all) {
  std::vector<char> touched(n_unknowns, 0);
  const auto touch = [&](const SparseMatrix& rows) {
    for (int r = 0; r < rows.rows(); ++r)
      for (SparseMatrix::InnerIterator it(rows, r); it; ++it)
        if (it.col() < n_unknowns) touched[it.col()] = 1;
  };
  SparseMatrix room;
  touch(in_changed(out, out.g, room));
  for (const auto& readings : out.readings) touch(in_changed(out, readings.trace(), room));
  touch(in_changed(out, out.trace, room));
  out.unknowns.clear();
  const auto count = static_cast<int>(std::count(touched.begin(), touched.end(), 1));
  out.whole = (keep_all && !out.none()) || count > most_condensed ||
              (count > always_condensed && count > most_condensed_share * n_unknowns);
  for (int i = 0; i < n_unknowns; ++i)
    if (out.whole || touched[i] != 0) out.unknowns.push_back(i);
}

/// The columns of G on the contact unknowns.
void restrict_to_unknowns(Contact& out, int n_unknowns) {
  std::vector<int> position(n_unknowns, -1);
  for (std::size_t c = 0; c < out.unknowns.size(); ++c)
    position[out.unknowns[c]] = static_cast<int>(c);
  const auto restricted = [&](const SparseMatrix& all) {
    std::vector<Eigen::Triplet<double>> entries;
    SparseMatrix room;
    const SparseMatrix& rows = in_changed(out, all, room);
    for (int r = 0; r < rows.rows(); ++r)
      for (SparseMatrix::InnerIterator it(rows, r); it; ++it)
        if (it.col() < n_unknowns) entries.emplace_back(r, position[it.col()], it.value());
    SparseMatrix part(all.rows(), static_cast<Eigen::Index>(out.unknowns.size()));
    part.setFromTriplets(entries.begin(), entries.end());
    return part;
  };
  out.trace_c = restricted(out.trace);
  out.problem.g = restricted(out.g);
  out.problem.of_unknown.clear();
  for (const int i : out.unknowns)
    if (!out.of_unknown.empty())
      out.problem.of_unknown.push_back(out.of_unknown[static_cast<std::size_t>(i)]);
}

/// G^T W on all unknowns.
void find_forces(Contact& out, int n_unknowns) {
  std::vector<Eigen::Triplet<double>> forces;
  for (const auto& point : out.problem.points)
    for (int r = point.first_row; r < point.first_row + point.rows; ++r)
      for (SparseMatrix::InnerIterator it(out.g, r); it; ++it)
        if (it.col() < n_unknowns)
          forces.emplace_back(static_cast<int>(it.col()), r, point.weight * it.value());
  out.force.resize(n_unknowns, out.g.rows());
  out.force.setFromTriplets(forces.begin(), forces.end());
}

/// Those of several unknowns have different units and sizes.
void tell_unknowns_apart(const Space& space, const StateLayout& layout, Contact& out) {
  if (!space.is_product()) return;
  for (int i = 0; i < layout.n_unknowns; ++i) {
    const int component = layout.dof_of[static_cast<std::size_t>(i)] % space.components;
    out.of_unknown.push_back(static_cast<std::uint8_t>(space.block_of(component)));
  }
}

/// A pressure that only contact unknowns see is not known without them: those around contact nodes
/// are kept with them.
void add_multipliers(const Problem& problem, const Space& space, const StateLayout& layout,
                     Contact& out) {
  if (!space.is_product() || out.whole || out.none()) return;
  std::vector<int> unknown_of(static_cast<std::size_t>(space.n_dofs()), -1);
  for (int i = 0; i < layout.n_unknowns; ++i) unknown_of[layout.dof_of[i]] = i;
  std::set<int> all(out.unknowns.begin(), out.unknowns.end());
  const auto multipliers = multipliers_of(problem);
  for (int b = 0; b < n_unknowns(space); ++b) {
    if (multipliers[static_cast<std::size_t>(b)] == 0) continue;
    for (const int c : out.unknowns) {
      const auto node = static_cast<std::size_t>(layout.dof_of[c] / space.components);
      for (auto k = space.graph->offsets[node]; k < space.graph->offsets[node + 1]; ++k) {
        const int dof = space.dof(space.graph->neighbours[k], space.blocks[b].first);
        if (unknown_of[dof] >= 0) all.insert(unknown_of[dof]);
      }
    }
  }
  out.unknowns.assign(all.begin(), all.end());
}

void choose_and_restrict(const Problem& problem, const Space& space, const StateLayout& layout,
                         Contact& out, bool keep_all) {
  choose_unknowns(out, layout.n_unknowns, keep_all);
  add_multipliers(problem, space, layout, out);
  restrict_to_unknowns(out, layout.n_unknowns);
}

} // namespace

void find_unknowns(const Problem& problem, const Space& space, const StateLayout& layout,
                   Contact& contact, bool keep_all) {
  tell_unknowns_apart(space, layout, contact);
  choose_and_restrict(problem, space, layout, contact, keep_all);
  find_forces(contact, layout.n_unknowns);
  contact.loaded = contact.unknowns;
}

void change_unknowns(const Problem& problem, const Space& space, const StateLayout& layout,
                     std::shared_ptr<const BasisChange> change, Contact& contact) {
  contact.change = std::move(change);
  choose_and_restrict(problem, space, layout, contact, false);
}

void contact_part(const Contact& contact, const Vector& d, Vector& c) {
  c.resize(static_cast<Eigen::Index>(contact.unknowns.size()));
  for (Eigen::Index i = 0; i < c.size(); ++i) c[i] = d[contact.unknowns[i]];
  if (!contact.change) return;
  const auto& replaced = contact.change->replaced();
  const auto& inverse = contact.change->inverse();
  Eigen::Index at = 0; // both lists increase
  for (std::size_t r = 0; r < replaced.size(); ++r) {
    while (at < c.size() && contact.unknowns[at] < replaced[r]) ++at;
    if (at == c.size()) return;
    if (contact.unknowns[at] != replaced[r]) continue;
    c[at] = 0.0;
    for (SparseMatrix::InnerIterator it(inverse, static_cast<Eigen::Index>(r)); it; ++it)
      c[at] += it.value() * d[it.col()];
  }
}

bool put_at_rest(const SparseMatrix& k, const Contact& contact, const Vector& rhs, const Vector& xi,
                 Vector& d) {
  std::vector<char> moves(static_cast<std::size_t>(d.size()), 0);
  std::vector<int> reached;
  const auto reach = [&](int i) {
    if (std::exchange(moves[static_cast<std::size_t>(i)], 1) == 0) reached.push_back(i);
  };
  for (int i = 0; i < d.size(); ++i)
    if (rhs[i] != 0.0) reach(i);
  for (const int i : contact.loaded)
    for (SparseMatrix::InnerIterator it(contact.force, i); it; ++it)
      if (it.value() * xi[it.col()] != 0.0) reach(i);
  for (std::size_t at = 0; at < reached.size(); ++at)
    for (SparseMatrix::InnerIterator it(k, reached[at]); it; ++it)
      if (it.value() != 0.0) reach(static_cast<int>(it.col()));
  if (static_cast<Eigen::Index>(reached.size()) == d.size()) return false;
  for (Eigen::Index i = 0; i < d.size(); ++i)
    if (moves[static_cast<std::size_t>(i)] == 0) d[i] = 0.0;
  return true;
}

void put_at_rest(const Pieces& pieces, const Contact& contact, const Vector& rhs, const Vector& xi,
                 Vector& d) {
  Vector acting = rhs.cwiseAbs();
  for (const int i : contact.loaded)
    for (SparseMatrix::InnerIterator it(contact.force, i); it; ++it)
      acting[i] += std::abs(it.value() * xi[it.col()]);
  pieces.leave_at_rest(acting, d);
}

} // namespace hvi::solver
