// Reader of gmsh's MSH 2.2 and 4.1 files (gmsh reference manual, "MSH file format").
//
// The input may be hostile: every count is compared with the bytes left before anything is
// allocated, nothing is executed and no other file is opened.
#include "solver/mesh/read_msh.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/read_file.hpp"
#include "solver/mesh/msh_cursor.hpp"
#include "solver/mesh/raw_mesh.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <tuple>

namespace hvi::solver {
namespace {

class MshReader {
public:
  MshReader(std::string_view bytes, const std::string& name) : in_(bytes, name), name_(name) {}

  RawMesh run() {
    read_format();
    while (!in_.at_end()) read_section();
    for (const char* section : {"$Nodes", "$Elements"})
      if (!seen_.contains(section)) in_.fail(fmt::format("the file ends without {}", section));
    return std::move(raw_);
  }

private:
  /// $MeshFormat: version, 0 ascii / 1 binary, bytes of a size; then the integer 1, if binary.
  void read_format() {
    if (in_.word() != "$MeshFormat")
      throw Failure(FailureKind::broken_file, {},
                    fmt::format("{} is not a gmsh mesh: it does not begin with $MeshFormat", name_),
                    "a geometry (.geo) is no mesh yet: make one with `gmsh -2` or `gmsh -3`");
    const double version = in_.text_real("the version");
    if (version != 2.2 && version != 4.1)
      in_.fail(fmt::format("this is MSH version {}; 2.2 and 4.1 can be read", version));
    is_4_ = version == 4.1;
    const auto type = in_.text_integer("the file type");
    if (type != 0 && type != 1)
      in_.fail(fmt::format("the file type is {}, not 0 (ascii) or 1 (binary)", type));
    if (const auto size = in_.text_integer("the data size"); size != 8)
      in_.fail(fmt::format("the data size is {}; only 8 can be read", size));
    if (type == 1) read_byte_order();
    in_.expect("$EndMeshFormat");
  }

  void read_byte_order() {
    in_.end_line();
    const auto one = in_.binary_integer("the byte order mark");
    if (one != 1 && one != 0x01000000) in_.fail("the byte order mark is not the integer 1");
    in_.set_binary(one != 1);
  }

  void read_section() {
    const std::string section(in_.word());
    if (section.size() < 2 || section[0] != '$')
      in_.fail("expected a section ($Nodes, $Elements, ...)");
    const std::string end = "$End" + section.substr(1);
    if (section == "$PartitionedEntities")
      in_.fail("this is a partitioned mesh; save it in one piece");
    const auto known = sections().find(section);
    if (known == sections().end()) return in_.skip_to(end);
    if (!seen_.insert(section).second) in_.fail("a second " + section);
    if (in_.binary() && section != "$PhysicalNames") in_.end_line();
    (this->*known->second)();
    in_.expect(end);
  }

  using Method = void (MshReader::*)();
  const std::map<std::string, Method>& sections() const {
    static const std::map<std::string, Method> v2{{"$PhysicalNames", &MshReader::read_names},
                                                  {"$Nodes", &MshReader::read_nodes_2},
                                                  {"$Elements", &MshReader::read_elements_2}};
    static const std::map<std::string, Method> v4{{"$PhysicalNames", &MshReader::read_names},
                                                  {"$Entities", &MshReader::read_entities},
                                                  {"$Nodes", &MshReader::read_nodes_4},
                                                  {"$Elements", &MshReader::read_elements_4}};
    return is_4_ ? v4 : v2;
  }

  /// Text in binary files too: count, then `dimension tag "name"` lines.
  void read_names() {
    auto n = in_.text_integer("the number of physical names");
    for (; n > 0; --n) {
      const auto dim = in_.text_integer("a dimension");
      const auto tag = in_.text_integer("a physical tag");
      if (dim < 0 || dim > 3 || tag != static_cast<std::int32_t>(tag))
        in_.fail(fmt::format("no physical group has dimension {} and tag {}", dim, tag));
      raw_.names[{static_cast<int>(dim), static_cast<int>(tag)}] = in_.quoted("a physical name");
    }
  }

  Point read_point() {
    const double x = in_.real("a coordinate"), y = in_.real("a coordinate");
    return {x, y, in_.real("a coordinate")};
  }

