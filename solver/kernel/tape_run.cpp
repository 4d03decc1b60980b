// Runs a tape: on blocks of points that keep all registers in the cache, or at one point.
#include "solver/kernel/scalar.hpp"
#include "solver/kernel/table.hpp"
#include "solver/kernel/tape.hpp"

#include <algorithm>
#include <stdexcept>

namespace hvi::solver {

namespace {

constexpr std::size_t block = 128;

/// out[p] = f(...) for one block. Plain counted loops: the compiler vectorises the arithmetic ones;
/// those with a count are worth more than a vector, and a short block runs them as often as needed.
template <class F>
void loop(double* out, const double* a, F f) {
  for (std::size_t p = 0; p < block; ++p) out[p] = f(a[p]);
}
template <class F>
void loop(double* out, const double* a, const double* b, F f) {
  for (std::size_t p = 0; p < block; ++p) out[p] = f(a[p], b[p]);
}
template <class F>
void loop(double* out, const double* a, const double* b, const double* c, F f) {
  for (std::size_t p = 0; p < block; ++p) out[p] = f(a[p], b[p], c[p]);
}

template <class F>
void counted(std::size_t count, double* out, const double* a, F f) {
  for (std::size_t p = 0; p < count; ++p) out[p] = f(a[p]);
}

/// a^b where b is one constant for the whole block.
void constant_power(std::size_t count, double* out, const double* a, double exponent) {
  if (exponent == 2.0) return loop(out, a, [](double x) { return x * x; });
  if (is_multiplied_power(exponent)) {
    const int n = static_cast<int>(exponent);
    return loop(out, a, [n](double x) { return integer_power(x, n); });
  }
  counted(count, out, a, [exponent](double x) { return std::pow(x, exponent); });
}

/// Operations without arithmetic worth vectorising.
void general(Op op, std::size_t count, double* out, const double* a, const double* b,
             const double* c) {
  for (std::size_t p = 0; p < count; ++p) out[p] = apply(op, a[p], b ? b[p] : 0.0, c ? c[p] : 0.0);
}

void run(const Tape& tape, const Instruction& i, double* registers, std::size_t count,
         double* out) {
  const auto at = [registers](std::int32_t r) {
    return r < 0 ? nullptr : registers + static_cast<std::size_t>(r) * block;
  };
  const double *a = at(i.a), *b = at(i.b);
  switch (i.op) {
  case Op::add:
    return loop(out, a, b, [](double x, double y) { return x + y; });
  case Op::mul:
    return loop(out, a, b, [](double x, double y) { return x * y; });
  case Op::div:
    return loop(out, a, b, [](double x, double y) { return x / y; });
  case Op::neg:
    return loop(out, a, [](double x) { return -x; });
  case Op::pow: {
    const Instruction& exponent = tape.code[static_cast<std::size_t>(i.b)];
    if (exponent.op == Op::constant) return constant_power(count, out, a, exponent.value);
    return loop(out, a, b, scalar_power);
  }
  case Op::min:
    return loop(out, a, b, scalar_min);
  case Op::max:
    return loop(out, a, b, scalar_max);
  case Op::abs:
    return loop(out, a, [](double x) { return std::abs(x); });
  case Op::sign:
    return loop(out, a, scalar_sign);
  case Op::sqrt:
    return loop(out, a, [](double x) { return std::sqrt(x); });
  case Op::less:
    return loop(out, a, b, scalar_less);
  case Op::less_equal:
    return loop(out, a, b, scalar_less_equal);
  case Op::equal:
    return loop(out, a, b, scalar_equal);
  case Op::logic_and:
    return loop(out, a, b, scalar_and);
  case Op::logic_or:
    return loop(out, a, b, scalar_or);
  case Op::logic_not:
    return loop(out, a, scalar_not);
  case Op::select:
    return loop(out, a, b, at(i.c), scalar_select);
  case Op::table:
  case Op::table_slope: {
    const Table& table = *tape.tables[static_cast<std::size_t>(i.c)];
    const bool slope = i.op == Op::table_slope;
    return counted(count, out, a,
                   [&](double x) { return slope ? table.slope(x) : table.value(x); });
  }
  default:
    return general(i.op, count, out, a, b, at(i.c));
  }
}

void require(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(what);
}

/// All registers at one point. A law is asked point by point: a block of one would cost 128.
template <class InputAt>
const double* run_point(const Tape& tape, InputAt&& input, TapeWorkspace& workspace) {
  auto& registers = workspace.registers;
  if (registers.size() < tape.code.size()) registers.resize(tape.code.size());
  double* const r = registers.data();
  for (std::size_t k = 0; k < tape.code.size(); ++k) {
    const Instruction& i = tape.code[k];
    switch (i.op) {
    case Op::constant:
      r[k] = i.value;
      break;
    case Op::slot:
      r[k] = input(i.a);
      break;
    case Op::add:
      r[k] = r[i.a] + r[i.b];
      break;
    case Op::mul:
      r[k] = r[i.a] * r[i.b];
      break;
    case Op::table:
      r[k] = tape.tables[static_cast<std::size_t>(i.c)]->value(r[i.a]);
      break;
    case Op::table_slope:
      r[k] = tape.tables[static_cast<std::size_t>(i.c)]->slope(r[i.a]);
      break;
    default:
      r[k] = apply(i.op, r[i.a], i.b < 0 ? 0.0 : r[i.b], i.c < 0 ? 0.0 : r[i.c]);
    }
  }
  return r;
}

} // namespace

void evaluate(const Tape& tape, std::span<const double* const> inputs, std::size_t n,
              std::span<double> out, TapeWorkspace& workspace) {
  require(inputs.size() >= tape.inputs.size(), "tape: an input is missing");
  require(out.size() >= n * tape.outputs.size(), "tape: no room for the outputs");
  if (n == 1) {
    const double* r = run_point(
        tape, [&](std::int32_t i) { return *inputs[i]; }, workspace);
    for (std::size_t o = 0; o < tape.outputs.size(); ++o) out[o] = r[tape.outputs[o]];
    return;
  }
  auto& registers = workspace.registers;
  if (registers.size() < tape.code.size() * block) registers.resize(tape.code.size() * block);
  double* const r = registers.data();
  for (std::size_t k = 0; k < tape.code.size(); ++k)
    if (tape.code[k].op == Op::constant) std::fill_n(r + k * block, block, tape.code[k].value);
  for (std::size_t first = 0; first < n; first += block) {
    const std::size_t count = std::min(block, n - first);
    for (std::size_t k = 0; k < tape.code.size(); ++k) {
      const Instruction& i = tape.code[k];
      double* const target = r + k * block;
      if (i.op == Op::constant) continue;
      if (i.op != Op::slot) {
        run(tape, i, r, count, target);
        continue;
      }
      // A short last block repeats its last point, so that the loops keep a fixed length and
      // nothing is computed from uninitialised memory.
      const double* source = inputs[static_cast<std::size_t>(i.a)] + first;
      std::copy_n(source, count, target);
      std::fill(target + count, target + block, source[count - 1]);
    }
    for (std::size_t o = 0; o < tape.outputs.size(); ++o)
      std::copy_n(r + static_cast<std::size_t>(tape.outputs[o]) * block, count,
                  out.data() + o * n + first);
  }
}

double evaluate_one(const Tape& tape, std::span<const double> values, TapeWorkspace& workspace) {
  require(values.size() >= tape.inputs.size(), "tape: an input is missing");
  require(!tape.outputs.empty(), "tape: it has no output");
  const double* r = run_point(
      tape, [&](std::int32_t i) { return values[i]; }, workspace);
  return r[tape.outputs[0]];
}

} // namespace hvi::solver
