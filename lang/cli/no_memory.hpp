// When memory runs out. hvi-run only.
#pragma once

#include "lang/diag/failures.hpp"

#include <cstdio>
#include <initializer_list>

namespace hvi::lang {

/// The one message of a run that gets no memory; `what` is its sentence. Allocates nothing.
inline void tell_no_memory(const char* what = "out of memory") {
  for (const char* text :
       {"error[", ending_of(solver::FailureKind::too_large).code, "]: ", what,
        "\n  = help: a coarser mesh, fewer steps or a smaller table need less\n"})
    std::fputs(text, stderr);
}

} // namespace hvi::lang
