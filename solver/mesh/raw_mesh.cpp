// From tags and mixed elements to cells, facets and groups.
#include "solver/mesh/raw_mesh.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/joined.hpp"
#include "solver/mesh/facet_table.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

namespace hvi::solver {
namespace {

/// Tag -> index: a table when the tags are dense (as a rule), else a hash map.
class NodeIndex {
public:
  NodeIndex(const std::vector<std::int64_t>& tags, const std::string& file) : file_(file) {
    if (tags.empty()) return;
    const auto [low, high] = std::minmax_element(tags.begin(), tags.end());
    low_ = *low;
    const auto range = static_cast<std::uint64_t>(*high) - static_cast<std::uint64_t>(*low);
    dense_ = range < 8 * tags.size() + 1024;
    if (dense_) table_.assign(range + 1, -1);
    for (std::size_t i = 0; i < tags.size(); ++i) {
      auto& slot = dense_ ? table_[static_cast<std::size_t>(tags[i] - low_)]
                          : map_.try_emplace(tags[i], -1).first->second;
      if (slot >= 0)
        throw Failure(FailureKind::broken_file, {},
                      fmt::format("{}: two nodes have the tag {}", file, tags[i]));
      slot = static_cast<std::int32_t>(i);
    }
  }

  std::int32_t operator()(std::int64_t tag, const RawMesh::Element& element) const {
    std::int32_t index = -1;
    const auto offset = static_cast<std::uint64_t>(tag) - static_cast<std::uint64_t>(low_);
    if (dense_) {
      if (offset < table_.size()) index = table_[offset];
    } else if (const auto at = map_.find(tag); at != map_.end()) {
      index = at->second;
    }
    if (index < 0)
      throw Failure(FailureKind::broken_file, {},
                    fmt::format("{}: element {} uses node {}, which is not in the file", file_,
                                element.tag, tag));
    return index;
  }

private:
  std::string file_;
  bool dense_ = false;
  std::int64_t low_ = 0;
  std::vector<std::int32_t> table_;
  std::unordered_map<std::int64_t, std::int32_t> map_;
};

using GroupKey = std::pair<int, int>; // dim, physical tag

class Assembler {
public:
  Assembler(const RawMesh& raw, const std::string& file)
      : raw_(raw), file_(file), index_(raw.node_tags, file) {}

  Mesh run(Straightening* straightened) {
    find_dimension();
    add_cells();
    keep_used_nodes();
    check_flat();
    for (std::size_t c = 0; c < mesh_.cells.size(); ++c) orient(c);
    merge_repeated();
    if (straightened) *straightened = straighten();
    name_groups();
    group_cells();
    group_facets();
    group_points();
    for (auto& [name, group] : mesh_.groups) {
      auto& e = group.entities;
      std::sort(e.begin(), e.end());
      e.erase(std::unique(e.begin(), e.end()), e.end());
    }
    mesh_.description = file_;
    return std::move(mesh_);
  }

private:
  void find_dimension() {
    mesh_.dim = 0;
    for (const auto& e : raw_.elements) mesh_.dim = std::max(mesh_.dim, e.dim);
    if (mesh_.dim == 0)
      throw Failure(
          FailureKind::broken_file, {},
          fmt::format("{}: there are no lines, triangles or tetrahedra in the file", file_),
          "was the geometry meshed before it was saved?");
  }

  /// Cells with indices into raw_.coordinates at first.
  void add_cells() {
    for (std::size_t i = 0; i < raw_.elements.size(); ++i) {
      const auto& e = raw_.elements[i];
      if (e.dim != mesh_.dim) continue;
      std::array<std::int32_t, 4> cell{-1, -1, -1, -1};
      for (int k = 0; k <= e.dim; ++k) cell[k] = index_(e.nodes[k], e);
      mesh_.cells.push_back(cell);
      sources_.push_back(i);
    }
    check_cell_limit(static_cast<double>(mesh_.cells.size()));
  }

  void keep_used_nodes() {
    new_index_.assign(raw_.coordinates.size(), -1);
    for (const auto& c : mesh_.cells)
      for (int k = 0; k <= mesh_.dim; ++k) new_index_[c[k]] = 0;
    for (std::size_t i = 0; i < new_index_.size(); ++i) {
      if (new_index_[i] < 0) continue;
      new_index_[i] = static_cast<std::int32_t>(mesh_.nodes.size());
      mesh_.nodes.push_back(raw_.coordinates[i]);
    }
    for (auto& c : mesh_.cells)
      for (int k = 0; k <= mesh_.dim; ++k) c[k] = new_index_[c[k]];
  }

