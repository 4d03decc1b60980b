// Any bytes as a table: a table or std::invalid_argument, nothing else.
#include "solver/kernel/table.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

using namespace hvi::solver;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto kind =
      data[0] % 2 == 0 ? Table::Interpolation::linear : Table::Interpolation::monotone_cubic;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    const Table table = parse_table("fuzz", text, kind);
    for (const double x : table.abscissae())
      if (std::isnan(table.value(x)) || std::isnan(table.slope(x))) std::abort();
  } catch (const std::invalid_argument&) {
    return 0;
  }
  return 0;
}
