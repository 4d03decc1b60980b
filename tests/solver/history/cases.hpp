// Kernels, grids and a brute-force memory sum for the conformance suite of the history routes.
#pragma once

#include "solver/history/history.hpp"

#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace hvi::solver::test {

inline Expr lag() { return Expr::variable(slot::lag); }
inline Expr time() { return Expr::variable(slot::t); }
inline Expr source() { return time() - lag(); }
inline Expr call(Op op, Expr a) { return Expr::make(op, {std::move(a)}); }
inline Expr call(Op op, Expr a, Expr b) { return Expr::make(op, {std::move(a), std::move(b)}); }
inline Expr call(Op op, Expr a, Expr b, Expr c) {
  return Expr::make(op, {std::move(a), std::move(b), std::move(c)});
}

/// A kernel as the engine sees it and the same function written in C++ (independent of the tape).
struct KernelCase {
  std::string name;
  Expr expression;
  std::function<double(double t, double lag)> value;
  double singular = 0;             ///< exponent at lag 0
  std::vector<double> breaks = {}; ///< lags
  bool recursion = false;          ///< the symbolic route takes it
  bool fit = false;                ///< the fitted route takes it
  friend std::ostream& operator<<(std::ostream& out, const KernelCase& c) { return out << c.name; }
};
const std::vector<KernelCase>& kernel_cases();
const KernelCase& kernel_case(const std::string& name);

/// Grids of [0, 2]: equal steps, graded (t_n = T (n/N)^2), and a list of wildly changing steps.
enum class Grid { uniform, graded, listed };
std::vector<double> grid(Grid kind, int steps, double end = 2.0);
double shortest_step(const std::vector<double>& times);

/// The values of u at the grid times: three different smooth functions, one jump.
std::vector<double> sample_field(double t);
inline constexpr std::size_t field_size = 4;

/// int over lags [low, high] of q(t, lag) x^moment, x = (lag - low)/(high - low), by composite
/// Gauss rules on geometrically graded panels (nothing of the engine's quadrature).
double reference_integral(const KernelCase& kernel, double t, double low, double high, int moment);

/// (R u)(t_n) without the part of u_n, and its weight, by the definition.
struct BruteForce {
  std::vector<double> rhs;
  double w0;
};
BruteForce brute_force(const KernelCase& kernel, const std::vector<double>& times, std::size_t n,
                       int order);

} // namespace hvi::solver::test