  /// ---- MSH 2.2 ---------------------------------------------------------------------------------

  std::int64_t text_count(const char* what) {
    const auto n = in_.text_integer(what);
    if (in_.binary()) in_.end_line();
    return n;
  }

  void read_nodes_2() {
    const auto n = in_.count(text_count("the number of nodes"), 8, 28, "the number of nodes");
    raw_.node_tags.reserve(n);
    raw_.coordinates.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      raw_.node_tags.push_back(in_.integer("a node tag"));
      raw_.coordinates.push_back(read_point());
    }
  }

  /// Ascii: `tag type n-tags tags... nodes...`. Binary: headers `type n n-tags`, each followed by n
  /// times `tag tags... nodes...`.
  void read_elements_2() {
    const auto total =
        in_.count(text_count("the number of elements"), 8, 8, "the number of elements");
    raw_.elements.reserve(total);
    while (raw_.elements.size() < total) {
      std::int64_t tag = 0, n = 1;
      if (!in_.binary()) tag = in_.integer("an element tag");
      const auto type = element_type(in_.integer("an element type"), [&] { return in_.where(); });
      if (in_.binary()) n = in_.integer("a number of elements");
      const auto tags = in_.count(in_.integer("a number of tags"), 2, 4, "the number of tags");
      if (n < 1 || static_cast<std::size_t>(n) > total - raw_.elements.size())
        in_.fail(fmt::format("a block of {} elements where {} are left", n,
                             total - raw_.elements.size()));
      for (; n > 0; --n) {
        if (in_.binary()) tag = in_.integer("an element tag");
        read_element_2(tag, type, tags);
      }
    }
  }

  void read_element_2(std::int64_t tag, ElementType type, std::size_t tags) {
    RawMesh::Element e{type.dim, -1, tag, {}};
    int physical = 0, elementary = 0;
    for (std::size_t i = 0; i < tags; ++i) {
      const auto value = static_cast<int>(in_.integer("an element's group"));
      if (i == 0) physical = value;
      if (i == 1) elementary = value;
    }
    if (physical != 0) e.entity = entity(type.dim, elementary, physical);
    read_element_nodes(e, type, &MshCursor::integer);
    raw_.elements.push_back(e);
  }

  std::int32_t entity(int dim, int elementary, int physical) {
    const auto [at, is_new] =
        entities_2_.try_emplace({dim, elementary, physical}, raw_.entities.size());
    if (is_new) raw_.entities.push_back({dim, elementary, {physical}});
    return static_cast<std::int32_t>(at->second);
  }

  /// ---- MSH 4.1 ---------------------------------------------------------------------------------

  /// Points have 3 coordinates, the others a box of 6; then physical tags; then the bounding
  /// entities.
  void read_entities() {
    std::array<std::size_t, 4> counts{};
    for (auto& n : counts)
      n = in_.count(in_.size("a number of entities"), 2, 4, "the number of entities");
    for (int dim = 0; dim < 4; ++dim) {
      for (std::size_t i = 0; i < counts[dim]; ++i) {
        RawMesh::Entity e{dim, static_cast<int>(in_.integer("an entity tag")), {}};
        for (int k = 0; k < (dim == 0 ? 3 : 6); ++k) in_.real("a bound of an entity");
        read_tags(&e.physical);
        e.take_signs();
        if (dim > 0) read_tags(nullptr);
        entities_4_[{dim, e.tag}] = static_cast<std::int32_t>(raw_.entities.size());
        raw_.entities.push_back(std::move(e));
      }
    }
  }

  void read_tags(std::vector<int>* tags) {
    const auto n = in_.count(in_.size("a number of tags"), 2, 4, "the number of tags");
    for (std::size_t i = 0; i < n; ++i) {
      const auto tag = in_.integer("a tag");
      if (tags) tags->push_back(static_cast<int>(tag));
    }
  }

  void read_nodes_4() {
    auto blocks = in_.size("the number of blocks");
    const auto total = in_.count(in_.size("the number of nodes"), 8, 32, "the number of nodes");
    in_.size("the smallest node tag");
    in_.size("the largest node tag");
    raw_.node_tags.reserve(total);
    raw_.coordinates.reserve(total);
    for (; blocks > 0; --blocks) read_node_block();
    check_total("nodes", raw_.node_tags.size(), total);
  }