  /// Coordinates a mesh does not use must vanish; rounding errors of the file are wiped.
  void check_flat() {
    const double size = bounding_box(mesh_).diagonal();
    for (auto& p : mesh_.nodes) {
      for (int a = mesh_.dim; a < 3; ++a) {
        if (!(std::abs(p[a]) <= 1e-9 * size))
          throw Failure(
              FailureKind::bad_mesh, {},
              fmt::format(
                  "{}: a mesh of {} must have {} = 0 everywhere, but a node is at ({}, {}, {})",
                  file_, mesh_.dim == 1 ? "lines" : "triangles", "xyz"[a], p[0], p[1], p[2]),
              mesh_.dim == 2
                  ? "a surface in space cannot be a 2D body; for a 3D body save its volume"
                  : "");
        p[a] = 0;
      }
    }
  }

  std::string cell_name(std::size_t c) const {
    const auto& e = raw_.elements[sources_[c]];
    std::string text = fmt::format("{}: element {}", file_, e.tag);
    if (e.entity >= 0 && !raw_.entities[e.entity].physical.empty())
      text +=
          fmt::format(" of group \"{}\"", plain_name({e.dim, raw_.entities[e.entity].physical[0]}));
    std::string corners;
    for (int k = 0; k <= mesh_.dim; ++k) {
      const auto& p = mesh_.nodes[mesh_.cells[c][k]];
      corners += fmt::format("{}({})", k ? ", " : "", joined(p, mesh_.dim, 6));
    }
    return fmt::format("{} with corners {}", text, corners);
  }

  /// Flips a negative cell. Degenerate: the measure is rounding error of its coordinates.
  void orient(std::size_t c) {
    auto& cell = mesh_.cells[c];
    if (mesh_.dim == 3) cell = refinable_order(mesh_.nodes, cell);
    double measure = cell_measure(mesh_, static_cast<int>(c));
    if (measure < 0) {
      std::swap(cell[mesh_.dim - 1], cell[mesh_.dim]);
      measure = -measure;
    }
    double diameter = 0;
    for (int i = 0; i <= mesh_.dim; ++i) {
      for (int j = 0; j < i; ++j) {
        const Point &a = mesh_.nodes[cell[i]], &b = mesh_.nodes[cell[j]];
        diameter = std::max(diameter, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
      }
    }
    const double scale = std::pow(diameter, mesh_.dim);
    if (!(measure > 1e-14 * scale) || !std::isfinite(scale))
      throw Failure(FailureKind::bad_mesh, {},
                    fmt::format("{} is degenerate: its {} is {:.3g}", cell_name(c),
                                mesh_.dim == 1   ? "length"
                                : mesh_.dim == 2 ? "area"
                                                 : "volume",
                                measure));
  }

  /// MSH 2 repeats a cell for each physical group it is in: those become one cell. Any other
  /// repetition is an error.
  void merge_repeated() {
    std::vector<std::pair<std::array<std::int32_t, 4>, std::int32_t>> keys(mesh_.cells.size());
    for (std::size_t c = 0; c < keys.size(); ++c) {
      keys[c] = {mesh_.cells[c], static_cast<std::int32_t>(c)};
      std::sort(keys[c].first.begin(), keys[c].first.end());
    }
    std::sort(keys.begin(), keys.end());
    cell_of_source_.resize(keys.size());
    std::vector<bool> repeated(keys.size(), false);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const bool again = i > 0 && keys[i].first == keys[i - 1].first;
      if (again) check_repetition(keys[i - 1].second, keys[i].second);
      const std::int32_t c = keys[i].second;
      repeated[c] = again;
      cell_of_source_[c] = again ? cell_of_source_[keys[i - 1].second] : c;
    }
    drop(repeated);
  }

  void check_repetition(std::int32_t first, std::int32_t second) const {
    const auto &a = raw_.elements[sources_[first]], &b = raw_.elements[sources_[second]];
    const bool two_groups = a.entity >= 0 && b.entity >= 0 && a.entity != b.entity &&
                            raw_.entities[a.entity].tag == raw_.entities[b.entity].tag;
    if (!two_groups)
      throw Failure(FailureKind::bad_mesh, {},
                    fmt::format("{} is there twice, also as element {}", cell_name(first), b.tag));
  }

