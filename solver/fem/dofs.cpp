// Free and eliminated degrees of freedom, imposed values, interpolation.
#include "solver/fem/geometry.hpp"
#include "solver/fem/periodic.hpp"
#include "solver/fem/pointwise.hpp"
#include "solver/fem/space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hvi::solver {
namespace {

/// The points of some nodes as a block for a tape.
PointBlock block_of_nodes(const Space& space, std::span<const std::int32_t> nodes) {
  PointBlock block;
  for (const auto node : nodes) {
    for (int j = 0; j < 3; ++j) {
      block.x[j].push_back(space.nodes[node][j]);
      block.normal[j].push_back(0.0);
    }
    block.weight.push_back(1.0);
  }
  return block;
}

double value_at(const Expr& expression, const Point& x, double t) {
  return evaluate(expression, [&](Slot slot) { return slot == slot::t ? t : x[slot]; });
}

/// Whether two imposed values agree, each at its node. Times where a table has no value say
/// nothing; with no time left the values count as different.
bool agree(const Expr& a, const Point& x, const Expr& b, const Point& y) {
  if (a == b && x == y) {
    return true;
  }
  int compared = 0;
  for (const double t : {0.0, 0.0625, 0.37, 0.5, 0.81, 1.0, 1.7, 3.3, 12.0, 250.0}) {
    const double va = value_at(a, x, t), vb = value_at(b, y, t);
    if (!std::isfinite(va) || !std::isfinite(vb)) {
      continue;
    }
    if (std::abs(va - vb) > 1e-12 * std::max({std::abs(va), std::abs(vb), 1e-3})) {
      return false;
    }
    ++compared;
  }
  return compared > 0;
}

bool agree(const Expr& a, const Expr& b, const Point& x) { return agree(a, x, b, x); }

void check_spec(const Space& space, const DirichletSpec& entry) {
  const SpaceBlock& block = space.blocks[static_cast<std::size_t>(entry.unknown)];
  const std::size_t imposed = entry.component < 0 ? std::size_t(block.components) : 1;
  if (entry.component >= block.components) {
    throw Failure(
        FailureKind::bad_value, entry.origin,
        fmt::format("component {} of a field with {}", entry.component + 1LL, block.components));
  }
  if (!entry.value.empty() && entry.value.size() != imposed) {
    throw Failure(FailureKind::bad_value, entry.origin,
                  fmt::format("{} values imposed on {} components", entry.value.size(), imposed));
  }
  for (const Expr& value : entry.value) {
    for (const Slot slot : slots_of(value)) {
      if (slot > slot::t) {
        throw Failure(FailureKind::bad_value, entry.origin,
                      fmt::format("an imposed value cannot depend on {}", describe_slot(slot)));
      }
    }
  }
}

/// Collects what is imposed, dof by dof, in the order of the specification.
class Collector {
public:
  Collector(const Space& space, const SpaceSpec& spec)
      : space_(space), spec_(spec), taken_(std::size_t(space.n_dofs()), -1),
        nodes_(spec.dirichlet.size()) {}

