// What UMFPACK hands out, freed by whoever owns it.
#pragma once

#include <umfpack.h>

namespace hvi::solver {

struct FreeSymbolic {
  void operator()(void* object) const { umfpack_dl_free_symbolic(&object); }
};
struct FreeNumeric {
  void operator()(void* object) const { umfpack_dl_free_numeric(&object); }
};

} // namespace hvi::solver
