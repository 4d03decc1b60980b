// A compiled function of a law's argument r at a point of space and time.
#pragma once

#include "solver/kernel/tape.hpp"
#include "solver/law/law.hpp"
#include "solver/mesh/mesh.hpp"

#include <array>
#include <span>
#include <vector>

namespace hvi::solver {

class PointTape {
public:
  PointTape() = default;
  explicit PointTape(std::span<const Expr> expressions) : tape_(compile(expressions)) {}

  /// All outputs at (r, x, t).
  void operator()(double r, const Point& x, LawTime t, std::span<double> out) const {
    thread_local TapeWorkspace workspace;
    constexpr std::size_t most_inputs = 6 + slot::most_readings + slot::most_law_states;
    std::array<double, most_inputs> values{};
    std::array<const double*, most_inputs> inputs{};
    const std::size_t n = tape_.inputs.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Slot s = tape_.inputs[i];
      values[i] = s == slot::argument(0) ? r : t.value(s, x);
      inputs[i] = &values[i];
    }
    evaluate(tape_, {inputs.data(), n}, 1, out, workspace);
  }
  double operator()(double r, const Point& x, LawTime t) const {
    double out = 0.0;
    (*this)(r, x, t, {&out, 1});
    return out;
  }
  int outputs() const { return static_cast<int>(tape_.outputs.size()); }

private:
  Tape tape_;
};

} // namespace hvi::solver
