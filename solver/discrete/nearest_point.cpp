// See nearest_point.hpp.
#include "solver/discrete/nearest_point.hpp"

#include "solver/linear/dense.hpp"

#include <vector>

namespace hvi::solver {
namespace {

constexpr int most_steps = 400;
/// Distances below this part of the sizes at hand are rounding.
constexpr double relative_rounding = 1e-9;
/// And scalar products of unit vectors below this.
constexpr double no_fall = 1e-12;

/// A point of the set, sum of share_i q_i: shares of points add up to 1.
class Combination {
public:
  explicit Combination(Vector start) : shares_{1.0} { atoms_.push_back({std::move(start), false}); }

  Vector point() const {
    Vector out = Vector::Zero(atoms_.front().q.size());
    for (std::size_t i = 0; i < atoms_.size(); ++i) out += shares_[i] * atoms_[i].q;
    return out;
  }
  double size() const {
    double out = 0.0;
    for (std::size_t i = 0; i < atoms_.size(); ++i) out += shares_[i] * atoms_[i].q.norm();
    return out;
  }
  void add(Support atom) {
    atoms_.push_back(std::move(atom));
    shares_.push_back(0.0);
  }
  /// The combination nearest to b; atoms that it has no need of are dropped.
  void go_near(const Vector& b) {
    for (std::size_t pass = atoms_.size() + 1; pass > 0; --pass) {
      const std::vector<double> wanted = affine(b);
      double step = 1.0;
      for (std::size_t i = 0; i < wanted.size(); ++i)
        if (wanted[i] < 0.0) step = std::min(step, shares_[i] / (shares_[i] - wanted[i]));
      for (std::size_t i = 0; i < wanted.size(); ++i) shares_[i] += step * (wanted[i] - shares_[i]);
      drop(wanted);
      if (step == 1.0) return;
    }
  }

private:
  std::size_t first_point() const {
    std::size_t at = 0;
    while (atoms_[at].ray) ++at;
    return at;
  }
  /// Shares of any sign that come nearest to b.
  std::vector<double> affine(const Vector& b) const {
    const std::size_t origin = first_point();
    DenseMatrix q(b.size(), static_cast<Eigen::Index>(atoms_.size()) - 1);
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < atoms_.size(); ++i) {
      if (i == origin) continue;
      q.col(column) = atoms_[i].q;
      if (!atoms_[i].ray) q.col(column) -= atoms_[origin].q;
      ++column;
    }
    std::vector<double> out(atoms_.size(), 0.0);
    const Vector found = least_squares(q, b - atoms_[origin].q);
    double left = 1.0;
    for (std::size_t i = 0, k = 0; i < atoms_.size(); ++i) {
      if (i == origin) continue;
      out[i] = found[static_cast<Eigen::Index>(k++)];
      if (!atoms_[i].ray) left -= out[i];
    }
    out[origin] = left;
    return out;
  }
  /// Those that were to become negative and have come to 0.
  void drop(const std::vector<double>& wanted) {
    for (std::size_t i = atoms_.size(); i-- > 0;)
      if (wanted[i] <= 0.0 && shares_[i] <= 1e-14 && (atoms_[i].ray || points() > 1)) {
        atoms_.erase(atoms_.begin() + static_cast<std::ptrdiff_t>(i));
        shares_.erase(shares_.begin() + static_cast<std::ptrdiff_t>(i));
      }
  }
  int points() const {
    int out = 0;
    for (const auto& atom : atoms_) out += atom.ray ? 0 : 1;
    return out;
  }

  std::vector<Support> atoms_;
  std::vector<double> shares_;
};

} // namespace

NearestPoint nearest_point(const Vector& b, Vector start,
                           const std::function<Support(const Vector& y)>& support) {
  Combination at(std::move(start));
  NearestPoint out;
  for (int step = 0; step < most_steps; ++step) {
    const Vector point = at.point(), y = b - point;
    const double apart = y.norm(), size = b.norm() + at.size();
    if (apart <= relative_rounding * size) {
      out.apart = y, out.outside = false;
      return out;
    }
    Support next = support(y);
    const double gain = next.q.dot(y) - (next.ray ? 0.0 : point.dot(y));
    const double none = no_fall * apart * (next.ray ? 1.0 : size);
    const bool proved = next.ray ? gain <= none && out.outside
                                 : y.dot(b) - next.q.dot(y) > relative_rounding * apart * size;
    if (proved) out.apart = y, out.outside = true;
    if (gain <= none) {
      out.apart = y, out.outside = true;
      return out;
    }
    at.add(std::move(next));
    at.go_near(b);
  }
  return out;
}

} // namespace hvi::solver
