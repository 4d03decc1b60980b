/* The C interface between hvi-run and the module libhvi_gmsh.so, which is the only code that links
   libgmsh. The module hands a mesh over through callbacks: it owns nothing of ours, nor we of its. */
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {

struct HviGmshSink {
  void* self;
  void (*node)(void* self, std::int64_t tag, const double* xyz);
  void (*physical_name)(void* self, int dim, int tag, const char* name);
  /* A geometric entity and its physical groups; the elements that follow lie on it. */
  void (*entity)(void* self, int dim, int tag, const int* physical, std::size_t n_physical);
  /* n elements of one gmsh type, with all their nodes. */
  void (*elements)(void* self, int type, std::size_t n, const std::size_t* tags,
                   const std::size_t* nodes, std::size_t nodes_per_element);
};

/* Both return 0, or 1 after writing a message of at most `capacity` bytes to `message`, or this. */
constexpr int hvi_gmsh_no_memory = 2;

using HviGmshGenerate = int (*)(const char* geometry, const double* numbers, std::size_t n,
                                const HviGmshSink* sink, char* message, std::size_t capacity);
/* `before`: commands that are read before the file; or an empty text. */
using HviGmshMeshFile = int (*)(const char* path, const char* before, const HviGmshSink* sink,
                                char* message, std::size_t capacity);
}
