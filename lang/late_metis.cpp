// METIS for hvi-run: opened when the first matrix wants it. Debian ships it as a shared library
// only, and only large matrices in 3D are ordered by it; binding it was a tenth of every start.
#include <dlfcn.h>
#include <metis.h>

#include <algorithm>
#include <numeric>

namespace {

void* open_library() {
  constexpr const char* name = "libmetis.so.5";
  constexpr int how = RTLD_NOW | RTLD_LOCAL;
  void* const library = dlopen(name, how);
  return library != nullptr ? library : dlopen(name, how); // memory may be short for a moment only
}

/// A function of METIS; null where the library is not to be had.
template <class Function>
Function* of_metis(const char* name) {
  static void* const library = open_library();
  return library == nullptr ? nullptr : reinterpret_cast<Function*>(dlsym(library, name));
}

/// Without memory METIS leaves the permutation as it was: what is no permutation tells of it.
int checked(int status, idx_t vertices, idx_t* permutation) {
  if (status != METIS_OK) std::fill(permutation, permutation + vertices, -1);
  return status;
}

} // namespace

extern "C" {

/// CHOLMOD does not look at what this returns. Without METIS the order stays as it is, which the
/// other candidate (solver/linear/ordering.cpp) beats.
int METIS_NodeND(idx_t* vertices, idx_t* start, idx_t* neighbour, idx_t* weight, idx_t* options,
                 idx_t* permutation, idx_t* inverse) {
  if (auto* order = of_metis<decltype(METIS_NodeND)>("METIS_NodeND"))
    return checked(order(vertices, start, neighbour, weight, options, permutation, inverse),
                   *vertices, permutation);
  std::iota(permutation, permutation + *vertices, 0);
  std::iota(inverse, inverse + *vertices, 0);
  return METIS_ERROR;
}

/// CHOLMOD's own nested dissection, which we do not use, asks for it.
int METIS_ComputeVertexSeparator(idx_t* vertices, idx_t* start, idx_t* neighbour, idx_t* weight,
                                 idx_t* options, idx_t* size, idx_t* part) {
  if (auto* split =
          of_metis<decltype(METIS_ComputeVertexSeparator)>("METIS_ComputeVertexSeparator"))
    return split(vertices, start, neighbour, weight, options, size, part);
  return METIS_ERROR;
}
}
