// See stream.hpp.
#include "solver/common/stream.hpp"

namespace hvi::solver {

void put_text(StateWriter& w, const std::string& text) {
  w.put(std::vector<char>(text.begin(), text.end()));
}

std::string get_text(StateReader& r) {
  const auto letters = r.get_vector<char>();
  return {letters.begin(), letters.end()};
}

} // namespace hvi::solver