  void add(int index, std::span<const std::int32_t> nodes) {
    auto& sorted = nodes_[index];
    sorted.assign(nodes.begin(), nodes.end());
    std::sort(sorted.begin(), sorted.end());
    const DirichletSpec& entry = spec_.dirichlet[index];
    const SpaceBlock& block = space_.blocks[static_cast<std::size_t>(entry.unknown)];
    const int first = std::max(entry.component, 0);
    const int past = entry.component < 0 ? block.components : first + 1;
    for (int c = first; c < past; ++c) {
      if (overridden(index, c)) {
        continue;
      }
      const int value = entry.value.empty() ? -1 : c - first;
      for (const auto node : nodes) {
        if (has_node(space_, block, node))
          add_dof({space_.dof(node, block.first + c), index, value, node}, node);
      }
    }
  }
  /// Functions of V vanish on the axis in x: u_x/x is square integrable with the weight x.
  void add_axis() {
    for (const SpaceBlock& block : space_.blocks)
      if (has_hoop(space_, block)) add_axis(block);
  }
  /// Where unknowns have no functions (has_node).
  void add_missing() {
    for (const SpaceBlock& block : space_.blocks) {
      if (block.order == space_.order && !block.domain) continue;
      for (int node = 0; node < static_cast<int>(space_.nodes.size()); ++node)
        for (int c = 0; c < block.components && !has_node(space_, block, node); ++c)
          eliminated_.push_back({space_.dof(node, block.first + c), -1, -1, node});
    }
  }
  /// What is imposed on a dof is imposed on all that are one with it (periodic_dofs).
  void repeat(std::span<const std::int32_t> one_of) {
    std::map<std::int32_t, Eliminated> known;
    std::vector<char> has(one_of.size(), 0);
    for (const Eliminated& e : eliminated_) {
      has[static_cast<std::size_t>(e.dof)] = 1;
      const auto [at, fresh] = known.try_emplace(one_of[static_cast<std::size_t>(e.dof)], e);
      if (!fresh && !agree(expression(at->second), place(at->second), expression(e), place(e)))
        throw Failure(FailureKind::overlapping_regions,
                      spec_.dirichlet[std::max(e.dirichlet, 0)].origin,
                      fmt::format("{} repeats {}, and has another value: {} and {}",
                                  describe_dof(space_, e.dof), describe_dof(space_, at->second.dof),
                                  to_string(expression(e)), to_string(expression(at->second))),
                      "where parts are periodic, values imposed on both are the same");
    }
    for (std::size_t dof = 0; dof < one_of.size(); ++dof)
      if (const auto at = known.find(one_of[dof]); has[dof] == 0 && at != known.end()) {
        eliminated_.push_back(at->second);
        eliminated_.back().dof = static_cast<std::int32_t>(dof);
      }
  }
  std::vector<Eliminated> take() {
    std::sort(eliminated_.begin(), eliminated_.end(),
              [](const Eliminated& a, const Eliminated& b) { return a.dof < b.dof; });
    return std::move(eliminated_);
  }
  Expr expression(const Eliminated& e) const {
    return e.value < 0 ? Expr(0.0) : spec_.dirichlet[e.dirichlet].value[e.value];
  }

private:
  const Point& place(const Eliminated& e) const {
    return space_.nodes[static_cast<std::size_t>(e.node)];
  }
  void add_axis(const SpaceBlock& block) {
    for (int node = 0; node < static_cast<int>(space_.nodes.size()); ++node) {
      if (space_.nodes[node][0] != 0.0) {
        continue;
      }
      if (!has_node(space_, block, node)) continue;
      const int dof = space_.dof(node, block.first);
      if (taken_[dof] < 0) {
        eliminated_.push_back({dof, -1, -1, node});
        continue;
      }
      const Eliminated& before = eliminated_[taken_[dof]];
      if (!agree(expression(before), Expr(0.0), space_.nodes[node])) {
        throw Failure(FailureKind::overlapping_regions, spec_.dirichlet[before.dirichlet].origin,
                      fmt::format("on the axis {} is 0, here it is {}", describe_dof(space_, dof),
                                  to_string(expression(before))),
                      "the points of the axis do not leave it: impose the other component only");
      }
    }
  }
  /// A zero of the space that another entry on the same part fills in.
  bool overridden(int index, int component) const {
    const DirichletSpec& entry = spec_.dirichlet[index];
    if (!entry.value.empty()) {
      return false;
    }
    return std::any_of(spec_.dirichlet.begin(), spec_.dirichlet.end(), [&](const auto& other) {
      return !other.value.empty() && other.part == entry.part && other.unknown == entry.unknown &&
             (other.component < 0 || other.component == component);
    });
  }
  /// A value on a part inside one where the space is zero takes the place of that zero.
  bool inside(int value, int zero) const {
    const auto& part = nodes_[value];
    const auto& larger = nodes_[zero];
    return part.size() < larger.size() &&
           std::includes(larger.begin(), larger.end(), part.begin(), part.end());
  }
  void add_dof(const Eliminated& e, int node) {
    if (taken_[e.dof] < 0) {
      taken_[e.dof] = static_cast<std::int32_t>(eliminated_.size());
      eliminated_.push_back(e);
      return;
    }
    const Eliminated& before = eliminated_[taken_[e.dof]];
    if (agree(expression(e), expression(before), space_.nodes[node])) {
      return;
    }
    if (before.value < 0 && e.value >= 0 && inside(e.dirichlet, before.dirichlet)) {
      eliminated_[taken_[e.dof]] = e;
      return;
    }
    throw Failure(FailureKind::overlapping_regions, spec_.dirichlet[e.dirichlet].origin,
                  fmt::format("two different values are imposed on {}: {} and {}",
                              describe_dof(space_, e.dof), to_string(expression(before)),
                              to_string(expression(e))),
                  "let the parts not share this node, or impose equal values there");
  }

  const Space& space_;
  const SpaceSpec& spec_;
  std::vector<std::int32_t> taken_;              ///< index into eliminated_ of each dof, -1: free
  std::vector<std::vector<std::int32_t>> nodes_; ///< of each entry's part, sorted
  std::vector<Eliminated> eliminated_;
};

} // namespace

