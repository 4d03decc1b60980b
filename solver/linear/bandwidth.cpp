// See bandwidth.hpp.
#include "solver/linear/bandwidth.hpp"

#include "solver/common/clock.hpp"
#include "solver/linear/large_pages.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace hvi::solver {
namespace {

/// Sums the array in eight lanes: enough independent additions to wait for memory only.
double sum(const LargeVector<double>& array) {
  double lane[8] = {};
  for (std::size_t i = 0; i + 8 <= array.size(); i += 8)
    for (std::size_t j = 0; j < 8; ++j) lane[j] += array[i + j];
  double total = 0.0;
  for (const double value : lane) total += value;
  return total;
}

} // namespace

double read_bandwidth(int megabytes) {
  const std::size_t count = static_cast<std::size_t>(std::max(megabytes, 1)) * (1u << 17);
  LargeVector<double> array(count);
  std::fill(array.begin(), array.end(), 1.0);
  double best = std::numeric_limits<double>::infinity();
  double checksum = 0.0;
  for (int pass = 0; pass < 3; ++pass) {
    const double start = cpu_seconds(); // what other programs take is not counted
    double seconds = 0.0;
    int times = 0; // a clock that ticks every 10 ms may show nothing of one
    for (; seconds == 0.0; ++times) {
      checksum += sum(array);
      seconds = cpu_seconds() - start;
    }
    best = std::min(best, seconds / times);
  }
  // The sum is used, so that the passes cannot be left out.
  return checksum > 0.0 ? 8.0 * static_cast<double>(count) / best : 0.0;
}

} // namespace hvi::solver
