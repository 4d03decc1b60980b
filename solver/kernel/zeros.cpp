// Zeros of a function of one variable; see zeros.hpp.
#include "solver/kernel/zeros.hpp"

#include "solver/kernel/interval.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int most_parts = 40000;   ///< that are looked at
constexpr double closest = 1e-8;    ///< parts this small, of the interval, are not halved
constexpr double vanishing = 1e-13; ///< of the largest value: 0 but for rounding

class Isolation {
public:
  Isolation(const Expr& f, Slot variable, double low, double high)
      : f_(f), slope_(derivative(f, variable)), low_(low), high_(high) {}

  Zeros find() {
    const Bounds all = over(f_, low_, high_);
    size_ = std::max(std::abs(value(f_, low_)), std::abs(value(f_, high_)));
    if (std::isfinite(all.low) && std::isfinite(all.high))
      size_ = std::max(std::abs(all.low), std::abs(all.high));
    std::vector<std::pair<double, double>> parts = {{low_, high_}};
    for (int looked = 0; !parts.empty(); ++looked) {
      const auto [a, b] = parts.back();
      parts.pop_back();
      if (looked >= most_parts) {
        out_.complete = false;
        by_sign(a, b);
      } else if (look(a, b)) {
        const double middle = a + 0.5 * (b - a);
        parts.emplace_back(a, middle), parts.emplace_back(middle, b);
      }
    }
    merge();
    return std::move(out_);
  }

private:
  double value(const Expr& e, double t) const {
    return evaluate(e, [&](Slot) { return t; });
  }
  Bounds over(const Expr& e, double a, double b) const {
    return bounds(e, [&](Slot) { return Bounds{a, b}; });
  }

  /// True: the part must be halved.
  bool look(double a, double b) {
    const Bounds here = over(f_, a, b);
    if (!here.contains(0.0)) return false;
    const Bounds rise = over(slope_, a, b);
    const double still = vanishing * size_ / (high_ - low_);
    if (here.high - here.low <= vanishing * size_ && rise.low >= -still && rise.high <= still)
      return false; // a stretch of zeros
    if (rise.known && rise.defined && here.defined && !rise.contains(0.0)) {
      by_sign(a, b);
      return false;
    }
    if (b - a > closest * (high_ - low_)) return true;
    if (!here.known) out_.complete = false;
    if (!touching(a, b)) by_sign(a, b);
    return false;
  }

  /// A change of sign of e in [a, b], closed in on to the last bit.
  bool change_of_sign(const Expr& e, double a, double b, double& at) const {
    const double left = value(e, a), right = value(e, b);
    if (left == 0.0 || right == 0.0) {
      at = left == 0.0 ? a : b;
      return left != right;
    }
    if (!(left * right < 0.0)) return false;
    for (int k = 0; k < 200; ++k) {
      const double middle = a + 0.5 * (b - a);
      if (middle <= a || middle >= b) break;
      (value(e, middle) * left > 0.0 ? a : b) = middle;
    }
    at = b;
    return true;
  }

  bool by_sign(double a, double b) {
    double at = 0.0;
    if (!change_of_sign(f_, a, b, at)) return false;
    out_.at.push_back(at);
    return true;
  }

  /// A double zero: where the slope changes its sign, if f vanishes there.
  bool touching(double a, double b) {
    double at = 0.0;
    const double wider = b - a;
    if (!change_of_sign(slope_, std::max(low_, a - wider), std::min(high_, b + wider), at))
      return false;
    if (std::abs(value(f_, at)) > vanishing * size_) return false;
    double_.push_back(at);
    return true;
  }

  void merge() {
    auto& at = out_.at;
    // Rounding makes zeros and signs of its own beside a double zero.
    const double beside = 4 * closest * (high_ - low_);
    for (const double zero : double_)
      std::erase_if(at, [&](double v) { return std::abs(v - zero) <= beside; });
    at.insert(at.end(), double_.begin(), double_.end());
    std::sort(at.begin(), at.end());
    const double same = 1e-14 * (std::abs(low_) + std::abs(high_) + (high_ - low_));
    at.erase(std::unique(at.begin(), at.end(), [&](double a, double b) { return b - a <= same; }),
             at.end());
  }

  const Expr& f_;
  Expr slope_;
  double low_, high_, size_ = 0.0;
  std::vector<double> double_;
  Zeros out_;
};

} // namespace

Zeros zeros(const Expr& f, Slot variable, double low, double high) {
  return Isolation(f, variable, low, high).find();
}

} // namespace hvi::solver
