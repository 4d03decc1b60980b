// bench_step SCRIPT [NAME=VALUE ...]: one step of a script against one solve with the same factor
// and the products a step needs, all in this process. Prints CPU seconds (medians) as JSON.
//
//   step     Stepper::advance: history, right-hand side, both triangular solves, inequality,
//   certificate solve    the reduction and the back substitution of the same factor (solver/linear)
//   cholmod  cholmod_l_solve with a factor of the same matrix as CHOLMOD orders it by itself
//   product  y = T x with one matrix of the forms; a step needs one for the right-hand side per
//            matrix that acts on something known, and one for its residual
//
// bench_step --precision SCRIPT [NAME=VALUE ...]: CPU seconds of all steps of a run, the first
// factor among them, whose corrections read it in reduced precision, and of the same steps in
// double precision; medians of alternating runs.
#include "lang/diag/render.hpp"
#include "lang/session.hpp"
#include "solver/common/clock.hpp"
#include "solver/linear/factorisation.hpp"
#include "solver/step/step.hpp"

#include <Eigen/CholmodSupport>
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace {

using namespace hvi::solver;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// Median CPU time of some calls.
template <class F>
double timed(int repeats, F&& call) {
  std::vector<double> seconds;
  for (int i = 0; i < repeats; ++i) {
    const double start = cpu_seconds();
    call();
    seconds.push_back(cpu_seconds() - start);
  }
  return median(seconds);
}

double cholmod_solve(const SparseMatrix& k, const Vector& b, int repeats) {
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower> llt;
  llt.compute(Eigen::SparseMatrix<double>(k));
  Vector x;
  return timed(repeats, [&] { x = llt.solve(b); });
}

int measure(const Plan& plan) {
  Discretisation discretisation;
  discretise(plan, discretisation);
  Timing timing;
  Stepper stepper(plan, discretisation, timing);
  std::vector<double> steps;
  for (int n = 1; n <= stepper.state().evolution.grid().steps(); ++n) {
    const double start = cpu_seconds();
    if (!stepper.advance(n).certified) return 1;
    if (n > 1) steps.push_back(cpu_seconds() - start); // the first one factors
  }
  const Operators& operators = stepper.state().formulation->operators();
  const SparseMatrix k = combine(operators, stepper.state().balance.coefficients(1));
  const auto factor = analyse(k, stepper.state().contact().unknowns, operators.symmetric);
  factor->factor(k);
  const Vector b = Vector::LinSpaced(k.rows(), -1.0, 1.0);
  const Vector known = Vector::LinSpaced(operators.bases[0].cols(), -1.0, 1.0);
  Vector x, y = b, scale = b;
  const int repeats = std::max(15, static_cast<int>(steps.size()));
  const double solve = timed(repeats, [&] { hvi::solver::solve(*factor, b, x); });
  const double cholmod = cholmod_solve(k, b, repeats);
  const double product = timed(repeats, [&] { y.noalias() = operators.bases[0] * known; });
  const double residual = timed(repeats, [&] { gap_and_scale(k, x, b, y, scale); });
  WorkCounters work;
  stepper.account(work, timing);
  const double products = double(work.products) / stepper.state().evolution.grid().steps();
  fmt::print(
      "{{\"unknowns\": {}, \"contact\": {}, \"step\": {:.4g}, \"solve\": {:.4g}, "
      "\"cholmod\": {:.4g}, \"product\": {:.4g}, \"residual\": {:.4g}, \"products\": {:.3g}, "
      "\"newton\": {:.3g}, \"factor_bytes\": {:.4g}}}\n",
      k.rows(), stepper.state().contact().unknowns.size(), median(steps), solve, cholmod, product,
      residual, products, double(work.newton) / stepper.state().evolution.grid().steps(),
      factor->statistics().nonzeros * 8.0);
  return 0;
}

/// CPU seconds of all steps; negative: one of them is not certified.
double seconds_of_steps(const Plan& plan) {
  Discretisation discretisation;
  discretise(plan, discretisation);
  Timing timing;
  Stepper stepper(plan, discretisation, timing);
  const double start = cpu_seconds();
  for (int n = 1; n <= stepper.state().evolution.grid().steps(); ++n)
    if (!stepper.advance(n).certified) return -1.0;
  return cpu_seconds() - start;
}

int compare_precisions(Plan plan) {
  constexpr int runs = 5;
  std::vector<double> mixed, in_double;
  for (int i = 0; i < runs; ++i)
    for (const bool reduced : {true, false}) {
      plan.options.reduced_precision = reduced;
      const double seconds = seconds_of_steps(plan);
      if (seconds < 0.0) return 1;
      (reduced ? mixed : in_double).push_back(seconds);
    }
  fmt::print("{{\"mixed\": {:.4g}, \"double\": {:.4g}}}\n", median(mixed), median(in_double));
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  const bool precision = argc > 1 && std::string_view(argv[1]) == "--precision";
  if (precision) ++argv, --argc;
  if (argc < 2) return 2;
  hvi::lang::CompileSettings settings;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    settings.defines[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
  }
  hvi::lang::Session session(argv[1], settings);
  const hvi::lang::Exit code = session.compile();
  const hvi::lang::Script& script = session.script;
  fmt::print(stderr, "{}", hvi::lang::render(script.diagnostics, script.sources));
  if (code != hvi::lang::exit_ok) return code;
  return precision ? compare_precisions(*script.plan) : measure(*script.plan);
}
