// The tape: pointwise expressions compiled to a flat list of instructions that runs on batches of
// points, so that no hot loop walks a tree.
#pragma once

#include "solver/kernel/expr.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

struct Instruction {
  Op op;
  std::int32_t a = -1, b = -1, c = -1; ///< registers of the arguments; for `slot`, a is the input
  double value = 0.0;                  ///< of a constant
};

/// outputs[o] = f_o(inputs) for a batch of points. Register r is written by code[r].
struct Tape {
  std::vector<Instruction> code;
  std::vector<std::shared_ptr<const Table>> tables; ///< code of `table` has c = its index here
  std::vector<Slot> inputs;                         ///< the slots it reads, sorted
  std::vector<std::int32_t> outputs;                ///< a register for each expression
};

/// Compiles expressions, sharing common subexpressions.
Tape compile(std::span<const Expr> expressions);

/// Scratch memory of an evaluation, reused between calls: no allocation once grown.
struct TapeWorkspace {
  std::vector<double> registers;
};

/// Evaluates at n points. inputs[i] points to n values of slot tape.inputs[i];
/// output o of point p goes to out[o * n + p].
void evaluate(const Tape& tape, std::span<const double* const> inputs, std::size_t n,
              std::span<double> out, TapeWorkspace& workspace);

/// One output at one point: values[i] of slot tape.inputs[i].
double evaluate_one(const Tape& tape, std::span<const double> values, TapeWorkspace& workspace);

} // namespace hvi::solver
