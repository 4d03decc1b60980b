// Memory: (R u)(t_n) = sum_{j<=n} int_{t_{j-1}}^{t_j} q(t_n, s) u(s) ds for one scalar kernel q and
// a field of n values, with exact interval integrals. One interface, four implementations (routes).
#pragma once

#include "solver/common/failure.hpp"
#include "solver/history/horizon.hpp"
#include "solver/kernel/kernel_spec.hpp"

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

struct HistoryOptions {
  HistoryRoute route = HistoryRoute::automatic;
  int order = 0;            ///< 0: u constant on a step (the paper's scheme); 1: u affine on a step
  double tolerance = 1e-8;  ///< error of the memory term relative to ||q||_L1 max|u|
  double shortest_step = 0; ///< of the time grid (0: unknown)
  double horizon = 0;       ///< T - t0 (0: unknown; the fitted route is then not chosen)
  std::int64_t steps = 0;   ///< expected number of steps (0: unknown)
  /// The planned times t_0 < t_1 < ..., which must outlive the history (empty: unknown). The tree
  /// then reads its blocks once for several steps; other times may be asked for all the same.
  std::span<const double> times = {};
};

struct HistoryReport {
  std::string route;       ///< "recursion", "fit", "tree", "direct"
  std::string why;         ///< the reason for the route, a sentence
  std::int64_t fields = 0; ///< stored fields of n values now
  std::int64_t reads = 0;  ///< fields read since the start, or since the state was restored
  double bytes = 0;
  double error = 0;               ///< verified bound, relative to ||q||_L1 max|u|
  bool verified = true;           ///< false: sampled evidence only
  std::int64_t audits = 0;        ///< steps at which a few unknowns were replayed by the direct sum
  std::int64_t audited_until = 0; ///< the last of them
  double audit = 0; ///< largest difference found, relative to ||q||_L1 max|u| of those
  double norm = 0;  ///< ||q||_L1 over the run (0: not known)
  double bound = 0; ///< error * ||q||_L1 * max|u|: of the values of the memory
};

class History {
public:
  virtual ~History() = default;
  /// Begins at t0 with u(t0) (used by order 1 only).
  virtual void start(double t0, std::span<const double> u0) = 0;
  /// out = the part of (R u)(t_new) that does not depend on u(t_new).
  virtual void rhs(double t_new, std::span<double> out) = 0;
  /// The exact weight of u(t_new): int over the current interval of q(t_new, s) [phi(s)] ds.
  virtual double w0(double t_new) = 0;
  /// Accepts u(t_new); until then nothing is remembered, so steps may be rejected and repeated.
  virtual void commit(double t_new, std::span<const double> u_new) = 0;
  virtual HistoryReport report() const = 0;
  /// HistoryReport::audit so far: cheap, to be asked in every step.
  virtual double audited() const { return 0; }
  /// Set by rhs, commit and restore where the memory cannot go on: what it gives is no result.
  virtual const HorizonEnd* ended() const { return nullptr; }
  /// Exact state, bit for bit: a restored history continues with the same bits.
  virtual void save(std::ostream& out) const = 0;
  virtual void restore(std::istream& in) = 0;
};

/// What an expression in (t, lag) is: found symbolically, checked numerically.
struct KernelTraits {
  bool zero = false;
  bool convolution = false;       ///< depends on the lag only
  bool exponential_sum = false;   ///< sum of c lag^r exp(-a lag) cos/sin(b lag)
  bool separable = false;         ///< sum g_i(t) h_i(s)
  double singular_exponent = 0.0; ///< ~ lag^-e near 0; 0: bounded; >= 1: not integrable
  std::vector<double> breaks;     ///< lags where it has kinks or jumps, sorted
  double max_lag = 0.0;           ///< it vanishes beyond (0: no such bound)
  bool finite = true;             ///< finite on (0, horizon]
  std::string description;        ///< "2 real exponentials", "singular, lag^-0.5", ...
};
/// For times t0 < t <= t0 + horizon, of a kernel as it is stated: what came as a series is not
/// looked for in the expression.
KernelTraits kernel_traits(const KernelSpec& kernel, double horizon, double t0 = 0);
/// sup |q|, the Lipschitz constant in t of H(q), int_0^T |q| for hypotheses (inf where infinite).
struct KernelNorms {
  double sup = 0, lipschitz = 0, l1 = 0;
  bool exact = false;
};
KernelNorms kernel_norms(const Expr& expression, double t0, double t1);

/// sup over t of int_0^{t - t0} |q(t, lag)| dlag, t0 < t <= t0 + horizon: what errors of a memory
/// relate to. Sampled for kernels that are no convolution.
double memory_norm(const Expr& expression, const KernelTraits& traits, double t0, double horizon);

/// Integral over s in [t - lag_high, t - lag_low] of q(t, s) weight(s), order-0 weight 1.
/// Adaptive to machine precision; integrable singularities at lag 0 included.
/// moment = 0: 1; moment = 1: (lag - lag_low) / (lag_high - lag_low).
double interval_integral(const Expr& expression, double t, double lag_low, double lag_high,
                         int moment);

/// Throws Failure(bad_kernel) for a kernel that is not integrable or not finite.
std::unique_ptr<History> make_history(const KernelSpec& kernel, std::size_t n,
                                      const HistoryOptions& options);

/// The same with an audit: `replayed` unknowns, spread evenly, are stored and summed directly at
/// the first steps, then at a geometric sequence of them, and at the last expected one. Storage is
/// bounded: after `most_audited_steps` the audit ends. A sample: evidence, not proof.
inline constexpr std::int64_t most_audited_steps = 1 << 17;
std::unique_ptr<History> make_audited_history(const KernelSpec& kernel, std::size_t n,
                                              const HistoryOptions& options,
                                              std::size_t replayed = 4);

} // namespace hvi::solver
