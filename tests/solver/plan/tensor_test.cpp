// Tensors as they were written: their forms against the contraction itself, and forms that are not
// those of the tensor that comes with them.
#include "solver/kernel/slot.hpp"
#include "solver/plan/tensor_form.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

namespace hvi::solver {
namespace {

using Kind = TensorSpec::Kind;

Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Point of_length_one(Point a) {
  const double size = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  for (double& x : a) x /= size;
  return a;
}

/// A problem of one random tensor, and how it is used.
class Drawn {
public:
  explicit Drawn(unsigned seed) : random_(seed) {
    dim = 2 + static_cast<int>(random_() % 2);
    problem.mesh.axisymmetric = dim == 2 && random_() % 2 == 0;
    problem.space.more = {{"w", "W", {}, true, 1}};
    TensorSpec tensor;
    tensor.kind = static_cast<Kind>(random_() % 4);
    const bool varies = random_() % 2 == 0;
    for (int i = 0; i < count_constants(tensor.kind, tensor_dim()); ++i)
      tensor.constants.push_back(number() + (varies ? number() * place() : Expr(0.0)));
    if (random_() % 2 == 0) turn(tensor);
    problem.tensors = {tensor};
    use = {0, number() * (random_() % 2 == 0 ? place() : Expr(1.0)),
           static_cast<int>(random_() % 2)};
  }
  int tensor_dim() const { return problem.mesh.axisymmetric ? 3 : dim; }
  FormTerm form() const { return tensor_form(problem, dim, field_of_u(0), use); }
  double number() { return std::uniform_real_distribution(0.1, 1.0)(random_); }

  Problem problem;
  int dim;
  FormTerm::Tensor use;

private:
  Expr place() {
    const Expr x = Expr::variable(slot::x(static_cast<int>(random_() % 2)));
    return random_() % 2 == 0 ? exp(x) : x * Expr::variable(slot::state(0));
  }
  void turn(TensorSpec& tensor) {
    const Point a = of_length_one({number(), -number(), dim == 3 ? number() : 0.0});
    const Point z{0, 0, 1};
    const Point b = dim == 3 ? of_length_one(cross(a, {0.3, 1, 0.2})) : z;
    tensor.axes = {a, b, cross(a, b)};
  }

  std::mt19937 random_;
};

/// eps_ij of a function whose derivatives have these values; 0 beyond the section.
double strain(const Drawn& drawn, const std::function<double(int)>& derivative, int i, int j) {
  if (i < drawn.dim && j < drawn.dim)
    return 0.5 * (derivative(slot::gradient(i, j)) + derivative(slot::gradient(j, i)));
  return drawn.problem.mesh.axisymmetric && i == j ? derivative(slot::hoop) : 0.0;
}

double value(const Expr& e) {
  return evaluate(e, [](Slot s) { return 0.1 + 0.03 * (s % 7); });
}

TEST(TensorForm, IsTheContraction) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    Drawn drawn(seed);
    std::map<int, double> of_u, of_v;
    for (int k = 0; k < slot::own_derivatives; ++k)
      of_u[k] = drawn.number(), of_v[k] = drawn.number();
    double found = 0.0, wanted = 0.0, size = 0.0;
    for (const auto& entry : drawn.form().entries) {
      EXPECT_EQ(slot::unknown_of(entry.test), drawn.use.unknown);
      found += value(entry.coefficient) * of_u[entry.trial % slot::own_derivatives] *
               of_v[entry.test % slot::own_derivatives];
    }
    const int d = drawn.tensor_dim();
    const auto c = components(drawn.problem.tensors[0], d);
    const auto u = [&](int k) { return of_u[k]; };
    const auto v = [&](int k) { return of_v[k]; };
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j)
        for (int k = 0; k < d; ++k)
          for (int l = 0; l < d; ++l) {
            const double one = value(drawn.use.factor) * value(c[((i * d + j) * d + k) * d + l]) *
                               strain(drawn, v, i, j) * strain(drawn, u, k, l);
            wanted += one, size += std::abs(one);
          }
    EXPECT_NEAR(found, wanted, 1e-13 * size);
  }
}

TEST(TensorForm, KindsWithMajorSymmetryHaveIt) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Drawn drawn(seed);
    const TensorSpec& tensor = drawn.problem.tensors[0];
    if (!has_major_symmetry(tensor.kind)) continue;
    const int n = drawn.tensor_dim() * drawn.tensor_dim();
    const auto c = components(tensor, drawn.tensor_dim());
    double largest = 0.0;
    for (const Expr& one : c) largest = std::max(largest, std::abs(value(one)));
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        EXPECT_NEAR(value(c[a * n + b]), value(c[b * n + a]), 1e-13 * largest) << seed;
  }
}

TEST(Tensor, ShearsAcrossASectionAreThoseOfTheSolid) {
  int n_with = 0, n_turned_without = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const TensorSpec tensor = Drawn(seed).problem.tensors[0];
    if (tensor.kind == Kind::general) continue;
    const auto c = components(tensor, 3);
    double largest = 0.0, across = 0.0;
    for (int at = 0; at < 81; ++at) {
      const double size = std::abs(value(c[at]));
      const int i = at / 27, j = at / 9 % 3, k = at / 3 % 3, l = at % 3;
      largest = std::max(largest, size);
      if (i < 2 && j == 2 && k < 2 && l < 2) across = std::max(across, size);
    }
    EXPECT_EQ(shears_across(tensor), across > 1e-9 * largest) << seed;
    (across > 1e-9 * largest ? n_with : n_turned_without) += tensor.axes[0][0] != 1;
  }
  EXPECT_GT(n_with, 10);
  EXPECT_GT(n_turned_without, 10);
}

// Every wrong hint is seen: other constants, another factor, kind or unknown, an entry too many.
TEST(TensorForm, AnotherTensorIsNotBelieved) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    Drawn drawn(seed);
    const FormTerm form = drawn.form();
    const auto fits = [&](const Problem& problem, const FormTerm& changed) {
      return has_entries_of_its_tensor(problem, drawn.dim, changed);
    };
    EXPECT_TRUE(fits(drawn.problem, form));
    for (std::size_t i = 0; i < 2; ++i) { // constants that act in the plane, whatever the kind
      Problem other = drawn.problem;
      other.tensors[0].constants[i] = other.tensors[0].constants[i] * Expr(1 + 1e-6);
      EXPECT_FALSE(fits(other, form)) << i;
    }
    FormTerm changed = form;
    changed.tensor->factor = changed.tensor->factor * Expr(1 + 1e-9);
    EXPECT_FALSE(fits(drawn.problem, changed));
    changed = form;
    changed.tensor->factor = Expr(std::nan(""));
    EXPECT_FALSE(fits(drawn.problem, changed));
    changed = form;
    changed.tensor->unknown = 1 - changed.tensor->unknown;
    EXPECT_FALSE(fits(drawn.problem, changed));
    changed = form;
    changed.entries.pop_back();
    EXPECT_FALSE(fits(drawn.problem, changed));
    changed = form;
    changed.entries.push_back({slot::value(0), slot::value(0), Expr(1e-6)});
    EXPECT_FALSE(fits(drawn.problem, changed));
    changed = form;
    changed.entries.push_back(changed.entries[seed % changed.entries.size()]);
    EXPECT_FALSE(fits(drawn.problem, changed));
  }
}

} // namespace
} // namespace hvi::solver
