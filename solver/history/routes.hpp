// The constructors of the four routes. make_history.cpp chooses among them.
#pragma once

#include "solver/history/history.hpp"
#include "solver/history/prepared.hpp"
#include "solver/history/recognise.hpp"

namespace hvi::solver {

/// The route of the options, or the best one, for a kernel that was studied over the horizon.
std::unique_ptr<History> make_history(const PreparedKernel& kernel, std::size_t n,
                                      const HistoryOptions& options);

/// Stored fields and exact weights. A kernel that vanishes beyond a lag keeps only the fields
/// within.
std::unique_ptr<History> make_direct(const PreparedKernel& kernel, std::size_t n,
                                     const HistoryOptions& options, std::string why);

/// Exact recursion of an exponential sum; `error` is the mismatch of the terms with the kernel.
std::unique_ptr<History> make_recursion(const PreparedKernel& kernel, const ExponentialTerms& terms,
                                        std::size_t n, const HistoryOptions& options, double error,
                                        std::string why);

/// A history, or the reason why the route does not serve the kernel.
struct RouteOutcome {
  std::unique_ptr<History> history;
  std::string failure;
};

/// A fitted sum of exponentials. Fails when the fit does not meet the tolerance.
RouteOutcome make_fit(const PreparedKernel& kernel, std::size_t n, const HistoryOptions& options);

/// Moments of u over blocks of time. Serves every kernel; saves where it is smooth for old times.
std::unique_ptr<History> make_tree(const PreparedKernel& kernel, std::size_t n,
                                   const HistoryOptions& options, std::string why);

} // namespace hvi::solver
