// Laws of straight pieces from an extrapolated guess, where the inverse of the linearised operator
// is kept and updated: against cold starts, which know nothing of it, and after a restart.
#include "problems.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace hvi::solver::test {
namespace {

const KnownLaw& law_named(const std::string& name) {
  static const auto all = known_laws();
  for (const auto& law : all)
    if (law.name == name) return law;
  throw std::logic_error("no such law");
}

/// A chain of springs; each point touches its own unknown, or half of its neighbour's, too.
Bench line(int n, const std::vector<std::string>& laws, bool shared) {
  Bench setup;
  setup.s = 40.0 * chain(n, 0.3);
  std::vector<int> ids;
  for (const auto& name : laws) ids.push_back(setup.law(law_named(name).spec));
  for (int i = 0; i < n; ++i) {
    std::vector<std::pair<int, double>> row{{i, 1.0}};
    if (shared && i + 1 < n) row = {{i, 0.5}, {i + 1, 0.5}};
    setup.point(ids[i % ids.size()], 0.2, {row}, {0.01 * (i % 3)});
  }
  setup.finish();
  return setup;
}

/// Grows, falls and grows again, harder at one end: points cross the pieces to and fro.
Vector load_at(int n, double t) {
  Vector r(n);
  for (int i = 0; i < n; ++i)
    r[i] = 14.0 * (std::sin(4.0 * t) + 0.3 * t) * (0.2 + std::exp(-3.0 * i / n));
  return r;
}

/// Steps with guesses from the last three of them, as a run makes them.
class Steps {
public:
  Steps(const Bench& setup, int count)
      : setup_(setup), count_(count), op_(dense_operator(setup.s, true)),
        solver_(setup.problem, *op_, {}) {}

  InequalityReport step(int k) {
    if (c_.size() >= 3) {
      const auto n = c_.size();
      state.c_guess = 3.0 * (c_[n - 1] - c_[n - 2]) + c_[n - 3];
      state.xi_guess = 2.0 * xi_[n - 1] - xi_[n - 2];
    }
    const auto report = solver_.solve(load_at(static_cast<int>(setup_.s.rows()), time(k)), state);
    c_.push_back(state.c), xi_.push_back(state.xi);
    state.c_guess.resize(0), state.xi_guess.resize(0);
    return report;
  }
  double time(int k) const { return static_cast<double>(k) / count_; }

  InequalityState state;
  InequalitySolver& solver() { return solver_; }
  std::vector<Vector> c_, xi_;

private:
  const Bench& setup_;
  int count_;
  std::unique_ptr<ReducedOperator> op_;
  InequalitySolver solver_;
};

struct Counts {
  int factorisations = 0, iterations = 0, changes = 0;
};

Counts expect_cold_starts(Bench& setup, const std::vector<std::string>& laws, int count) {
  std::vector<const KnownLaw*> known;
  for (const auto& name : laws) known.push_back(&law_named(name));
  Counts out;
  Steps steps(setup, count);
  for (int k = 1; k <= count; ++k) {
    const auto before = steps.state.state;
    setup.r = load_at(static_cast<int>(setup.s.rows()), steps.time(k));
    const auto report = steps.step(k);
    EXPECT_TRUE(report.converged) << k << ": " << report.verdict;
    const auto found = recompute(setup, known, steps.state);
    EXPECT_LE(found.residual, 1e-11) << k;
    EXPECT_LE(found.inclusion, 1e-10) << k;
    const auto fresh = dense_operator(setup.s, true);
    InequalityState cold;
    EXPECT_TRUE(InequalitySolver(setup.problem, *fresh, {}).solve(setup.r, cold).converged) << k;
    EXPECT_LE((steps.state.c - cold.c).lpNorm<Eigen::Infinity>(),
              1e-10 * (1e-3 + cold.c.lpNorm<Eigen::Infinity>()))
        << k;
    out.factorisations += report.factorisations, out.iterations += report.iterations;
    for (std::size_t p = 0; p < before.size(); ++p)
      out.changes += before[p] != steps.state.state[p];
  }
  return out;
}

TEST(Inverse, StepsWithItEqualColdStarts) {
  for (const bool shared : {false, true}) {
    Bench setup = line(90, {"slab"}, shared);
    const auto counts = expect_cold_starts(setup, {"slab"}, 150);
    EXPECT_GT(counts.changes, 90);        // points do cross the pieces,
    EXPECT_LE(counts.factorisations, 30); // and few steps factor for that
    EXPECT_GE(counts.iterations, 150);
  }
}

TEST(Inverse, JumpsGoTheGeneralWay) {
  const std::vector<std::string> laws{"slab", "clamped", "absolute value"};
  Bench setup = line(70, laws, false);
  const auto counts = expect_cold_starts(setup, laws, 120);
  EXPECT_GT(counts.changes, 50);
  EXPECT_GT(counts.factorisations, 0);
}

TEST(Inverse, ARestoredSolverGoesOnWithTheSameBits) {
  const Bench setup = line(64, {"slab"}, false);
  Steps whole(setup, 120), first(setup, 120), second(setup, 120);
  std::stringstream bytes;
  for (int k = 1; k <= 120; ++k) {
    whole.step(k);
    (k <= 70 ? first : second).step(k);
    if (k != 70) continue;
    first.solver().save(bytes);
    second.solver().restore(bytes);
    second.state = first.state, second.c_ = first.c_, second.xi_ = first.xi_;
  }
  EXPECT_EQ(whole.state.c, second.state.c);
  EXPECT_EQ(whole.state.xi, second.state.xi);
}

} // namespace
} // namespace hvi::solver::test
