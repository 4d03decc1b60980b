// Sums and products of tensors and strains; see material_use.hpp.
#include "lang/check/material_use.hpp"

#include <algorithm>
#include <optional>

namespace hvi::lang {

namespace {

constexpr std::size_t most_uses = 16; ///< a longer sum is an expression like any other

bool same_but_for_factor(const MaterialUse& a, const MaterialUse& b) {
  return a.tensor == b.tensor && a.of == b.of && a.tested == b.tested && a.unknown == b.unknown;
}

bool is_strain_or_more(const MaterialUse& use) { return use.of || use.tested; }

/// left : right, where each of C, eps(w) and eps(v) comes from one of them.
std::optional<MaterialUse> contracted(const MaterialUse& left, const MaterialUse& right,
                                      const std::vector<solver::TensorSpec>& tensors) {
  if ((left.tensor && right.tensor) || (left.of && right.of) || (left.tested && right.tested))
    return std::nullopt;
  const bool strains = is_strain_or_more(left) && is_strain_or_more(right);
  if (strains && (left.unknown != right.unknown || !(left.tensor || right.tensor)))
    return std::nullopt;
  const MaterialUse& with_tensor = left.tensor ? left : right;
  if (!with_tensor.tensor) return std::nullopt;
  const auto kind = tensors[static_cast<std::size_t>(*with_tensor.tensor)].kind;
  const bool in_order = &with_tensor == &left && !left.tested && (left.of || right.of);
  if (!in_order && !solver::has_major_symmetry(kind)) return std::nullopt;
  MaterialUse out;
  out.factor = left.factor * right.factor;
  out.tensor = with_tensor.tensor;
  out.of = left.of ? left.of : right.of;
  out.tested = left.tested || right.tested;
  out.unknown = is_strain_or_more(left) ? left.unknown : right.unknown;
  return out;
}

} // namespace

std::vector<MaterialUse> scaled(std::vector<MaterialUse> uses, const Symbol& by) {
  for (MaterialUse& use : uses) use.factor = by * use.factor;
  return uses;
}

std::vector<MaterialUse> derivatives(std::vector<MaterialUse> uses, solver::Slot by,
                                     const std::vector<solver::TensorSpec>& tensors) {
  for (MaterialUse& use : uses) {
    const auto changes = [&](const Symbol& constant) { return constant.depends_on(by); };
    if (use.tensor &&
        std::ranges::any_of(tensors[static_cast<std::size_t>(*use.tensor)].constants, changes))
      return {};
    use.factor = solver::derivative(use.factor, by);
  }
  return uses;
}

std::vector<MaterialUse> joined(std::vector<MaterialUse> left,
                                const std::vector<MaterialUse>& right) {
  if (left.empty() || right.empty()) return {};
  for (const MaterialUse& use : right) {
    const auto same = std::ranges::find_if(
        left, [&](const MaterialUse& other) { return same_but_for_factor(use, other); });
    if (same != left.end())
      same->factor = same->factor + use.factor;
    else
      left.push_back(use);
  }
  return left.size() <= most_uses ? left : std::vector<MaterialUse>();
}

std::vector<MaterialUse> contracted(const Field& left, const Field& right,
                                    const std::vector<solver::TensorSpec>& tensors) {
  if (left.rank + right.rank > 6) return {}; // two tensors
  std::vector<MaterialUse> out;
  for (const MaterialUse& a : left.materials)
    for (const MaterialUse& b : right.materials) {
      const auto product = contracted(a, b, tensors);
      if (!product) return {};
      out = out.empty() ? std::vector{*product} : joined(std::move(out), {*product});
      if (out.empty()) return {};
    }
  return out;
}

std::vector<MaterialUse> memories_of(const Field& of, const KernelMaterials& kernels,
                                     const std::vector<solver::TensorSpec>& tensors) {
  std::vector<MaterialUse> out;
  for (const auto& [m, materials] : kernels)
    for (const MaterialUse& kernel : materials)
      for (MaterialUse memory : of.materials) {
        if (memory.of != solver::field_of_u(0)) return {};
        memory.of = solver::field_of_memory(m);
        if (kernel.tensor) {
          const auto product = contracted(kernel, memory, tensors);
          if (!product) return {};
          memory = *product;
        } else {
          memory.factor = kernel.factor * memory.factor;
        }
        out = out.empty() ? std::vector{memory} : joined(std::move(out), {memory});
        if (out.empty()) return {};
      }
  return out;
}

std::vector<MaterialUse> strains_of(const Field& functions) {
  const bool numbers = std::ranges::all_of(
      functions.materials, [](const MaterialUse& use) { return use.factor.is_constant(); });
  return functions.rank == 1 && numbers ? functions.materials : std::vector<MaterialUse>();
}

} // namespace hvi::lang
