// Values of finite element fields at blocks of points, for tapes.
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/fem/pointwise.hpp"

namespace hvi::solver {

/// The columns of the field slots among `slots`: sum_i D(phi_i)(x_p) u_i.
class FieldColumns {
public:
  /// Throws Failure(bad_value) for components the space does not have.
  FieldColumns(const Space& space, std::span<const Slot> slots);
  /// Throws Failure(bad_value) when a field is absent.
  void fill(const PointBlock& block, const FieldValues& values);
  /// nullptr for a slot that is not a field.
  const double* column(Slot slot) const;
  bool empty() const { return columns_.empty(); }

private:
  struct Column {
    Slot slot;
    int field;
    Derivative derivative;
    std::vector<double> values;
  };
  const Space& space_;
  std::vector<Column> columns_;
  std::vector<const Vector*> vectors_; ///< of the columns, while they are filled
  bool gradients_ = false;
};

/// Evaluates expressions of position, normal, t, parts and fields at blocks of points.
class FieldTape {
public:
  FieldTape(const Space& space, std::span<const Expr> expressions);
  /// out[o * n + p]; resized.
  void evaluate(const PointBlock& block, const FieldValues& values, std::vector<double>& out);
  std::size_t outputs() const { return outputs_; }

private:
  Pointwise tape_;
  FieldColumns columns_;
  std::size_t outputs_;
};

} // namespace hvi::solver
