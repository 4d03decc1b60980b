// The choice of the route: by the structure of the kernel, the horizon and the number of steps.
#include "solver/history/routes.hpp"
#include "solver/history/traits.hpp"

#include <fmt/format.h>

namespace hvi::solver {

namespace {

constexpr std::int64_t few_steps = 200;
constexpr std::size_t most_terms = 64;

void check_kernel(const KernelSpec& kernel, const KernelTraits& traits) {
  if (traits.singular_exponent >= 1) {
    throw Failure(FailureKind::bad_kernel, kernel.origin,
                  fmt::format("the memory kernel `{}` is not integrable at lag 0", kernel.name),
                  "near lag 0 it must grow slower than 1/lag, for instance like lag^-0.5");
  }
  if (!traits.finite) {
    throw Failure(
        FailureKind::bad_kernel, kernel.origin,
        fmt::format("the memory kernel `{}` is not finite at every lag up to the end time",
                    kernel.name),
        "a table must reach to the end time; logarithms and roots need positive arguments");
  }
}

struct Choice {
  const PreparedKernel& kernel;
  std::size_t n;
  const HistoryOptions& options;
};

std::unique_ptr<History> try_recursion(const Choice& c) {
  const auto verified = verified_terms(c.kernel.spec.expression, c.options.horizon);
  if (!verified || verified->terms.size() > most_terms) return nullptr;
  return make_recursion(c.kernel, verified->terms, c.n, c.options, verified->error,
                        "the kernel is a sum of exponentials (" + c.kernel.traits.description +
                            ")");
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
  auto fit = make_fit(c.kernel, c.n, c.options);
  if (fit.history) return std::move(fit.history);
  return make_direct(c.kernel, c.n, c.options, "no faster route applies");
}

} // namespace

std::unique_ptr<History> make_history(const KernelSpec& kernel, std::size_t n,
                                      const HistoryOptions& options) {
  const KernelTraits traits = kernel_traits(kernel.expression, options.horizon);
  check_kernel(kernel, traits);
  const PreparedKernel prepared(kernel, traits);
  const Choice choice{prepared, n, options};
  switch (options.route) {
  case HistoryRoute::direct:
    return make_direct(prepared, n, options, "asked for");
  case HistoryRoute::recursion:
    if (auto recursion = try_recursion(choice)) return recursion;
    throw Failure(FailureKind::bad_kernel, kernel.origin,
                  fmt::format("the memory kernel `{}` is not a sum of exponentials: it has no "
                              "recursion",
                              kernel.name),
                  "leave the choice of the route to the program, or ask for `fit` or `tree`");
  case HistoryRoute::fit: {
    auto fit = make_fit(prepared, n, options);
    if (fit.history) return std::move(fit.history);
    break;
  }
  case HistoryRoute::automatic:
  case HistoryRoute::tree:
    break;
  }
  return automatic(choice);
}

} // namespace hvi::solver
