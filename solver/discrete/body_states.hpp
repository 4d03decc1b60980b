// States at quadrature points inside bodies, and the forms whose coefficients they change: damage,
// ageing, swelling stiffness.
//
// With one point in each cell where P1 forms and rates read gradients only (these are constant in a
// cell), else with the Gauss rule of the forms. A form's matrix is that of the states at hand.
// Forms that read states only which are the same everywhere, as time is, are integrated by their
// own rule.
#pragma once

#include "solver/assembly/point_form.hpp"
#include "solver/discrete/contact.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/operators.hpp"

#include <string_view>

namespace hvi::solver {

/// The same everywhere at every time, as time itself is: begun with one value and changed by one.
bool is_uniform(const StateTerm& state);
/// Do its coefficients depend on states?
bool reads_states(const FormTerm& form);
/// The form with the initial states, which are functions of x.
FormTerm at_initial_states(const Problem& problem, const FormTerm& form);

/// The states that a form or load of a part reads. Throws Failure(bad_value) where they live at the
/// points of a law.
const StateGroup& body_group(const Problem& problem, const Contact& contact, int part,
                             Origin origin, std::string_view what);

/// The same for a reader that was found to read states which live at the points of a law.
[[noreturn]] void throw_not_in_body(const Problem& problem, int part, Origin origin,
                                    std::string_view what);

/// Where the states of a part of cells live, on which no law acts, and algebraic ones of any part.
std::shared_ptr<const BodyPoints> make_body_points(const Problem& problem, const Discretisation& d,
                                                   const StateTerm& state);
/// Adds the rows that take a state of the run to the inputs of a group's rates.
void add_body_trace(const Discretisation& d, const StateLayout& layout, const StateGroup& group,
                    std::vector<Eigen::Triplet<double>>& entries);

/// The base matrices that change with states.
class ChangingForms {
public:
  ChangingForms() = default;
  /// Of the operators' forms that do; none: nothing is kept. Throws Failure(bad_value) where the
  /// states of a form live at the points of a law.
  ChangingForms(const Problem& problem, const Discretisation& d, const Contact& contact,
                const Operators& operators);

  bool none() const { return forms_.empty(); }
  /// Sets the operators' matrices to those of contact.state_values.
  void take(const Contact& contact, const StateLayout& layout, Operators& operators);

private:
  struct Changing {
    int base = 0;
    const FormTerm* term = nullptr;
    PointForm form;
  };
  const Problem* problem_ = nullptr;
  std::vector<Changing> forms_;
};

/// The forms that change with time alone: whether their coefficients are numbers at a later time.
class TimedForms {
public:
  /// Keeps references to the problem and the laws.
  TimedForms(const Problem& problem, const Discretisation& d, const Contact& contact);
  bool none() const { return forms_.empty(); }
  /// Throws as the step of a run to time t would.
  void check(double t);

private:
  const Problem& problem_;
  const Contact& contact_;
  std::vector<std::pair<const FormTerm*, PointForm>> forms_;
};

/// matrix_of_field (operators.hpp) with the states at hand.
SparseMatrix matrix_of_field(const Problem& problem, const Discretisation& d, int field,
                             const Contact& contact, const Vector& states);

} // namespace hvi::solver
