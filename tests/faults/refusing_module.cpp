// In the place of the gmsh module: the system has nothing left for it.
#include "solver/mesh/gmsh/bridge.h"

#include <cerrno>
#include <system_error>

extern "C" int hvi_gmsh_generate(const char*, const double*, std::size_t, const HviGmshSink*, char*,
                                 std::size_t) {
  throw std::system_error(EAGAIN, std::generic_category(), "no thread for gmsh");
}
