// What the law of a term reads of memories at the term's points (LawSpec::readings).
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/kernel/tape.hpp"
#include "solver/law/law.hpp"
#include "solver/time/law_fields.hpp"

#include <vector>

namespace hvi::solver {

/// The memories that a law reads, as fields of the plan, each once.
std::vector<int> fields_read(const LawSpec& law);

class LawReadings {
public:
  /// Takes the trace of the points.
  LawReadings(const LawSpec& law, LawPoints& points, const StateLayout& layout);

  const std::vector<int>& fields() const { return fields_; }
  /// The values at all points are those of these fields at the time t.
  void read(double t, const LawFields& fields);
  Readings at(int point) const;

  const SparseMatrix& trace() const { return trace_; } ///< of states: what of them is read
  /// From now on fields have the entries `unknowns`, which are all that is read, and others to this
  /// size.
  void restrict_to(const std::vector<int>& unknowns, int size);

  /// Reading i of point p: values[i * points + p].
  std::vector<double> values;

private:
  std::size_t points_;
  int components_;
  std::vector<int> fields_;
  SparseMatrix trace_; ///< components of u at the points, of a state; those that are not read: 0
  Tape tape_;
  std::vector<std::vector<double>> inputs_; ///< of the tape, at every point
  Vector of_field_;                         ///< room within a call
};

} // namespace hvi::solver
