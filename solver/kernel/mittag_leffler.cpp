// The Mittag-Leffler function E_{alpha,beta}(x) for real x.
#include "solver/kernel/scalar.hpp"

namespace hvi::solver {

double mittag_leffler(double alpha, double beta, double x) {
  double sum = 0.0, power = 1.0;
  for (int k = 0; k < 160; ++k, power *= x) sum += power / std::tgamma(alpha * k + beta);
  return sum;
}

} // namespace hvi::solver
