// The laws in the steps of a run, and their unknowns.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/certificate.hpp"
#include "solver/formulation/formulation.hpp"
#include "solver/step/evolution.hpp"
#include "solver/step/point_states.hpp"

namespace hvi::solver {

class StepLaws {
public:
  /// Keeps references to problem, evolution and contact.
  StepLaws(const Problem& problem, double tolerance, const Evolution& evolution, Contact& contact);

  /// States the laws' problem about the state u of step n; bounds of coupled laws are those of the
  /// present multipliers, what laws read is as it was. `d`: the increment of the
  /// unknowns, where u has it already.
  void prepare(int n, const Vector& u, const Vector* d = nullptr);
  /// Laws read the state u with the increment d that step n may end in (null: the unknowns have not
  /// moved), and the present multipliers.
  void read_solution(int n, const Vector& u, const Vector* d = nullptr);
  /// Step n follows the branch that the last state is on.
  void start_path(int n);
  /// Prepares the laws about u, with the present multipliers, and returns the error of their
  /// inclusion at u with the increment d.
  double settle_bounds(int n, const Vector& u, const Vector& d, Vector& z);
  /// Of the present multipliers, at the state u of step n with the increment d. Throws
  /// Failure(not_certified) where imposed values take a law to where it is infinite.
  Inclusion inclusion(int n, const Vector& u, const Vector& d, Vector& z) const;
  /// Of the present states with the present multipliers, at the state u with the increment d.
  StateError state_error(const Vector& u, const Vector& d) const;

  /// The multipliers at the initial time, where they are known.
  void start(const Vector& xi) {
    now.xi = accepted_.xi = xi;
    start_known_ = true;
  }
  /// Does the run start in a balance of forces?
  bool start_known() const { return start_known_; }
  /// The attempt ends its step.
  void accept(int n) {
    accepted_ = now;
    states.accept(n);
  }
  /// The last accepted step's multipliers and states hold again.
  void give_up() {
    now = accepted_;
    states.give_up();
  }
  const InequalityState& accepted() const { return accepted_; }
  InequalityState now; ///< of the last attempt
  PointStates states;

  void save(StateWriter& w) const;
  void restore(StateReader& r);
  /// The same, saved by a run whose laws may have been other ones: the pieces that points are on
  /// are found again.
  void take_over(StateReader& r);

private:
  void read(StateReader& r);
  void refuse_impossible(double t) const;

  const Problem& problem_;
  double tolerance_;
  const Evolution& evolution_;
  Contact& contact_;
  InequalityState accepted_;
  bool start_known_ = false;
  std::vector<int> given_; ///< points whose arguments no unknown moves: imposed values make them
  Vector state_;           ///< room within a call
};

} // namespace hvi::solver
