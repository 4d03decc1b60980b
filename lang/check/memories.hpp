// Memories: kernels, and history(C, eps(u)).
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/material_use.hpp"
#include "lang/check/tensors.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hvi::lang {

class Memories {
public:
  Memories(const Context& context, Tensors& tensors)
      : mistakes_(context.mistakes), names_(context.names), find_(context.find),
        model_(context.model), unknowns_(context.unknowns), evaluator_(context.evaluator),
        tensors_(tensors) {}

  /// The kernel as a value of lag and t; nothing (reported) where it is none.
  std::optional<Field> kernel_field(const ast::Expr& callee, const Scope& scope);
  Value history_call(const ast::Expr& e, const ast::Call& call, const Scope& scope);
  /// E0502 where a kernel of t and s is not finite between the times of the problem. Kernels of the
  /// lag alone are integrated by the engine, which knows their singularity at lag 0, and so are
  /// those that are infinite at the start of the run only: integrable, or refused with their place.
  void check_kernels_in_time();

private:
  /// T_m of each memory m, component by component.
  using KernelParts = std::map<int, std::vector<Symbol>>;
  std::optional<std::pair<int, double>> known_history(const Symbol& kernel) const;
  std::optional<Field> history_argument(const ast::Expr& e, const ast::Expr& argument,
                                        const Field& kernel, const Scope& scope);
  std::optional<KernelParts> parts_of_kernel(const Field& kernel, const std::string& name);
  bool split_material(const MaterialUse& use, KernelMaterials& out);
  KernelMaterials materials_of_kernel(const Field& kernel, const KernelParts& parts);
  std::vector<Symbol> across_of_memories(const Field& kernel, const KernelParts& strains) const;
  std::vector<Symbol> across_of_history(const Field& kernel, const Field& of,
                                        const KernelParts& parts,
                                        const KernelParts& memories) const;

  Mistakes& mistakes_;
  const Names& names_;
  const ast::Find* const find_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  Tensors& tensors_;
};

} // namespace hvi::lang