  void read_node_block() {
    const auto dim = in_.integer("the dimension of an entity");
    in_.integer("the tag of an entity");
    const auto parametric = in_.integer("0 or 1 for parametric");
    if (dim < 0 || dim > 3 || parametric < 0 || parametric > 1)
      in_.fail("the header of a block of nodes is not `dimension tag parametric count`");
    const auto n =
        in_.count(in_.size("the number of nodes in a block"), 8, 32, "the number of nodes");
    for (std::size_t i = 0; i < n; ++i) raw_.node_tags.push_back(in_.size("a node tag"));
    for (std::size_t i = 0; i < n; ++i) {
      raw_.coordinates.push_back(read_point());
      for (int k = 0; k < dim * parametric; ++k) in_.real("a parametric coordinate");
    }
  }

  void read_elements_4() {
    auto blocks = in_.size("the number of blocks");
    const auto total =
        in_.count(in_.size("the number of elements"), 4, 16, "the number of elements");
    in_.size("the smallest element tag");
    in_.size("the largest element tag");
    raw_.elements.reserve(total);
    for (; blocks > 0; --blocks) read_element_block();
    check_total("elements", raw_.elements.size(), total);
  }

  void read_element_block() {
    const auto dim = static_cast<int>(in_.integer("the dimension of an entity"));
    const auto tag = static_cast<int>(in_.integer("the tag of an entity"));
    const auto type = element_type(in_.integer("an element type"), [&] { return in_.where(); });
    if (type.dim != dim)
      in_.fail(fmt::format("elements of dimension {} on an entity of dimension {}", type.dim, dim));
    const auto n =
        in_.count(in_.size("the number of elements in a block"), 4, 16, "the number of elements");
    const auto at = entities_4_.find({dim, tag});
    const std::int32_t entity = at == entities_4_.end() ? -1 : at->second;
    for (std::size_t i = 0; i < n; ++i) {
      RawMesh::Element e{dim, entity, in_.size("an element tag"), {}};
      read_element_nodes(e, type, &MshCursor::size);
      raw_.elements.push_back(e);
    }
  }

  /// The corners come first.
  void read_element_nodes(RawMesh::Element& e, ElementType type,
                          std::int64_t (MshCursor::*number)(const char*)) {
    for (int k = 0; k <= type.dim; ++k) e.nodes[k] = (in_.*number)("a node tag");
    if (type.nodes == type.dim + 1) return;
    auto& middles = raw_.middles.emplace_back();
    middles.element = raw_.elements.size();
    for (int k = type.dim + 1; k < type.nodes; ++k)
      middles.nodes[k - type.dim - 1] = (in_.*number)("a node tag");
  }

  void check_total(const char* what, std::size_t found, std::size_t announced) const {
    if (found != announced)
      in_.fail(fmt::format("the blocks hold {} {}, but {} were announced", found, what, announced));
  }

  MshCursor in_;
  std::string name_;
  RawMesh raw_;
  bool is_4_ = false;
  std::set<std::string> seen_;
  std::map<std::tuple<int, int, int>, std::size_t> entities_2_; ///< dim, elementary, physical
  std::map<std::pair<int, int>, std::int32_t> entities_4_;      ///< dim, tag
};

} // namespace

Mesh parse_msh(std::string_view bytes, const std::string& name, Straightening* straightened) {
  return assemble(MshReader(bytes, name).run(), name, straightened);
}

Mesh read_msh(const std::string& path, Straightening* straightened) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::error_code ignored;
  constexpr std::uintmax_t most_bytes = std::uintmax_t{8} << 30;
  if (std::filesystem::is_regular_file(path, ignored) &&
      std::filesystem::file_size(path, ignored) > most_bytes)
    throw Failure(FailureKind::limit, {},
                  fmt::format("the mesh file {} is larger than 8 GiB", path));
  const auto bytes = read_file(path);
  if (!bytes)
    throw Failure(FailureKind::missing_file, {},
                  fmt::format("cannot read the mesh file {}: {}", path, std::strerror(errno)));
  return parse_msh(*bytes, name, straightened);
}

} // namespace hvi::solver
