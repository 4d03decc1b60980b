// One step of the fully discrete scheme: the state of a run and how it advances.
#pragma once

#include "solver/time/certificate.hpp"
#include "solver/time/interior.hpp"
#include "solver/time/memory.hpp"
#include "solver/time/predictor.hpp"
#include "solver/time/rounding.hpp"
#include "solver/time/step_matrix.hpp"
#include "solver/time/time_grid.hpp"

#include <array>
#include <list>
#include <optional>
#include <utility>

namespace hvi::solver {

/// What a step did.
struct StepResult {
  double equilibrium = 0.0; ///< componentwise backward error
  Inclusion inclusion;
  InequalityReport inequality; ///< of the last correction; iterations and events of all
  int corrections = 0;         ///< pairs of sweeps
  bool certified = false;
  /// It crossed unstable states: the branch ended, or where it was not followed, snap.hpp says so.
  bool snap = false;
  std::vector<double> branch_ends; ///< where, from 0 at the last state to 1 at this one
};

/// A check that was put off found a step without a certificate: the run starts again and makes each
/// check in its step, so that it ends there with what came before.
struct LateCheck : Failure {
  LateCheck() : Failure(FailureKind::not_certified, {}, "a check that was put off failed", "") {}
};

/// Advances u_{n-1} to u_n:  find d = u_n - u_{n-1} and xi with
///
///   K d + G^T W xi = f_n - B u_{n-1} - sum_m E_m (w0_m u_{n-1} + h_m) + A carry d_{n-1},
///   K = rate A + B + sum_m w0_m E_m,      xi_p in dj_p((G u_n)_p + offset_p(t_n))
///
/// (paper, Problem "fullydiscrete", its equation divided by the step and written for the increment:
/// no A u_{n-1} / k, so nothing cancels when the step is small). Static: the same with u_{-1} = 0.
class Stepper {
public:
  Stepper(const Plan& plan, const Discretisation& discretisation, Timing& timing);

  /// Step n (1 .. steps). Without a certificate the state stays at step n - 1.
  /// Throws Failure(not_coercive).
  StepResult advance(int n);

  /// Checks on all rows may be made together, up to the last step: for runs of which nothing is
  /// seen before that. `advance` throws LateCheck then, too.
  void let_checks_wait() { checks_wait_ = true; }
  /// Makes the checks that were put off. Throws LateCheck.
  void make_checks();
  /// All steps up to this one have had their checks.
  int checked_up_to() const { return waiting_steps_.empty() ? step_ : waiting_steps_.front() - 1; }
  /// Steps with the errors of checks that were put off; hands each out once.
  std::vector<std::pair<int, double>> late_errors() { return std::exchange(late_errors_, {}); }

  const TimeGrid& grid() const { return grid_; }
  const StateLayout& layout() const { return layout_; }
  const Operators& operators() const { return operators_; }
  const Contact& contact() const { return contact_; }
  const Memory& memory() const { return *memory_; }
  int step() const { return step_; } ///< of the state; 0: the initial one
  double t() const { return grid_.t(step_); }
  const Vector& u() const { return u_; } ///< state u_n
  void rate(Vector& out) const;          ///< state u'(t_n), by the scheme's formula
  const Vector& xi() const { return inequality_.xi; }
  const Vector& arguments() const { return z_; } ///< of the laws, at the last attempted step
  const LoadAssembler& loads() const { return *loads_; }
  /// The matrix of a form on all cells and on states, if it comes from the base matrices at the
  /// price of adding them; else empty.
  SymmetricBlocks from_bases(const FormTerm& form) const;
  /// gamma with K = sum_b gamma_b T_b in step n.
  Vector coefficients(int n) const;
  /// w_m(t_n) = h_m + w0_m u_n
  void history_field(int m, Vector& out) const;
  /// Why not every step is sure to have one solution; empty: each has (uniqueness.hpp). Found at
  /// the first step, for all of them.
  const std::string& not_unique() const { return not_unique_; }
  /// Samples of the error that rounding may have left in the state: each for a random change of
  /// the matrices and loads by a unit in the last place, and one for what the steps left of their
  /// equations; `backward_error`: of the steps so far. To be asked after the last step.
  std::vector<ErrorSample> rounding_errors(double backward_error);
  /// The condition number of the last step's matrix in the 1-norm, estimated; 0: not known.
  double condition();
  /// By what an error of every step's equation grows over the steps together (step_rounding.cpp).
  double amplification() const;
  /// The largest |u| that was seen, within a factor 1.6.
  double largest_size() const { return largest_.size; }
  /// Is every step refined with residuals in extended precision?
  bool refines() const { return refines_; }
  /// The largest relative size of a step's last correction, where steps are refined.
  double last_correction() const { return last_correction_; }
  int unknowns() const { return n_unknowns_; } ///< of the problem, whatever a state holds
  /// Why states hold all unknowns; empty: they hold the contact unknowns (reduce.hpp).
  const std::string& obstacle() const { return obstacle_; }
  /// Adds what was counted to the counters and phases of a run.
  void account(WorkCounters& work, Timing& timing) const;

  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  std::int64_t field_reads() const; ///< of stored history fields, those before a resume too
  void allocate();
  void continue_memory(const MemoryExtent& earlier);
  StepMatrix& matrix_for(int n);
  void judge_uniqueness(StepMatrix& matrix);
  void impose_values(int n);
  void reduce_if_possible();
  double equilibrium_of_all(int n);
  Interior::Question question(int n) const;
  void put_off_check(int n);
  void settle_checks();
  void find_change(int n, const StepMatrix& matrix);
  void refactor(int n, StepMatrix& matrix);
  void right_hand_side(int n);
  bool known_part(int n, int b);
  void add_load(int n);
  double residual(StepMatrix& matrix);
  StepResult correct(int n, StepMatrix& matrix, bool again);
  bool same_problem(int n, const StepMatrix& matrix) const;
  void learn(int n, StepMatrix& matrix, const StepResult& result);
  bool predict(int n, const StepMatrix& matrix);
  void guess_from_increment();
  void drop_guess();
  void choose_storage(int n, StepMatrix& matrix);
  StepResult attempt(int n, StepMatrix& matrix);
  void couple_bounds(int n, StepMatrix& matrix, StepResult& out);
  bool bounds_agree(int n);
  /// Steps may have several solutions: branches are followed.
  bool follows() const;
  void accept(int n);
  void note_size();
  void note_left_over(double error);
  std::vector<double> memory_of_one() const;
  std::vector<Vector> rounding_forces(double backward_error);
  void look_at_conditioning(StepMatrix& matrix);
  double precise_gap(int n, const StepMatrix& matrix, const std::vector<Vector>& known,
                     const Vector& d);
  void refine(int n, StepMatrix& matrix, StepResult& out);

