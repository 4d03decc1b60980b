// What the law of a term reads of the solution at the term's points (LawSpec::readings).
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/discrete/law_fields.hpp"
#include "solver/kernel/tape.hpp"
#include "solver/law/law.hpp"

#include <functional>
#include <vector>

namespace hvi::solver {

/// The fields of the plan that a law reads, each once.
std::vector<int> fields_read(const LawSpec& law);
/// The law terms whose multipliers a law reads, each once.
std::vector<int> terms_read(const LawSpec& law);

/// A component, in the global frame, of the multiplier of a law term at a point.
using MultiplierAt = std::function<double(int term, int component, int point)>;
/// The size of what makes the multipliers of a law term, before anything cancels.
using MultiplierSize = std::function<double(int term)>;

class LawReadings {
public:
  /// Of the law with this index. Takes the trace of the points.
  LawReadings(const LawSpec& law, int index, LawPoints& points, const StateLayout& layout);

  int law() const { return law_; }
  std::size_t n_points() const { return points_; }
  const std::vector<int>& fields() const { return fields_; }
  /// The values at all points are those of these fields and multipliers at the time t.
  void read(double t, const LawFields& fields, const MultiplierAt& multiplier);
  Readings at(int point) const;
  /// Of a law whose slope is linear in what it reads and of nothing else, as a source: what the
  /// terms of the slope are before anything cancels, at the largest. Values of fields have the
  /// sizes of their own terms and of what forces could make of them (`reach`, by state; may be
  /// empty). A source that is zero, as the heat of friction at rest, is not judged by its own
  /// rounding. Other laws have scales of their own: 0.
  double slope_scale(const LawFields& fields, const Vector& reach,
                     const MultiplierSize& multiplier) const;

  const SparseMatrix& trace() const { return trace_; } ///< of states: what of them is read
  /// From now on fields have the entries `unknowns`, which are all that is read, and others to this
  /// size.
  void restrict_to(const std::vector<int>& unknowns, int size);

  /// Reading i of point p: values[i * points + p].
  std::vector<double> values;
  double first_scale = 0.0; ///< of the law's slopes, with what it reads at the initial time

private:
  int law_;
  std::size_t points_;
  int components_;
  std::vector<int> fields_;
  SparseMatrix trace_; ///< components of u at the points, of a state; those that are not read: 0
  std::vector<double> sizes_of(Slot input, const LawFields& fields, const Vector& reach,
                               const MultiplierSize& multiplier) const;

  Tape tape_;
  std::vector<std::vector<double>> inputs_; ///< of the tape, at every point
  /// By input of the tape: how the slope of a source changes with it.
  std::vector<Tape> slope_by_input_;
  Vector of_field_; ///< room within a call
};

} // namespace hvi::solver
