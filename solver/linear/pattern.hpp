// Patterns of sparse matrices as CHOLMOD takes them.
#pragma once

#include "solver/linear/cholmod_session.hpp"

#include <vector>

namespace hvi::solver {

/// The pattern of a square matrix by columns, the rows of each in any order.
struct Pattern {
  std::vector<Long> start{0}, row;

  int size() const { return static_cast<int>(start.size()) - 1; }
  /// CHOLMOD's view of it; stype 1 or -1: symmetric, of which the upper or the lower triangle is
  /// read. Valid as long as this object stays where it is.
  cholmod_sparse view(int stype) {
    cholmod_sparse a{};
    a.nrow = a.ncol = start.size() - 1;
    a.nzmax = row.size();
    a.p = start.data();
    a.i = row.data();
    a.stype = stype;
    a.itype = CHOLMOD_LONG;
    a.xtype = CHOLMOD_PATTERN;
    a.dtype = CHOLMOD_DOUBLE;
    a.packed = 1;
    return a;
  }
};

} // namespace hvi::solver
