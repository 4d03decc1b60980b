// See helper_of_run.hpp.
#include "solver/results/helper_of_run.hpp"

#include "solver/results/piece_files.hpp"

namespace hvi::solver {

std::string HelperOfRun::answer(Errand errand, std::string_view message) {
  switch (errand) {
  case Errand::write_piece:
    return write_piece(message);
  case Errand::matrices:
    return matrices_.answer(message);
  }
  return {};
}

} // namespace hvi::solver
