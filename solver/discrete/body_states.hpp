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

#include <map>
#include <optional>
#include <string_view>
#include <vector>

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

/// What a form reads of states, and the points at which it does.
struct StateReading {
  bool uniform = false;     ///< they are the same everywhere, and the points are of the form's rule
  Rule rule = Rule::gauss;  ///< else the rule of their points inside cells
  std::vector<Slot> states; ///< which ones, in order
  int time = -1;            ///< which of these is the time itself; -1: none
};
StateReading reading_of(const Problem& problem, const Discretisation& d, const FormTerm& form);
/// The form at the points of its states, which may be known. Keeps references to the space and the
/// form.
PointForm point_form(const Discretisation& d, const FormTerm& form, const StateReading& reading,
                     const LawPoints* known = nullptr);

/// The values of the states that a form reads, as its coefficients read them.
class StateColumns {
public:
  /// `values`: of each state of the reading, of the points or, if it is uniform, one; they stay
  /// where they are.
  StateColumns(const StateReading& reading, std::vector<const double*> values, std::size_t points);
  Pointwise::Columns columns();
  const double* time() const { return reading_.time < 0 ? nullptr : values_[reading_.time]; }

private:
  const StateReading& reading_;
  std::vector<const double*> values_;
  std::size_t points_;
  std::map<std::size_t, std::vector<double>> everywhere_;
};

/// The base matrices that change with states.
class ChangingForms {
public:
  ChangingForms() = default;
  /// Of the operators' forms that do; none: nothing is kept. Throws Failure(bad_value) where the
  /// states of a form live at the points of a law.
  ChangingForms(const Problem& problem, const Discretisation& d, const Contact& contact,
                const Operators& operators);

  bool none() const { return forms_.empty(); }
  /// Sets the operators' matrices to those of contact.state_values: here, or where several
  /// processes have their rows, by these.
  void take(const Contact& contact, const StateLayout& layout, Operators& operators);

private:
  struct Changing {
    int base = 0;
    StateReading reading;
    std::optional<PointForm> form;             ///< none: several processes have it
    std::vector<std::vector<int>> points_of{}; ///< by process: which of the points are its
  };
  std::vector<double> states_of(int process, const Contact& contact) const;
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
  std::vector<std::pair<StateReading, PointForm>> forms_;
};

/// matrix_of_field (operators.hpp) with the states at hand.
SparseMatrix matrix_of_field(const Problem& problem, const Discretisation& d, int field,
                             const Contact& contact, const Vector& states);

} // namespace hvi::solver
