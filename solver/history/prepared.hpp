// What every route needs of a kernel: its traits, its values and its exact weights.
#pragma once

#include "solver/history/history.hpp"
#include "solver/history/integral.hpp"
#include "solver/history/traits.hpp"

#include <array>
#include <cmath>
#include <memory>

namespace hvi::solver {

/// A kernel with everything found out about it.
struct PreparedKernel {
  PreparedKernel(const KernelSpec& spec_, StudiedKernel studied)
      : spec(spec_), traits(std::move(studied.traits)), terms(std::move(studied.terms)),
        function(spec_.expression, spec_.origin), breaks(spec_.expression, spec_.origin),
        integral(spec_.expression, function, breaks, traits.singular_exponent, spec_.origin,
                 spec_.name) {}
  /// sup over the times up to t0 + horizon of int |q| over the lags since t0.
  double norm(double t0, double horizon) const;

  KernelSpec spec;
  KernelTraits traits;
  std::optional<VerifiedTerms> terms; ///< of an exponential sum
  KernelFunction function;
  Breaks breaks;
  KernelIntegral integral;
};

/// The exact weights last asked for: a uniform grid asks for the same ones in every step. A cached
/// weight is a function of its key, so it is no part of the saved state.
class WeightCache {
public:
  Moments operator()(const PreparedKernel& kernel, double t, double low, double high) {
    // A convolution may be written with t, exp(-t) exp(s): always asked at 0, it has one value.
    const Key key{kernel.traits.convolution ? 0.0 : t, low, high};
    for (const Entry& e : entries_) {
      if (e.key == key) return e.value;
    }
    const Entry entry{key, kernel.integral(key.t, low, high)};
    entries_[next_] = entry;
    next_ = (next_ + 1) % entries_.size();
    return entry.value;
  }

private:
  struct Key {
    double t = 0, low = -1, high = -1;
    bool operator==(const Key&) const = default;
  };
  struct Entry {
    Key key;
    Moments value;
  };
  std::array<Entry, 32> entries_{};
  std::size_t next_ = 0;
};

/// A kernel in the form that is computed with, studied over the times of the options.
PreparedKernel prepare_kernel(const KernelSpec& kernel, const HistoryOptions& options);

/// Checks what every route asks of a step; throws Failure(bad_value).
void check_step(const PreparedKernel& kernel, double t_before, double t_new);
void check_field(const PreparedKernel& kernel, std::size_t expected, std::size_t given);

} // namespace hvi::solver
