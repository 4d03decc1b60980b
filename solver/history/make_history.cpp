// The choice of the route: by the structure of the kernel, the horizon and the number of steps.
#include "solver/history/routes.hpp"
#include "solver/history/traits.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hvi::solver {

namespace {

constexpr std::int64_t few_steps = 200;
constexpr std::size_t most_terms = 64;

/// Where a kernel is not finite: " at t = .., s = ..".
std::string place_without_value(const KernelSpec& kernel, const HistoryOptions& options) {
  const KernelFunction q(kernel.expression, kernel.origin);
  const double t0 = options.times.empty() ? 0.0 : options.times.front();
  for (const auto& [t, lag] : sample_points(options.horizon > 0 ? options.horizon : 1.0))
    if (const double value = q(t0 + t, lag); !std::isfinite(value))
      return fmt::format(": at t = {:.6g}, s = {:.6g} it is {}", t0 + t, t0 + t - lag,
                         std::isnan(value) ? std::abs(value) : value); // its sign says nothing
  return {};
}

/// Where erfc vanishes what stands before it has overflown.
bool reads_erfc(const Expr& e) {
  return e.op() == Op::erfc || std::ranges::any_of(e.args(), reads_erfc);
}

void check_kernel(const KernelSpec& kernel, const KernelTraits& traits,
                  const HistoryOptions& options) {
  if (traits.singular_exponent >= 1) {
    throw Failure(FailureKind::bad_kernel, kernel.origin,
                  fmt::format("the memory kernel `{}` is not integrable at lag 0", kernel.name),
                  "near lag 0 it must grow slower than 1/lag, for instance like lag^-0.5");
  }
  if (!traits.finite) {
    throw Failure(
        FailureKind::bad_kernel, kernel.origin,
        fmt::format("the memory kernel `{}` is not finite at every lag up to the end time{}",
                    kernel.name, place_without_value(kernel, options)),
        std::string("a table must reach to the end time; logarithms and roots need positive "
                    "arguments") +
            (reads_erfc(kernel.expression) ? "; exp(a^2)*erfc(a) is erfcx(a), which stays finite"
                                           : ""));
  }
}

struct Choice {
  const PreparedKernel& kernel;
  std::size_t n;
  const HistoryOptions& options;
};

std::unique_ptr<History> try_recursion(const Choice& c) {
  const auto& verified = c.kernel.terms;
  if (!verified || verified->terms.size() > most_terms) return nullptr;
  const double t0 = c.options.times.empty() ? 0.0 : c.options.times.front();
  const double norm = c.kernel.norm(t0, c.options.horizon);
  const double error = norm > 0 ? verified->integral / norm : 0;
  if (!(error <= c.options.tolerance)) return nullptr; // the next route
  return make_recursion(c.kernel, verified->terms, c.n, c.options, error,
                        "the kernel is a sum of exponentials (" + c.kernel.traits.description +
                            ")");
}

/// When the fit fails: kinks that stay at their lags cut every block sooner or later.
std::unique_ptr<History> without_exponentials(const Choice& c, const std::string& failure) {
  const auto& breaks = c.kernel.traits.breaks;
  const double horizon = c.options.horizon;
  if (!breaks.empty() && (horizon <= 0 || breaks.back() > 0.25 * horizon)) {
    return make_direct(
        c.kernel, c.n, c.options,
        fmt::format("the kernel has kinks up to lag {:.4g} ({})", breaks.back(), failure));
  }
  return make_tree(c.kernel, c.n, c.options, failure);
}

std::unique_ptr<History> fit_or_tree(const Choice& c) {
  auto fit = make_fit(c.kernel, c.n, c.options);
  if (fit.history) return std::move(fit.history);
  return without_exponentials(c, "no sum of exponentials: " + fit.failure);
}

std::unique_ptr<History> automatic(const Choice& c) {
  if (auto recursion = try_recursion(c)) return recursion;
  const KernelTraits& traits = c.kernel.traits;
  if (traits.max_lag > 0) {
    return make_direct(c.kernel, c.n, c.options,
                       fmt::format("the kernel vanishes beyond lag {:.4g}: only the steps within "
                                   "are kept",
                                   traits.max_lag));
  }
  if (c.options.steps > 0 && c.options.steps < few_steps) {
    return make_direct(
        c.kernel, c.n, c.options,
        fmt::format("{} steps are too few to gain from compression", c.options.steps));
  }
  return fit_or_tree(c);
}

std::unique_ptr<History> forced_recursion(const Choice& c) {
  if (auto recursion = try_recursion(c)) return recursion;
  const KernelSpec& kernel = c.kernel.spec;
  throw Failure(
      FailureKind::bad_kernel, kernel.origin,
      fmt::format("the memory kernel `{}` is not a sum of exponentials: it has no recursion",
                  kernel.name),
      "leave the choice of the route to the program, or ask for `fit` or `tree`");
}

void check_options(const KernelSpec& kernel, const HistoryOptions& options) {
  if (options.order != 0 && options.order != 1) {
    throw Failure(FailureKind::bad_value, kernel.origin, "the order of a memory is 0 or 1");
  }
  if (!(options.tolerance > 0) || !(options.tolerance < 1)) {
    throw Failure(FailureKind::bad_value, kernel.origin,
                  "the memory tolerance must lie between 0 and 1");
  }
}

} // namespace

std::unique_ptr<History> make_history(const KernelSpec& kernel, std::size_t n,
                                      const HistoryOptions& options) {
  check_options(kernel, options);
  return make_history(prepare_kernel(kernel, options), n, options);
}

std::unique_ptr<History> make_history(const PreparedKernel& prepared, std::size_t n,
                                      const HistoryOptions& options) {
  const KernelSpec& kernel = prepared.spec;
  check_options(kernel, options);
  check_kernel(kernel, prepared.traits, options);
  const Choice choice{prepared, n, options};
  switch (options.route) {
  case HistoryRoute::automatic:
    return automatic(choice);
  case HistoryRoute::recursion:
    return forced_recursion(choice);
  case HistoryRoute::fit:
    return fit_or_tree(choice);
  case HistoryRoute::tree:
    return make_tree(prepared, n, options, "asked for");
  case HistoryRoute::direct:
    return make_direct(prepared, n, options, "asked for");
  }
  throw Failure(FailureKind::bad_value, kernel.origin, "unknown memory route");
}

} // namespace hvi::solver
