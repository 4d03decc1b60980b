// See across.hpp. Used where operators, strains and the stress are made.
#include "lang/check/across.hpp"

#include "solver/kernel/algebra.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

bool is_gradient_of_test(solver::Slot s) {
  return slot::is_test(s) && !slot::is_value(s - slot::test(0));
}

/// v itself, and nothing else of it.
bool is_test_function(const Field& f) {
  return std::ranges::all_of(f.components, [&](const Symbol& c) {
    const auto slots = solver::slots_of(c);
    return slots.size() == 1 && slot::is_test(*slots.begin()) &&
           c == Symbol::variable(*slots.begin());
  });
}

/// e_iz; no stress has arguments of laws in it.
solver::Slot of_shear(int i) { return slot::argument(1 + i); }

std::vector<Symbol> scaled(const Symbol& by, std::vector<Symbol> across) {
  for (Symbol& c : across) c = by * c;
  return across;
}

} // namespace

std::vector<Symbol> across_of_tensor(const solver::TensorSpec& tensor) {
  std::vector<Symbol> out = components_across(tensor, 2);
  if (!shears_across(tensor)) return out;
  for (int i = 0; i < 2; ++i) {
    const std::vector<Symbol> shear = components_across(tensor, i);
    for (std::size_t k = 0; k < out.size(); ++k)
      out[k] = out[k] + Symbol::variable(of_shear(i)) * shear[k];
  }
  return out;
}

Symbol normal_across(const Symbol& across) {
  const std::pair<solver::Slot, Symbol> none[] = {{of_shear(0), Symbol(0.0)},
                                                  {of_shear(1), Symbol(0.0)}};
  return substitute(across, none);
}

Symbol shear_across(const Symbol& across, int i) { return derivative(across, of_shear(i)); }

std::vector<Symbol> entries_across_plane(const Field& f) {
  if (f.rank != 2 || f.rows != 2 || f.columns != 2 || f.across.empty()) return {};
  const Symbol& across = f.across[0];
  return {normal_across(across), shear_across(across, 0), shear_across(across, 1)};
}

Symbol strain_across(int unknown) {
  return Symbol::variable(slot::test(slot::of_unknown(unknown, slot::hoop)));
}

std::vector<Symbol> across_of_scalar(const Field& f) {
  if (!f.across.empty() || f.rank != 0) return f.across;
  std::set<int> open;
  for (const solver::Slot s : solver::slots_of(f.scalar()))
    if (is_gradient_of_test(s)) open.insert(slot::unknown_of(s - slot::test(0)));
  Symbol out = 0.0;
  for (const int unknown : open) out = out + strain_across(unknown) * strain_across(unknown);
  return {out};
}

std::vector<Symbol> stress_across(const Field& f, int unknown) {
  const Symbol out =
      derivative(across_of_scalar(f)[0], slot::test(slot::of_unknown(unknown, slot::hoop)));
  for (const solver::Slot s : solver::slots_of(out))
    if (slot::is_test(s)) return {};
  return {out};
}

std::vector<Symbol> across_of_sum(const Field& left, const Field& right, double sign) {
  std::vector<Symbol> a = across_of_scalar(left);
  const std::vector<Symbol> b = across_of_scalar(right);
  if (a.empty() || a.size() != b.size()) return {};
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = sign > 0 ? a[i] + b[i] : a[i] - b[i];
  return a;
}

std::vector<Symbol> across_of_product(const Field& factor, const Field& body) {
  if (!body.across.empty()) return scaled(factor.scalar(), body.across);
  if (body.rank == 0) return scaled(body.scalar(), factor.across);
  return {};
}

std::vector<Symbol> across_of_contraction(const Field& left, const Field& right) {
  if (left.across.empty() || right.across.empty()) return {};
  if (left.rank == 2 && right.rank == 2) return {left.across[0] * right.across[0]};
  if (left.rank != 4 || right.rank != 2 || right.test != Degree::none ||
      !right.across[0].is(0.0)) // what C_zzzz would be needed for
    return {};
  Symbol sum = 0.0;
  for (std::size_t k = 0; k < right.components.size(); ++k)
    sum = sum + left.across[k] * right.components[k];
  return {sum};
}

std::vector<Symbol> across_of_strain(const Field& f) {
  if (f.test == Degree::none) return {Symbol(0.0)};
  if (is_test_function(f))
    return {strain_across(
        slot::unknown_of(*solver::slots_of(f.components[0]).begin() - slot::test(0)))};
  return {};
}

} // namespace hvi::lang
