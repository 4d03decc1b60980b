// See metis_turn.hpp.
#include "solver/common/metis_turn.hpp"

namespace hvi::solver {

std::mutex& metis_turn() {
  static std::mutex only;
  return only;
}

} // namespace hvi::solver
