// Forms of tensors, and whether a form is one; see tensor_form.hpp.
#include "solver/plan/tensor_form.hpp"

#include "solver/kernel/slot.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace hvi::solver {
namespace {

using Entries = std::map<std::pair<int, int>, Expr>; ///< by test and trial derivative

/// The derivative that is entry (i, j) of a gradient, or -1: it is 0.
int derivative_at(const Problem& problem, int dim, int i, int j) {
  if (i < dim && j < dim) return slot::gradient(i, j);
  return problem.mesh.axisymmetric && i == j ? slot::hoop : -1;
}

Entries entries_of(const FormTerm& form) {
  Entries out;
  for (const auto& entry : form.entries) {
    const auto [at, fresh] = out.try_emplace({entry.test, entry.trial}, entry.coefficient);
    if (!fresh) at->second = at->second + entry.coefficient;
  }
  return out;
}

/// A value for each variable, other ones in each sample; whether a place lies in a part: 0 or 1.
double sample_value(Slot s, int sample) {
  constexpr double golden = 0.6180339887498949;
  const double place = std::fmod(golden * (s + 2) + 0.29 * (sample + 1), 1.0);
  const bool is_indicator = s >= slot::first_inside && s < slot::first_state;
  return is_indicator ? std::round(place) : place;
}

struct Compared {
  double largest_difference = 0.0, largest = 0.0;
};

/// False where one of the two is no number at the sample and the other is.
bool compare(const Entries& a, const Entries& b, int sample, Compared& out) {
  const auto value = [&](const Entries& of, const std::pair<int, int>& at) {
    const auto found = of.find(at);
    if (found == of.end()) return 0.0;
    return evaluate(found->second, [&](Slot s) { return sample_value(s, sample); });
  };
  const auto look = [&](const std::pair<int, int>& at) {
    const double x = value(a, at), y = value(b, at);
    if (!std::isfinite(x) || !std::isfinite(y)) return std::isfinite(x) == std::isfinite(y);
    out.largest_difference = std::max(out.largest_difference, std::abs(x - y));
    out.largest = std::max(out.largest, std::abs(y));
    return true;
  };
  return std::ranges::all_of(a, [&](const auto& one) { return look(one.first); }) &&
         std::ranges::all_of(b, [&](const auto& one) { return look(one.first); });
}

bool is_constant(const Entries& entries) {
  return std::ranges::all_of(entries, [](const auto& one) { return one.second.is_constant(); });
}

} // namespace

FormTerm tensor_form(const Problem& problem, int dim, int field, const FormTerm::Tensor& tensor) {
  const int d = problem.mesh.axisymmetric ? 3 : dim;
  const auto c = components(problem.tensors[static_cast<std::size_t>(tensor.index)], d);
  const auto at = [&](int i, int j, int k, int l) -> const Expr& {
    return c[static_cast<std::size_t>(((i * d + j) * d + k) * d + l)];
  };
  FormTerm form;
  form.field = field;
  form.tensor = tensor;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      for (int k = 0; k < d; ++k)
        for (int l = 0; l < d; ++l) {
          const int test = derivative_at(problem, dim, i, j),
                    trial = derivative_at(problem, dim, k, l);
          if (test < 0 || trial < 0) continue;
          // A strain is the mean of a gradient and its transpose.
          const Expr sum = at(i, j, k, l) + at(j, i, k, l) + at(i, j, l, k) + at(j, i, l, k);
          const Expr coefficient = tensor.factor * (Expr(0.25) * sum);
          if (!coefficient.is(0.0))
            form.entries.push_back({slot::of_unknown(tensor.unknown, test),
                                    slot::of_unknown(tensor.unknown, trial), coefficient});
        }
  return form;
}

bool has_entries_of_its_tensor(const Problem& problem, int dim, const FormTerm& form) {
  constexpr double rounding = 1e-12;
  constexpr int samples = 4;
  const Entries own = entries_of(form),
                its = entries_of(tensor_form(problem, dim, form.field, *form.tensor));
  const int looks = is_constant(own) && is_constant(its) ? 1 : samples;
  for (int sample = 0; sample < looks; ++sample) {
    Compared found;
    if (!compare(own, its, sample, found) || found.largest_difference > rounding * found.largest)
      return false;
  }
  return true;
}

} // namespace hvi::solver