  void drop(const std::vector<bool>& repeated) {
    std::vector<std::int32_t> kept(repeated.size(), -1);
    std::int32_t count = 0;
    for (std::size_t c = 0; c < repeated.size(); ++c) {
      if (repeated[c]) continue;
      kept[c] = count;
      mesh_.cells[count++] = mesh_.cells[c];
    }
    mesh_.cells.resize(count);
    for (auto& c : cell_of_source_) c = kept[c];
  }

  /// What the cells lose with the nodes in the middle of their edges.
  Straightening straighten() const {
    std::vector<bool> seen(mesh_.cells.size(), false);
    StraighteningSum sum(mesh_.dim, raw_.coordinates.size());
    auto middles = raw_.middles.begin();
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      while (middles != raw_.middles.end() && middles->element < sources_[i]) ++middles;
      const bool again = seen[cell_of_source_[i]];
      seen[cell_of_source_[i]] = true;
      if (again || middles == raw_.middles.end() || middles->element != sources_[i]) continue;
      const auto& e = raw_.elements[sources_[i]];
      StraighteningSum::Cell cell;
      for (int k = 0; k <= e.dim; ++k) cell.corners[k] = raw_.coordinates[index_(e.nodes[k], e)];
      for (int k = 0; k < e.dim * (e.dim + 1) / 2; ++k) {
        cell.indices[k] = index_(middles->nodes[k], e);
        cell.middles[k] = raw_.coordinates[cell.indices[k]];
      }
      sum.add(cell);
    }
    return sum.result();
  }

  Group::Kind kind_of(int dim) const {
    if (dim == mesh_.dim) return Group::Kind::cells;
    return dim == mesh_.dim - 1 ? Group::Kind::facets : Group::Kind::points;
  }

