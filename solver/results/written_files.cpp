// See written_files.hpp. Used by the Reporter.
#include "solver/results/written_files.hpp"

namespace hvi::solver {

bool WrittenFiles::attempt(const std::function<void()>& write) {
  try {
    write();
    return true;
  } catch (const Failure& failure) {
    if (!concerns_output(failure.kind)) throw;
    if (!unwritten_) {
      unwritten_ = failure;
      if (warn_) warn_(failure.what());
    }
    return false;
  }
}

} // namespace hvi::solver
