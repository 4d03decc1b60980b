// The scalar half of the recursion: how the sums of c g(t) h(s) lag^r exp(p lag + sigma t) advance
// over a step, what a step puts in, and how they are read.
//
// State of a group (p, h), r = 0..R:  A_r(t) = e^{-rho (t - t0)} int_{t0}^t h(s) lag^r e^{p lag}
// u(s) ds with rho = max(0, Re p), so that states of growing kernels stay bounded. Over a step k
//   A_r(t + k) = e^{(p - rho) k} sum_m C(r, m) k^{r-m} A_m(t) + the integral over the step.
#pragma once

#include "solver/history/fields.hpp"
#include "solver/history/integral.hpp"
#include "solver/history/recognise.hpp"

#include <complex>
#include <vector>

namespace hvi::solver {

/// int_0^1 x^r e^{z x} dx without cancellation, 0 <= r <= 12.
Complex exponential_moment(int r, Complex z);

class ExponentialSum {
public:
  /// `scale_growth` false: rho = 0, for rates that grow little over the whole time; coefficients
  /// then do not depend on t0.
  explicit ExponentialSum(const ExponentialTerms& terms, bool scale_growth = true);

  std::size_t state_fields() const;
  /// Coefficients do not depend on the time, only on the steps.
  bool steady() const { return steady_; }

  /// A step: (t_end - k, t_end].
  struct Step {
    double t_end, k;
  };
  /// Coefficients that put `step` into the states at its end and read them at t_end + ahead.
  std::vector<LinearGroup> coefficients(const Step& step, double ahead, double t0, int order) const;
  /// Exact weights of u over the step read at its end (the current interval).
  Moments current(const Step& step) const;
  /// Weights read at t_end + ahead; for intervals that are not in the states.
  Moments weights(const Step& step, double ahead) const;

private:
  struct Reading {
    int power;
    Complex factor, time_rate;
    LineFunction of_time;
  };
  struct Group {
    Complex rate;
    Expr of_source;
    LineFunction source; ///< of_source, compiled
    int top_power = 0;
    std::vector<Reading> readings;
    bool complex() const { return rate.imag() != 0; }
    double growth = 0; ///< rho
  };
  struct GroupMoments {
    std::vector<Complex> zero, one; ///< of lag^r e^{p lag} h, r = 0..top_power
  };
  Group& group_of(const ExponentialTerm& term);
  static GroupMoments moments(const Group& group, const Step& step);
  static void add_source_moments(const Group& group, const Step& step, int r, GroupMoments& out);
  static LinearGroup linear(const Group& group, const Step& step, double ahead, double t0,
                            int order);
  static void put_transition(const Group& group, double k, LinearGroup& out);
  static void put_input(const Group& group, const Step& step, double t0, int order,
                        LinearGroup& out);
  static void put_readout(const Group& group, double t_read, double ahead, double t0,
                          LinearGroup& out);

  std::vector<Group> groups_;
  bool steady_ = true;
};

} // namespace hvi::solver
