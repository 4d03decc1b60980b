// The entry points of libhvi_gmsh.so: a quiet, deterministic gmsh session, and its mesh handed out.
#include "solver/mesh/gmsh/bridge.h"

#include "solver/mesh/gmsh/geometries.hpp"

#include <gmsh.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cstring>
#include <mutex>
#include <new>
#include <stdexcept>

namespace hvi::gmsh_module {
namespace {

/// A gmsh session from a fresh start to its end, so that nothing one mesh sets reaches the next. No
/// configuration files, no output, one thread, fixed random numbers. gmsh changes the locale of the
/// program: it is put back. gmsh has one session in a process: threads wait for each other.
class Session {
public:
  Session() { begin(); }
  ~Session() { gmsh::finalize(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  void begin_again() {
    gmsh::finalize();
    begin();
  }

private:
  void begin() {
    gmsh::initialize(0, nullptr, false);
    std::setlocale(LC_ALL, locale_.c_str());
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setNumber("Mesh.RandomSeed", 1);
  }
  static std::mutex& turn() {
    static std::mutex only;
    return only;
  }
  std::scoped_lock<std::mutex> lock_{turn()};
  std::string locale_ = std::setlocale(LC_ALL, nullptr);
};

Extent extent_of(int dim, int tag) {
  Extent e{};
  gmsh::model::getBoundingBox(dim, tag, e.low[0], e.low[1], e.low[2], e.high[0], e.high[1],
                              e.high[2]);
  return e;
}

void name_group(int dim, const std::vector<int>& tags, const std::string& name) {
  if (tags.empty()) throw std::runtime_error("the geometry has no part \"" + name + "\"");
  gmsh::model::setPhysicalName(dim, gmsh::model::addPhysicalGroup(dim, tags), name);
}

std::vector<int> tags_of(const gmsh::vectorpair& entities) {
  std::vector<int> tags;
  for (const auto& [dim, tag] : entities) tags.push_back(tag);
  return tags;
}

/// Physical groups: "body", the sides, the named points.
void name_parts(const Blueprint& b) {
  gmsh::vectorpair body, boundary, points;
  gmsh::model::getEntities(body, b.dim);
  name_group(b.dim, tags_of(body), "body");
  gmsh::model::getBoundary(body, boundary, true, false);
  std::vector<std::vector<int>> members(b.sides.size());
  for (const auto& [dim, tag] : boundary) {
    const Extent extent = extent_of(dim, tag);
    const auto side = std::find_if(b.sides.begin(), b.sides.end(),
                                   [&](const auto& s) { return s.second(extent); });
    if (side != b.sides.end())
      members[static_cast<std::size_t>(side - b.sides.begin())].push_back(tag);
  }
  for (std::size_t i = 0; i < b.sides.size(); ++i)
    name_group(b.dim - 1, members[i], b.sides[i].first);
  gmsh::model::getEntities(points, 0);
  for (const auto& [name, place] : b.points) {
    std::vector<int> found;
    for (const auto& [dim, tag] : points) {
      const Extent e = extent_of(dim, tag);
      double distance = 0;
      for (std::size_t a = 0; a < 3; ++a)
        distance = std::max(distance, std::abs((e.low[a] + e.high[a]) / 2 - place[a]));
      if (distance < 1e-5) found.push_back(tag);
    }
    name_group(0, found, name);
  }
}

void set_sizes(const Blueprint& b) {
  gmsh::option::setNumber("Mesh.MeshSizeMin", std::min(b.fine, b.size));
  gmsh::option::setNumber("Mesh.MeshSizeMax", std::max(b.fine, b.size));
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 0);
  if (!b.distance || b.fine == b.size) return;
  // Later versions of gmsh pass one argument more.
  gmsh::model::mesh::setSizeCallback([b](int, int, double x, double y, double z, auto...) {
    const double far = std::clamp(b.distance(x, y, z) / b.reach, 0.0, 1.0);
    return b.fine + (b.size - b.fine) * far;
  });
}

void send_nodes(const HviGmshSink& sink) {
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  for (std::size_t i = 0; i < tags.size(); ++i)
    sink.node(sink.self, static_cast<std::int64_t>(tags[i]), &coordinates[3 * i]);
}

void send_entity(const HviGmshSink& sink, int dim, int tag, const std::vector<int>& physical) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> tags, nodes;
  gmsh::model::mesh::getElements(types, tags, nodes, dim, tag);
  sink.entity(sink.self, dim, tag, physical.data(), physical.size());
  for (std::size_t i = 0; i < types.size(); ++i)
    if (!tags[i].empty())
      sink.elements(sink.self, types[i], tags[i].size(), tags[i].data(), nodes[i].data(),
                    nodes[i].size() / tags[i].size());
}

/// What gmsh would save: everything, or, once there are physical groups, what is in one.
void send_mesh(const HviGmshSink& sink) {
  gmsh::vectorpair groups, entities;
  gmsh::model::getPhysicalGroups(groups);
  for (const auto& [dim, tag] : groups) {
    std::string name;
    gmsh::model::getPhysicalName(dim, tag, name);
    if (!name.empty()) sink.physical_name(sink.self, dim, tag, name.c_str());
  }
  send_nodes(sink);
  gmsh::model::getEntities(entities);
  for (const auto& [dim, tag] : entities) {
    std::vector<int> physical;
    gmsh::model::getPhysicalGroupsForEntity(dim, tag, physical);
    if (groups.empty() || !physical.empty()) send_entity(sink, dim, tag, physical);
  }
}

void generate(const std::string& geometry, std::span<const double> numbers,
              const HviGmshSink& sink) {
  const Session session;
  gmsh::model::add(geometry);
  const Blueprint blueprint = build(geometry, numbers);
  gmsh::model::occ::synchronize();
  name_parts(blueprint);
  set_sizes(blueprint);
  gmsh::model::mesh::generate(blueprint.dim);
  send_mesh(sink);
}

/// A file without a name, as long as this lives.
class UnnamedFile {
public:
  explicit UnnamedFile(const std::string& text) : file_(memfd_create("geo", MFD_CLOEXEC)) {
    const auto n = static_cast<ssize_t>(text.size());
    if (file_ < 0 || write(file_, text.data(), text.size()) != n)
      throw std::runtime_error("no file in memory can be made");
  }
  ~UnnamedFile() { close(file_); }
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

private:
  int file_;
};

/// gmsh keeps constants that it is given as options for good; those of a file end with its session.
void open_behind(const std::string& before, const std::string& path) {
  if (before.empty()) return gmsh::open(path);
  const UnnamedFile file(before + "Merge \"" + path + "\";\n");
  gmsh::open(file.path());
}

/// What gmsh has not read of a file with a mistake it reads at the beginning of the next one, in
/// other sessions, too. Here that is a file without a statement.
void read_the_rest(Session& session) {
  constexpr int most = 100; // mistakes, each of which ends a reading
  const UnnamedFile nothing("\n");
  for (int i = 0; i < most; ++i) {
    session.begin_again();
    try {
      return gmsh::open(nothing.path());
    } catch (...) {
      continue;
    }
  }
}

void mesh_file(const std::string& path, const std::string& before, const HviGmshSink& sink) {
  Session session;
  try {
    open_behind(before, path);
  } catch (...) {
    read_the_rest(session);
    throw;
  }
  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups);
  int dim = groups.empty() ? gmsh::model::getDimension() : 0;
  for (const auto& group : groups) dim = std::max(dim, group.first);
  gmsh::model::mesh::generate(dim);
  send_mesh(sink);
}

int report(const std::string& text, char* message, std::size_t capacity) {
  if (capacity == 0) return 1;
  const std::size_t n = std::min(text.size(), capacity - 1);
  std::memcpy(message, text.data(), n);
  message[n] = '\0';
  return 1;
}

/// No exception leaves the module: gmsh throws strings.
template <typename F>
int guarded(F&& f, char* message, std::size_t capacity) {
  try {
    f();
    return 0;
  } catch (const std::bad_alloc&) {
    return hvi_gmsh_no_memory;
  } catch (const std::exception& e) {
    return report(e.what(), message, capacity);
  } catch (const std::string& text) {
    return report(text, message, capacity);
  } catch (...) {
    return report("an unknown error in gmsh", message, capacity);
  }
}

} // namespace
} // namespace hvi::gmsh_module

extern "C" {
int hvi_gmsh_generate(const char* geometry, const double* numbers, std::size_t n,
                      const HviGmshSink* sink, char* message, std::size_t capacity) {
  using namespace hvi::gmsh_module;
  return guarded([&] { generate(geometry, {numbers, n}, *sink); }, message, capacity);
}

int hvi_gmsh_mesh_file(const char* path, const char* before, const HviGmshSink* sink, char* message,
                       std::size_t capacity) {
  using namespace hvi::gmsh_module;
  return guarded([&] { mesh_file(path, before, *sink); }, message, capacity);
}
}
