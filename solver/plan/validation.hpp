// What a plan may name where: parts, fields, derivatives, variables. Base of the checks of a
// problem and of a report, see validate.hpp.
#pragma once

#include "solver/plan/validate.hpp"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hvi::solver {

/// Which variables an expression may have.
struct Allowed {
  bool place = false;       ///< x, and whether it lies in a part
  bool normal = false;      ///< the unit normal
  bool time = false;        ///< t
  bool lag = false;         ///< t - s
  bool argument = false;    ///< of a law
  bool coupled = false;     ///< the multiplier a law's bound stands for
  int readings = 0;         ///< what a law reads of the solution
  bool fields = false;      ///< u, u', memories and their derivatives
  bool multipliers = false; ///< of law terms
  int law_states = 0;       ///< that a law reads
  bool states = false;      ///< of the plan
  bool gap = false;         ///< between the sides of a pair
  int probes = 0;           ///< those before this one
};

namespace allowed {
inline constexpr Allowed of_place{.place = true};
inline constexpr Allowed of_facet{.place = true, .normal = true};
inline constexpr Allowed of_form{.place = true, .normal = true, .states = true};
inline constexpr Allowed of_load{.place = true, .normal = true, .time = true};
inline constexpr Allowed of_state_load{.place = true, .normal = true, .time = true, .states = true};
inline constexpr Allowed of_argument{
    .place = true, .normal = true, .time = true, .states = true, .gap = true};
inline constexpr Allowed of_report{.place = true,
                                   .normal = true,
                                   .time = true,
                                   .fields = true,
                                   .multipliers = true,
                                   .states = true,
                                   .gap = true};
} // namespace allowed

class Validation {
protected:
  Validation(const Problem& problem, int dim);
  ~Validation() = default;

  template <class T>
  static int count(const std::vector<T>& items) {
    return static_cast<int>(items.size());
  }
  std::vector<Failure> take() { return std::move(out_); }
  void wrong(Origin origin, const std::string& message);
  /// 0 <= index < n.
  bool index(int i, int n, Origin origin, std::string_view what, std::string_view of);
  bool part(int i, Origin origin, std::string_view what);
  bool derivative(int i) const;
  void derivative(int i, Origin origin, std::string_view what);
  bool known(Slot s, const Allowed& allowed) const;
  void variables(const Expr& e, const Allowed& allowed, Origin origin, std::string_view what);
  bool is_pair(int i) const;
  /// On a pair there are laws.
  void no_pair(int i, Origin origin, std::string_view what);

  const Problem& problem_;
  int dim_, components_, n_fields_;

private:
  std::vector<Failure> out_;
};

} // namespace hvi::solver
