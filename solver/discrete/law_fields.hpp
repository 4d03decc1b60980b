// The fields that laws see in a state.
#pragma once

#include "solver/discrete/state.hpp"
#include "solver/plan/problem.hpp"

#include <vector>

namespace hvi::solver {

/// What the laws see of a state: u, and the other fields that laws act on or read.
class LawFields {
public:
  /// Keeps a reference to u.
  explicit LawFields(const Vector& u) : u_(u) {}
  /// A field besides u, and its factor s of the increment.
  void add(int field, double factor, Vector value);
  const Vector& operator[](int field) const;
  double factor(int field) const;

private:
  struct Other {
    int field;
    double factor;
    Vector value;
  };
  const Other& other(int field) const;
  const Vector& u_;
  std::vector<Other> others_;
};

} // namespace hvi::solver
