// The schemes; see time_scheme.hpp.
#include "solver/discrete/time_scheme.hpp"

#include "solver/common/numbers.hpp"
#include "solver/discrete/motion.hpp"
#include "solver/linear/vector_stream.hpp"

#include <algorithm>
#include <set>

namespace hvi::solver {
namespace {

constexpr int most_factors = 4;

class Static final : public TimeScheme {
public:
  using TimeScheme::TimeScheme;
  double factor(int, int) const override { return 0.0; }
  void derivative(int, int, Vector& out) const override { out.setZero(last().size()); }
  void accept(int, Vector&) override {} // there is no second step
};

class BackwardEuler : public TimeScheme {
public:
  using TimeScheme::TimeScheme;
  double factor(int n, int derivative) const override {
    return derivative == 1 ? 1.0 / grid().length(n) : 0.0;
  }
};

class Bdf2 final : public BackwardEuler {
public:
  using BackwardEuler::BackwardEuler;
  double factor(int n, int derivative) const override {
    return derivative == 1 ? bdf2_at(grid(), n).factor : 0.0;
  }
  KnownTerms known(int n, int derivative) const override {
    const double carry = bdf2_at(grid(), n).carry;
    if (derivative != 1 || carry == 0.0) return {};
    return {KnownTerm{-carry, &last()}};
  }
  void derivative(int n, int derivative, Vector& out) const override {
    BackwardEuler::derivative(n, derivative, out);
    const double carry = bdf2_at(grid(), n).carry;
    if (derivative == 1 && carry != 0.0) out -= carry * before();
  }
};

} // namespace

Bdf2Weights bdf2_at(const TimeGrid& grid, int n) {
  // The increment of a step so much shorter than the next says nothing of the slope there: such
  // steps stand for jumps of the data, and BDF2 would carry the jump on.
  constexpr double begins_anew = 100.0;
  const double k = grid.length(n);
  const double w = n > 1 ? k / grid.length(n - 1) : infinity;
  if (w > begins_anew) return {1.0 / k, 0.0};
  return {(1 + 2 * w) / ((1 + w) * k), w * w / ((1 + w) * k)};
}

KnownTerms TimeScheme::known(int, int) const { return {}; }
double TimeScheme::present(int) const { return 1.0; }
double TimeScheme::past(int) const { return 0.0; }
void TimeScheme::start_motion(const Vector&, const Vector&) {}

void TimeScheme::derivative(int n, int derivative, Vector& out) const {
  out = factor(n, derivative) * last_;
}

void TimeScheme::start(int n_state) { last_ = before_ = Vector::Zero(n_state); }

void TimeScheme::accept(int, Vector& d) {
  before_.swap(last_);
  last_.swap(d);
}

void TimeScheme::save(StateWriter& w) const {
  put_vector(w, last_);
  put_vector(w, before_);
}

void TimeScheme::restore(StateReader& r) {
  get_vector(r, last_, last_.size());
  get_vector(r, before_, before_.size());
}

std::unique_ptr<TimeScheme> make_scheme(const Problem& problem) {
  const TimeSpec& spec = problem.time;
  if (spec.is_static) return std::make_unique<Static>(spec);
  if (in_motion(problem)) return scheme_of_motion(spec);
  if (spec.scheme == Scheme::bdf2) return std::make_unique<Bdf2>(spec);
  return std::make_unique<BackwardEuler>(spec);
}

Vector present_shares(const TimeScheme& scheme, int n_fields) {
  Vector out(n_fields);
  for (int f = 0; f < n_fields; ++f) out[f] = scheme.present(is_memory(f) ? 0 : f);
  return out;
}

int useful_factors(const TimeScheme& scheme) {
  std::set<double> seen;
  bool comes_back = false;
  for (int n = 1; n <= scheme.grid().steps(); ++n) {
    const double rate = scheme.factor(n, 1);
    const bool fresh = seen.insert(rate).second;
    comes_back = comes_back || (!fresh && rate != scheme.factor(std::max(n - 1, 1), 1));
  }
  return comes_back ? std::min(most_factors, static_cast<int>(seen.size())) : 1;
}

} // namespace hvi::solver