  std::string plain_name(const GroupKey& key) const {
    const auto at = raw_.names.find(key);
    if (at == raw_.names.end() || at->second.empty()) return std::to_string(key.second);
    std::string name = at->second; // control characters would be orders to a terminal
    std::replace_if(
        name.begin(), name.end(),
        [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
    return name;
  }

  /// Named groups exist even without elements, so that using one is an error that says so.
  void name_groups() {
    std::set<GroupKey> keys;
    for (const auto& [key, name] : raw_.names) keys.insert(key);
    for (const auto& e : raw_.entities)
      for (const int p : e.physical) keys.insert({e.dim, p});
    std::map<std::string, std::set<Group::Kind>> kinds;
    for (const auto& key : keys) kinds[plain_name(key)].insert(kind_of(key.first));
    static const char* const suffix[] = {" (cells)", " (facets)", " (points)"};
    for (const auto& key : keys) {
      const Group::Kind kind = kind_of(key.first);
      std::string name = plain_name(key);
      if (kinds[name].size() > 1) name += suffix[static_cast<int>(kind)];
      Group& group = mesh_.groups[name];
      group.kind = kind;
      groups_[key] = &group;
    }
  }

  template <typename F>
  void for_groups_of(const RawMesh::Element& e, F&& f) {
    if (e.entity < 0) return;
    for (const int p : raw_.entities[e.entity].physical) f(*groups_.at({e.dim, p}));
  }

  void group_cells() {
    for (std::size_t i = 0; i < sources_.size(); ++i)
      for_groups_of(raw_.elements[sources_[i]],
                    [&](Group& g) { g.entities.push_back(cell_of_source_[i]); });
  }

  void group_facets() {
    std::vector<std::array<std::int32_t, 3>> named;
    std::vector<const RawMesh::Element*> elements;
    for (const auto& e : raw_.elements) {
      if (e.dim != mesh_.dim - 1 || e.entity < 0 || raw_.entities[e.entity].physical.empty())
        continue;
      std::array<std::int32_t, 3> nodes{-1, -1, -1};
      for (int k = 0; k < mesh_.dim; ++k)
        if ((nodes[k] = new_index_[index_(e.nodes[k], e)]) < 0) throw no_cell(e);
      if (raw_.entities[e.entity].reversed) turn(mesh_.dim, nodes);
      named.push_back(nodes);
      elements.push_back(&e);
    }
    const auto facets = index_facets(mesh_, named);
    for (std::size_t i = 0; i < named.size(); ++i) {
      if (facets[i] < 0) throw no_cell(*elements[i]);
      for_groups_of(*elements[i], [&](Group& g) { g.entities.push_back(facets[i]); });
      note_turned(*elements[i], named[i], mesh_.facets[static_cast<std::size_t>(facets[i])]);
    }
  }

  /// A facet has one normal: that of the element which came first.
  void note_turned(const RawMesh::Element& e, const std::array<std::int32_t, 3>& nodes,
                   const Facet& facet) {
    if (facet.other < 0 || mesh_.dim == 1) return;
    const bool turned = facet_key(mesh_.dim, nodes).odd != facet_key(mesh_.dim, facet.nodes).odd;
    const auto& entity = raw_.entities[e.entity];
    for (std::size_t k = 0; k < entity.physical.size(); ++k) {
      const bool against = k < entity.against_first.size() && entity.against_first[k] != 0;
      if (turned != against) groups_.at({e.dim, entity.physical[k]})->against_another = true;
    }
  }

  Failure no_cell(const RawMesh::Element& e) const {
    return Failure(FailureKind::bad_mesh, {},
                   fmt::format("{}: element {} of group \"{}\" is not a side of any cell", file_,
                               e.tag, plain_name({e.dim, raw_.entities[e.entity].physical[0]})));
  }

  /// The nodes of points and, in space, of lines. One of no cell (the centre of an arc, say) cannot
  /// be a point of the body.
  void group_points() {
    for (const auto& e : raw_.elements) {
      if (e.dim >= mesh_.dim - 1) continue;
      for (int k = 0; k <= e.dim; ++k) {
        const std::int32_t node = new_index_[index_(e.nodes[k], e)];
        if (node < 0) continue;
        for_groups_of(e, [&](Group& g) {
          g.entities.push_back(node);
          g.of_lines = g.of_lines || e.dim == 1;
        });
      }
    }
  }

  const RawMesh& raw_;
  std::string file_;
  NodeIndex index_;
  Mesh mesh_;
  std::vector<std::size_t> sources_;         ///< cell before merging -> raw element
  std::vector<std::int32_t> cell_of_source_; ///< cell before merging -> cell
  std::vector<std::int32_t> new_index_;      ///< raw node -> node, -1: dropped
  std::map<GroupKey, Group*> groups_;
};

} // namespace

void RawMesh::Entity::take_signs() {
  reversed = !physical.empty() && physical.front() < 0;
  for (const int group : physical) against_first.push_back((group < 0) != reversed ? 1 : 0);
  for (int& group : physical) // of a broken file it may be the least integer
    if (group < 0) group = static_cast<int>(-static_cast<std::int64_t>(group));
}

ElementType element_type(std::int64_t type, const std::function<std::string()>& where) {
  switch (type) {
  case 15:
    return {0, 1};
  case 1:
    return {1, 2};
  case 2:
    return {2, 3};
  case 4:
    return {3, 4};
  case 8:
    return {1, 3};
  case 9:
    return {2, 6};
  case 11:
    return {3, 10};
  default:
    break;
  }
  static const std::map<std::int64_t, const char*> names{{3, "quadrangles"},
                                                         {5, "hexahedra"},
                                                         {6, "prisms"},
                                                         {7, "pyramids"},
                                                         {10, "quadrangles of second order"},
                                                         {12, "hexahedra of second order"},
                                                         {13, "prisms of second order"},
                                                         {14, "pyramids of second order"},
                                                         {16, "quadrangles of second order"},
                                                         {17, "hexahedra of second order"},
                                                         {18, "prisms of second order"},
                                                         {19, "pyramids of second order"},
                                                         {20, "triangles of third order"},
                                                         {21, "triangles of third order"},
                                                         {26, "lines of third order"},
                                                         {29, "tetrahedra of third order"}};
  const auto at = names.find(type);
  throw Failure(
      FailureKind::broken_file, {},
      fmt::format("{}: elements of type {}{}; a mesh here is made of points, lines, triangles and "
                  "tetrahedra, of first or second order",
                  where(), type, at == names.end() ? "" : fmt::format(" ({})", at->second)),
      "mesh again without recombination, with Mesh.ElementOrder 1");
}

Mesh assemble(const RawMesh& raw, const std::string& name, Straightening* straightened) {
  return Assembler(raw, name).run(straightened);
}

} // namespace hvi::solver