DofMap make_dof_map(const Space& space, const SpaceSpec& spec, std::span<const Region> parts) {
  Collector collector(space, spec);
  for (std::size_t d = 0; d < spec.dirichlet.size(); ++d) {
    check_spec(space, spec.dirichlet[d]);
    collector.add(static_cast<int>(d), nodes_on(space, parts[spec.dirichlet[d].part]));
  }
  collector.add_axis();
  collector.add_missing();
  const auto one_of = periodic_dofs(space, spec, parts);
  if (!one_of.empty()) collector.repeat(one_of);
  DofMap map;
  map.eliminated = collector.take();
  map.held_of.assign(space.blocks.size(), 0);
  map.unknown_of.assign(std::size_t(space.n_dofs()), 0);
  for (const Eliminated& e : map.eliminated) {
    map.unknown_of[e.dof] = -1;
    const int component = e.dof % space.components;
    const SpaceBlock& block = space.blocks[static_cast<std::size_t>(space.block_of(component))];
    if (!has_node(space, block, e.dof / space.components)) continue;
    // Around the axis only translations along it strain nothing.
    if (!has_hoop(space, block) || component > block.first)
      map.held_of[static_cast<std::size_t>(space.block_of(component))] = 1;
    map.homogeneous = map.homogeneous && collector.expression(e).is(0.0);
  }
  for (int dof = 0; dof < space.n_dofs(); ++dof) {
    if (map.unknown_of[dof] < 0) {
      continue;
    }
    if (!one_of.empty() && one_of[dof] != dof) { // comes before
      map.links.push_back({dof, one_of[dof]});
      map.unknown_of[dof] = map.unknown_of[one_of[dof]];
      continue;
    }
    map.unknown_of[dof] = static_cast<std::int32_t>(map.free.size());
    map.free.push_back(dof);
  }
  return map;
}

std::vector<char> DofMap::needs_mass() const {
  std::vector<char> out(held_of);
  for (char& of : out) of = of != 0 ? 0 : 1;
  return out;
}

void impose(const Space& space, const SpaceSpec& spec, const DofMap& map, double t, Vector& u) {
  std::map<std::pair<int, int>, std::vector<Eliminated>> dofs_of_value;
  for (const Eliminated& e : map.eliminated) {
    u[e.dof] = 0.0;
    if (e.value >= 0) {
      dofs_of_value[{e.dirichlet, e.value}].push_back(e);
    }
  }
  std::vector<std::int32_t> nodes;
  std::vector<double> values;
  for (const auto& [key, dofs] : dofs_of_value) {
    const DirichletSpec& entry = spec.dirichlet[key.first];
    nodes.clear();
    for (const Eliminated& e : dofs) {
      nodes.push_back(e.node);
    }
    values.resize(dofs.size());
    Pointwise value({&entry.value[key.second], 1});
    value.evaluate(block_of_nodes(space, nodes), t, entry.origin, values);
    for (std::size_t k = 0; k < dofs.size(); ++k) {
      if (!std::isfinite(values[k])) {
        throw_not_finite(entry.origin, "the imposed value", values[k], space.nodes[nodes[k]],
                         space.mesh->dim, &t);
      }
      u[dofs[k].dof] = values[k];
    }
  }
}

Vector interpolate(const Space& space, std::span<const Expr> components, double t, Origin origin) {
  Vector u = Vector::Zero(space.n_dofs());
  if (components.empty()) {
    return u;
  }
  if (components.size() != std::size_t(space.components)) {
    throw Failure(FailureKind::bad_value, origin,
                  fmt::format("{} expressions for a field with {} components", components.size(),
                              space.components));
  }
  std::vector<std::int32_t> nodes(space.nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = static_cast<std::int32_t>(i);
  }
  std::vector<double> values(nodes.size() * components.size());
  Pointwise(components).evaluate(block_of_nodes(space, nodes), t, origin, values);
  for (std::size_t c = 0; c < components.size(); ++c) {
    const int of = static_cast<int>(c);
    const SpaceBlock& block = space.blocks[static_cast<std::size_t>(space.block_of(of))];
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!has_node(space, block, static_cast<int>(i))) continue;
      const double value = values[c * nodes.size() + i];
      if (!std::isfinite(value)) {
        throw_not_finite(origin, "the function", value, space.nodes[i], space.mesh->dim, &t);
      }
      u[space.dof(static_cast<int>(i), static_cast<int>(c))] = value;
    }
  }
  return u;
}

} // namespace hvi::solver
