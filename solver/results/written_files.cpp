// See written_files.hpp. Used by the Reporter.
#include "solver/results/written_files.hpp"

namespace hvi::solver {

void WrittenFiles::attempt(const std::function<void()>& write) {
  try {
    write();
  } catch (const Failure& failure) {
    if (!concerns_output(failure.kind)) throw;
    if (unwritten_) return;
    unwritten_ = failure;
    if (warn_) warn_(failure.what());
  }
}

} // namespace hvi::solver
