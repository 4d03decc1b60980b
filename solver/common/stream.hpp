// States as bytes: exact bits out, exact bits in.
#pragma once

#include "solver/common/failure.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <istream>
#include <limits>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

namespace hvi::solver {

class StateWriter {
public:
  explicit StateWriter(std::ostream& out) : out_(out) {}
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    out_.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(static_cast<std::uint64_t>(values.size()));
    out_.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(T)));
  }

private:
  std::ostream& out_;
};

/// Throws Failure(broken_file) when the bytes end early or belong to something else.
class StateReader {
public:
  explicit StateReader(std::istream& in, Origin origin) : in_(in), origin_(origin) {}
  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    in_.read(reinterpret_cast<char*>(&value), sizeof value);
    check();
    return value;
  }
  /// Reads piece by piece, so that a wrong length ends in a message and not in a huge allocation.
  template <class T>
  std::vector<T> get_vector() {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto size = get<std::uint64_t>();
    std::vector<T> values;
    constexpr std::uint64_t piece = 1 << 20;
    for (std::uint64_t done = 0; done < size; done = values.size()) {
      const auto count = std::min(piece, size - done);
      values.resize(done + count);
      in_.read(reinterpret_cast<char*>(values.data() + done),
               static_cast<std::streamsize>(count * sizeof(T)));
      check();
    }
    return values;
  }
  /// As many as there must be.
  template <class T>
  std::vector<T> get_vector(std::size_t size) {
    auto values = get_vector<T>();
    if (values.size() != size) fail("is inconsistent");
    return values;
  }
  /// A number from low to high.
  template <class T>
  T get_between(T low, T high) {
    const T value = get<T>();
    if (!(value >= low && value <= high)) fail("is inconsistent");
    return value;
  }
  /// Counters of a run: not negative, and so small that a few times one of them is still an int.
  template <std::size_t N>
  std::array<int, N> get_counts(int most = 1 << 28) {
    const auto counts = get<std::array<int, N>>();
    for (const int count : counts)
      if (count < 0 || count > most) fail("is inconsistent");
    return counts;
  }
  double get_finite() {
    constexpr double most = std::numeric_limits<double>::max();
    return get_between(-most, most);
  }
  /// Finite numbers.
  std::vector<double> get_numbers() {
    auto values = get_vector<double>();
    for (const double v : values)
      if (!std::isfinite(v)) fail("has a number that is not finite");
    return values;
  }
  /// Times in increasing order, not empty, the last one `now`.
  std::vector<double> get_times(double start, double now) {
    auto times = get_numbers();
    bool good = !times.empty() && times.front() >= start && times.back() == now;
    for (std::size_t i = 1; i < times.size(); ++i) good = good && times[i - 1] < times[i];
    if (!good) fail("is inconsistent");
    return times;
  }
  template <class T>
  void expect(const T& value, const std::string& what) {
    if (!(get<T>() == value)) fail("was saved with another " + what);
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw Failure(FailureKind::broken_file, origin_, "the saved state " + what);
  }

private:
  void check() const {
    if (!in_) fail("ends too early");
  }
  std::istream& in_;
  Origin origin_;
};

void put_text(StateWriter& w, const std::string& text);
std::string get_text(StateReader& r);

} // namespace hvi::solver
