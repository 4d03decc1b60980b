// Calls of a kernel q(t, lag), at one point and on batches.
#include "solver/history/kernel_function.hpp"

#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hvi::solver {

KernelFunction::KernelFunction(const Expr& expression, Origin origin) {
  tape_ = compile(std::span<const Expr>(&expression, 1));
  for (const Slot s : tape_.inputs) {
    if (s != slot::t && s != slot::lag) {
      throw Failure(FailureKind::bad_kernel, origin,
                    "a memory kernel may depend on the time and the lag only");
    }
    reads_time_ = reads_time_ || s == slot::t;
  }
  tabulate(expression);
}

/// Cuts out each mittag_leffler(a, b, x) with numbers a and b: the tape of all x, and the tape of
/// the rest, which reads their values from slots that no kernel has.
void KernelFunction::tabulate(const Expr& expression) {
  std::vector<Expr> cut, arguments;
  const auto value_slot = [](std::size_t i) { return slot::probe(static_cast<int>(i)); };
  const Expr rest = transform(expression, [&](const Expr& e) {
    if (e.op() != Op::mittag_leffler || !e.args()[0].is_constant() || !e.args()[1].is_constant() ||
        e.args()[2].is_constant() || e.depends_on_any(slot::probe(0), slot::probe(1 << 20)))
      return e;
    const auto known = std::find(cut.begin(), cut.end(), e);
    const auto i = static_cast<std::size_t>(known - cut.begin());
    if (known == cut.end()) {
      const double a = e.args()[0].value(), b = e.args()[1].value();
      cut.push_back(e);
      arguments.push_back(e.args()[2]);
      tables_.push_back(
          std::make_shared<FunctionTable>([a, b](double x) { return mittag_leffler(a, b, x); }));
    }
    return Expr::variable(value_slot(i));
  });
  if (cut.empty()) return;
  arguments_ = compile(arguments);
  with_values_ = compile(std::span<const Expr>(&rest, 1));
}

double KernelFunction::operator()(double t, double lag) const {
  std::array<double, 2> values{};
  for (std::size_t i = 0; i < tape_.inputs.size(); ++i) {
    values[i] = tape_.inputs[i] == slot::t ? t : lag;
  }
  return evaluate_one(tape_, std::span<const double>(values.data(), tape_.inputs.size()),
                      workspace_);
}

Modulus KernelFunction::modulus(double t, const Strip& lags) const {
  std::array<Strip, 2> inputs{};
  for (std::size_t i = 0; i < tape_.inputs.size(); ++i)
    inputs[i] = tape_.inputs[i] == slot::t ? Strip::exactly(t) : lags;
  const Strip z = enclose(tape_, std::span(inputs.data(), tape_.inputs.size()), strips_);
  return {z.modulus(), z.state};
}

void KernelFunction::resolved_edges(double t, double low, double high,
                                    std::vector<double>& edges) const {
  struct Open {
    double low, high;
  };
  constexpr double factor = 1e3;
  constexpr std::size_t most = 4000;
  const double shortest = 1e-14 * high;
  std::size_t panels = 0;
  std::vector<Open> open{{low, high}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    const Modulus m = modulus(t, around(a, b));
    if (m.state == Strip::State::unknown) return;
    double here = 0;
    bool finite = false; // beyond the end of a table there is nothing to resolve
    for (const double x : {0.1, 0.5, 0.9}) {
      const double value = std::abs((*this)(t, a + x * (b - a)));
      finite = finite || std::isfinite(value);
      if (std::isfinite(value)) here = std::max(here, value);
    }
    const bool resolved = m.state == Strip::State::analytic && m.most <= factor * here + 1e-290;
    if (finite && !resolved && b - a > shortest && ++panels < most) {
      open.push_back({0.5 * (a + b), b});
      open.push_back({a, 0.5 * (a + b)});
      continue;
    }
    if (b < high) edges.push_back(b);
  }
}

LineFunction::LineFunction(const Expr& expression, Slot variable)
    : tape_(compile(std::span<const Expr>(&expression, 1))) {
  for (const Slot s : tape_.inputs) other_ = other_ || s != variable;
}

double LineFunction::operator()(double x) const {
  if (other_) return std::numeric_limits<double>::quiet_NaN();
  return evaluate_one(tape_, std::span<const double>(&x, tape_.inputs.size()), workspace_);
}

Modulus LineFunction::modulus(const Strip& x) const {
  const Strip z = enclose(tape_, std::span<const Strip>(&x, tape_.inputs.size()), strips_);
  return {z.modulus(), z.state};
}

void KernelFunction::evaluate(double t, std::span<const double> lags, std::span<double> out) const {
  times_.assign(reads_time_ ? lags.size() : 0, t);
  evaluate(times_, lags, out);
}

void KernelFunction::evaluate(std::span<const double> times, std::span<const double> lags,
                              std::span<double> out) const {
  const std::size_t count = lags.size();
  const auto run = [&](const Tape& tape, std::span<double> values) {
    std::vector<const double*> inputs;
    for (const Slot s : tape.inputs) {
      if (s == slot::t) {
        inputs.push_back(times.data());
      } else if (s == slot::lag) {
        inputs.push_back(lags.data());
      } else {
        inputs.push_back(table_values_.data() +
                         static_cast<std::size_t>(s - slot::probe(0)) * count);
      }
    }
    hvi::solver::evaluate(tape, inputs, count, values, workspace_);
  };
  if (tables_.empty()) return run(tape_, out);
  table_values_.resize(tables_.size() * count);
  run(arguments_, table_values_);
  for (std::size_t i = 0; i < table_values_.size(); ++i)
    table_values_[i] = (*tables_[i / count])(table_values_[i]);
  run(with_values_, out);
}

} // namespace hvi::solver
