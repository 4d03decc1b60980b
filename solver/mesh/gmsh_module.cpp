// Loads libhvi_gmsh.so when a mesh is to be generated, and turns what it sends into a mesh.
#include "solver/mesh/gmsh_module.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/joined.hpp"
#include "solver/common/open_module.hpp"
#include "solver/common/out_of_memory.hpp"
#include "solver/common/read_file.hpp"
#include "solver/mesh/geometries.hpp"
#include "solver/mesh/gmsh/bridge.h"
#include "solver/mesh/raw_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace hvi::solver {
namespace {

constexpr ModuleFile gmsh_module{
    "libhvi_gmsh.so", "HVI_GMSH_MODULE", "makes meshes with gmsh",
    "it needs the package libgmsh4.8; meshes from .msh files work without it"};

template <class Function>
Function entry(const char* name) {
  return module_function<Function>(gmsh_module, name);
}

/// Collects what the module sends; coordinates are multiplied by `scale`.
struct Collector {
  RawMesh raw;
  double scale = 1;
  int dim = 0; ///< of the entity whose elements come

  HviGmshSink sink() { return {this, add_node, add_name, add_entity, add_elements}; }

  static Collector& of(void* self) { return *static_cast<Collector*>(self); }

  static void add_node(void* self, std::int64_t tag, const double* x) {
    const double s = of(self).scale;
    of(self).raw.node_tags.push_back(tag);
    of(self).raw.coordinates.push_back({s * x[0], s * x[1], s * x[2]});
  }

  static void add_name(void* self, int dim, int tag, const char* name) {
    of(self).raw.names[{dim, tag}] = name;
  }

  static void add_entity(void* self, int dim, int tag, const int* physical, std::size_t n) {
    RawMesh::Entity entity{dim, tag, {physical, physical + n}};
    entity.take_signs();
    of(self).raw.entities.push_back(std::move(entity));
  }

  static void add_elements(void* self, int type, std::size_t n, const std::size_t* tags,
                           const std::size_t* nodes, std::size_t stride) {
    RawMesh& raw = of(self).raw;
    const ElementType simplex = element_type(type, [] { return std::string("gmsh's mesh"); });
    for (std::size_t i = 0; i < n; ++i) {
      RawMesh::Element e{simplex.dim,
                         static_cast<std::int32_t>(raw.entities.size()) - 1,
                         static_cast<std::int64_t>(tags[i]),
                         {}};
      const std::size_t* const mine = nodes + i * stride;
      for (int k = 0; k <= simplex.dim; ++k) e.nodes[k] = static_cast<std::int64_t>(mine[k]);
      if (simplex.nodes > simplex.dim + 1) {
        auto& middles = raw.middles.emplace_back();
        middles.element = raw.elements.size();
        for (int k = simplex.dim + 1; k < simplex.nodes; ++k)
          middles.nodes[k - simplex.dim - 1] = static_cast<std::int64_t>(mine[k]);
      }
      raw.elements.push_back(e);
    }
  }
};

/// A power of two of the order of the lengths: OpenCASCADE's tolerance is 1e-7 whatever the size of
/// the body, so it gets bodies of size one; scaling by it does not round.
double length_scale(const std::vector<double>& numbers) {
  double largest = 0;
  for (const double x : numbers) largest = std::max(largest, std::abs(x));
  return std::exp2(std::ceil(std::log2(largest)));
}

constexpr std::size_t message_size = 2000;

} // namespace

Mesh generate_geometry(const std::string& name, const std::vector<double>& given) {
  std::vector<double> numbers = complete_numbers(geometry_info(name), given);
  const std::string description = fmt::format("{}({})", name, joined(numbers));
  Collector collector;
  collector.scale = length_scale(numbers);
  for (double& x : numbers) x /= collector.scale;
  const auto generate = entry<HviGmshGenerate>("hvi_gmsh_generate");
  const HviGmshSink sink = collector.sink();
  std::string message(message_size, '\0');
  const int status =
      generate(name.c_str(), numbers.data(), numbers.size(), &sink, message.data(), message.size());
  if (status == hvi_gmsh_no_memory) throw OutOfMemory("no memory to mesh with gmsh");
  if (status != 0)
    throw Failure(FailureKind::bad_mesh, {},
                  fmt::format("gmsh could not mesh {}: {}", description, message.c_str()));
  return assemble(collector.raw, description);
}

namespace {

/// The constants as commands of gmsh: what is set before DefineConstant stays.
std::string commands(const std::string& path, const GeoConstants& constants) {
  if (constants.empty()) return {};
  const std::string text = read_file(path).value_or("");
  const auto known = geo_constants(text);
  const bool elsewhere = text.find("Include") != std::string::npos; // more may be defined there
  std::string out;
  for (const auto& [name, value] : constants) {
    if (!elsewhere && std::ranges::find(known, name) == known.end())
      throw Failure(FailureKind::bad_value, {},
                    fmt::format("{} defines no constant `{}`",
                                std::filesystem::path(path).filename().string(), name),
                    known.empty()
                        ? fmt::format("in the file: DefineConstant[ {} = {} ];", name, value)
                        : fmt::format("it defines {}", joined(known)));
    out += fmt::format("{} = {:.17g};\n", name, value);
  }
  if (path.find_first_of("\"\n") != std::string::npos)
    throw Failure(FailureKind::bad_value, {}, "a file whose name has a quotation mark in it");
  return out;
}

} // namespace

Mesh mesh_geo_file(const std::string& path, Straightening* straightened,
                   const GeoConstants& constants) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw Failure(FailureKind::missing_file, {}, fmt::format("there is no geometry file {}", path));
  Collector collector;
  const auto mesh_file = entry<HviGmshMeshFile>("hvi_gmsh_mesh_file");
  const HviGmshSink sink = collector.sink();
  std::string message(message_size, '\0');
  const int status =
      mesh_file(std::filesystem::absolute(path).c_str(), commands(path, constants).c_str(), &sink,
                message.data(), message.size());
  if (status == hvi_gmsh_no_memory) throw OutOfMemory("no memory to mesh with gmsh");
  if (status != 0)
    throw Failure(FailureKind::broken_file, {},
                  fmt::format("gmsh could not mesh {}: {}", name, message.c_str()));
  return assemble(collector.raw, name, straightened);
}

} // namespace hvi::solver