  const Plan& plan_;
  const Discretisation& discretisation_;
  Timing& timing_;
  TimeGrid grid_;
  StateLayout layout_;
  Operators operators_;
  Contact contact_;
  std::optional<Memory> memory_;
  std::optional<LoadAssembler> loads_;
  InequalityOptions options_;

  struct Cached {
    double rate, length;
    std::unique_ptr<StepMatrix> matrix;
  };
  std::list<Cached> matrices_; ///< most recently used first
  int n_unknowns_ = 0;
  std::string obstacle_;
  std::vector<char> checked_; ///< steps whose equilibrium is computed on all rows (reduce.hpp)
  Vector load_, stress_;      ///< of [contact; modes], for that
  bool checks_wait_ = false;
  std::vector<int> waiting_steps_;
  std::vector<Interior::Question> waiting_;
  std::vector<std::pair<int, double>> late_errors_;
  Predictor predictor_;
  Vector predicted_gamma_;                ///< of the matrix of the predictor's increments
  const StepMatrix* shortened_ = nullptr; ///< whose factor is there once more, with fewer bits
  bool never_shortened_ = false;
  SweepChoice sweeps_;
  /// The base matrices once more for products, in half the memory; empty: not used.
  std::vector<SymmetricBlocks> halves_;
  Vector kd_; ///< K d of the last residual, K the factored matrix

  /// The state of the largest size so far: what acted on each base matrix then.
  struct Largest {
    double size = 0.0;
    int step = 0;
    std::vector<Vector> on_base;
  };
  Largest largest_;
  /// What the worst step so far left of its equation, within a factor 1.6.
  struct LeftOver {
    double error = 0.0; ///< its backward error
    Vector force;
  };
  LeftOver left_over_;
  bool refines_ = false;
  double last_correction_ = 0.0;

  int step_ = 0;
  std::string not_unique_;
  bool uniqueness_judged_ = false;
  InequalityState inequality_, accepted_;        ///< accepted_: of the last certified step
  Vector u_, known_, d_, d_previous_, d_before_; // states; d on unknowns only
  Vector rhs_, gap_, scale_, work_;              // unknowns
  Vector combined_, full_, change_, expected_, z_;
  Vector c_guess_, xi_guess_; // room for those of inequality_
  Vector dz_;                 ///< of the last step
  double inclusion_ = 0;      ///< of the last `bounds_agree`
  double mismatch_ = 0; ///< backward error due to the part of K_n that its factor does not know
  std::int64_t earlier_reads_ = 0;
  int products_ = 0, corrections_ = 0, newton_ = 0, fallbacks_ = 0;
  InequalityState path_start_; ///< with coupled laws: where each pass begins its path
  int followed_ = 0, inner_steps_ = 0, unfollowed_ = 0;
};

} // namespace hvi::solver
