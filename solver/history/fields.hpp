// Stored fields and the loops over them. These loops are what a memory term costs: each passes over
// the memory once, in blocks of points that stay in the first-level cache.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace hvi::solver {

/// Fields of n values, one after the other in one buffer; a queue: appended at the end, dropped
/// from the front.
class FieldQueue {
public:
  explicit FieldQueue(std::size_t n = 0) : n_(n) {}
  std::size_t size() const { return count_; }
  std::span<const double> operator[](std::size_t j) const {
    return {values_.data() + (first_ + j) * n_, n_};
  }
  const double* data() const { return values_.data() + first_ * n_; }
  void push(std::span<const double> field);
  /// Reserves memory for so many fields, which otherwise grows by doubling.
  void reserve(std::size_t fields) { values_.reserve(fields * n_); }
  /// Forgets the oldest fields; the memory is reclaimed when half of it is unused.
  void drop(std::size_t count);
  void clear();
  double bytes() const { return 8.0 * static_cast<double>(values_.capacity()); }
  /// The fields kept, contiguous, for saving; and back.
  std::vector<double> packed() const;
  void unpack(std::vector<double> values);

private:
  std::size_t n_, first_ = 0, count_ = 0;
  std::vector<double> values_;
};

/// out += sum_f weights[f] fields[f * n + .]
void add_combination(std::span<const double> weights, const double* fields, std::span<double> out);

/// Some stored fields and their weights.
struct Combination {
  std::span<const double> weights;
  const double* fields;
};
/// out += all of them, in one pass over `out`.
void add_combinations(std::span<const Combination> parts, std::span<double> out);

/// `columns` fields of n values, one after the other:
/// out(., c) += sum_f weights[c * count + f] fields(., f), all of them in one pass over `fields`.
void add_columns(std::span<const double> weights, const double* fields, std::size_t count,
                 std::size_t n, std::span<double> out);

/// out = w a
void set_scaled(double w, std::span<const double> a, std::span<double> out);

/// A linear state of `dimension` fields, z <- transition z + input u + input_before u_before, of
/// which out += readout z is asked: the coefficients of one such group.
struct LinearGroup {
  std::size_t dimension = 1;
  std::vector<double> transition;   ///< dimension x dimension, by rows
  std::vector<double> input;        ///< weight of u in each component
  std::vector<double> input_before; ///< weight of u_before (order 1)
  std::vector<double> readout;
};

/// One pass over all groups: advances the states by the interval (u_before, u) and adds the
/// readout to `out`. `u_before` is empty for order 0.
void advance_and_read(std::span<const LinearGroup> groups, std::span<double> states,
                      std::span<const double> u, std::span<const double> u_before,
                      std::span<double> out);
/// out += readouts of the states as they are.
void read_states(std::span<const LinearGroup> groups, std::span<const double> states,
                 std::span<double> out);

} // namespace hvi::solver
