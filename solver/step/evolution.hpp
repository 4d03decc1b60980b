// The accepted state of a run, and what is known at the next time before its step is solved.
//
// A field of a plan is u, a derivative of u, or a memory w_m. At t_n each of them is
//
//   factor d + known part,   d = u_n - u_{n-1}:
//   u: 1, u_{n-1};   u^(j): by the scheme (time_scheme.hpp);   w_m: w0_m, h_m + w0_m u_{n-1}
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/discrete/memory.hpp"
#include "solver/discrete/time_scheme.hpp"
#include "solver/plan/plan.hpp"

#include <optional>
#include <variant>

namespace hvi::solver {

class Evolution {
public:
  /// At the initial time, with the state u0. `imposed`: states hold values that are no unknowns.
  Evolution(const Plan& plan, Vector u0, bool imposed);
  /// The memories begin. Before the first step.
  void start();

  const TimeGrid& grid() const { return scheme_->grid(); }
  const TimeScheme& scheme() const { return *scheme_; }
  const Memory& memory() const { return *memory_; }
  int step() const { return step_; } ///< of the state; 0: the initial one
  double t() const { return grid().t(step_); }
  const Vector& u() const { return u_; } ///< state u_n
  /// State u^(j)(t_n); at the initial time what the scheme starts from, else 0.
  void derivative(int j, Vector& out) const;
  /// Another state at the initial time: the memories begin with it. Before the first step.
  void start_from(const Vector& u0) {
    u_ = u0;
    start();
  }
  /// u'(t_0) and u''(t_0) of a problem with u''. Before the first step.
  void start_motion(const Vector& velocity, const Vector& acceleration) {
    scheme_->start_motion(velocity, acceleration);
  }
  void history_field(int m, Vector& out) const; ///< w_m(t_n)
  /// Stored history fields read so far, those before a resume too.
  std::int64_t field_reads() const;

  /// The memories find what they know of step n, unless that is not right.
  [[nodiscard]] std::optional<MemoryStop> begin_step(int n);
  /// `known`: the accepted state with the values that are imposed at t_n, of which `n_unknowns` are
  /// unknowns. After begin_step.
  void impose(int n, Eigen::Index n_unknowns, const Vector& known) {
    scheme_->impose(n, n_unknowns, known - u_);
  }
  /// What laws see of the state u that step n, which was begun, may end in: u and `others`. `d`:
  /// its increment on the unknowns; null: they have not moved.
  LawFields law_fields(int n, std::span<const int> others, const Vector& u, const Vector* d) const;
  /// The same of the accepted state; step() > 0, or a state at rest.
  LawFields law_fields(std::span<const int> others) const;

  /// The factor of each field in the step that was begun.
  Vector factors(int n) const;
  /// The same times what its forms count in the step's equation (TimeScheme::present).
  Vector in_equation(int n) const;
  /// out = - sum_f weights(f, b) (what the step's equation knows of field f), u_n = known + d.
  /// False: nothing is known that is not zero, and out is as it was. `past`: with what the equation
  /// has of the step before.
  bool known_part(int n, const DenseMatrix& weights, int b, bool past, const Vector& known,
                  Vector& out) const;
  /// The last of these of the accepted state itself, before step n: out = sum_f weights(f, b)
  /// past_f field f; false: it is zero, and out is as it was.
  bool past_part(const DenseMatrix& weights, int b, Vector& out) const;
  /// The same of the accepted state itself: out = sum_f weights(f, b) field f. `work`: any vector.
  void acting(const DenseMatrix& weights, int b, Vector& out, Vector& work) const;

  /// Step n ends in the state u with the increment d on the unknowns. Takes both and leaves any
  /// vectors in their places.
  void accept(int n, Vector& u, Vector& d);

  void save(std::ostream& out) const;
  /// Where the state is one of a run for another end, the histories go on as they are, or say that
  /// they cannot: what is read then is not to be used. True: the run was made for the same end.
  std::variant<bool, HorizonEnd> restore(std::istream& in);

private:
  std::optional<HorizonEnd> continue_memory(const MemoryExtent& earlier);
  const Vector& accepted_memory(int m) const;
  template <class Add>
  void for_past(const DenseMatrix& weights, int b, const Add& add) const;

  const Plan& plan_;
  bool imposed_;
  std::unique_ptr<TimeScheme> scheme_;
  std::optional<Memory> memory_; ///< made again where a run goes on beyond its end
  Vector u_;
  Vector shares_; ///< of the fields in a step's equation
  /// m, and w_m of the accepted state, where a law or the next step's equation asks for it.
  std::vector<std::pair<int, Vector>> accepted_memories_;
  int step_ = 0;
  std::int64_t earlier_reads_ = 0;
};

} // namespace hvi::solver
