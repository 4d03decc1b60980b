// Special functions of the kernel that come from Boost.Math, with errors turned into NaN: a value
// that does not exist is reported where it is used, with the place in the script.
#include "solver/kernel/scalar.hpp"

#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/polygamma.hpp>

#include <exception>

namespace hvi::solver {

namespace {

using boost::math::policies::ignore_error;
using boost::math::policies::policy;
using Quiet = policy<boost::math::policies::domain_error<ignore_error>,
                     boost::math::policies::pole_error<ignore_error>,
                     boost::math::policies::overflow_error<ignore_error>,
                     boost::math::policies::evaluation_error<ignore_error>,
                     boost::math::policies::promote_double<false>>;

/// Boost throws in corners that no policy reaches (rounding to int, series that do not converge).
template <class F>
double or_nan(F f) {
  try {
    return f();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return not_a_number;
  }
}

} // namespace

/// Boost recurs from the order down, which takes seconds for large ones, and from 2^31 on its
/// orders overflow.
double bessel_j(double order, double x) {
  constexpr double largest_order = 1e4;
  if (!std::isfinite(x) || !(std::abs(order) <= largest_order) || order != std::trunc(order))
    return not_a_number;
  return or_nan([=] { return boost::math::cyl_bessel_j(order, x, Quiet()); });
}

double polygamma(double order, double x) {
  if (!std::isfinite(x) || !(order >= 0.0 && order <= 100.0) || order != std::trunc(order))
    return not_a_number;
  if (x <= 0.0 && x == std::trunc(x)) return not_a_number; // poles
  return or_nan([=] { return boost::math::polygamma(static_cast<int>(order), x, Quiet()); });
}

} // namespace hvi::solver
