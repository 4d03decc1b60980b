// Material tensors and Voigt matrices.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/material_places.hpp"

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>

namespace hvi::lang {

class Tensors {
public:
  Tensors(const Context& context, MaterialPlaces& places)
      : mistakes_(context.mistakes), model_(context.model), evaluator_(context.evaluator),
        places_(places) {}

  Value tensor_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                    const Scope& scope);
  /// E0442 for a fourth-order tensor of an axisymmetric body that couples strains in the section
  /// with shears out of it: a load in the section would twist the body.
  Field solid_tensor(const Field& material) const;
  bool twists(const Span& span, const Field& tensor);
  /// W0104 for every nearly incompressible tensor in a space of P1 vectors. Crossed triangles do
  /// not lock in the plane: the divergence of P1 on them leaves enough freedom (tests/convergence).
  void check_locking();
  /// Its index in the model, where it is known already or not.
  int add_tensor(solver::TensorSpec spec);
  /// A declared tensor: one of the library, a multiple of a declared one, or a tensor of its own.
  void name_tensor(Field& value, const ast::Name& name);

private:
  /// A tensor of the model as a value.
  Field tensor_value(solver::TensorSpec spec);
  std::optional<Symbol> symbol_of(const ast::Expr* a, const Scope& scope);
  std::optional<Symbols3> three_symbols(const ast::Expr* a, const char* what, const Scope& scope);
  std::optional<std::array<solver::Point, 3>> material_axes(const ast::Expr* a);
  std::optional<solver::Point> material_axis(const ast::Expr* a);
  Value isotropic_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  Value voigt_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  Value orthotropic_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  Value transverse_call(const ast::Expr& e, const ast::Call& c, const Scope& scope);
  std::optional<bool> takes_constants(const ast::Expr& e, const std::string& callee,
                                      std::span<const ast::Expr* const> others,
                                      std::span<const ast::Expr* const> constants,
                                      const std::string& names);
  Value material_call(const ast::Expr& e, const ast::Call& call, const std::string& name,
                      const Scope& scope);

  Mistakes& mistakes_;
  Model& model_;
  Evaluator& evaluator_;
  MaterialPlaces& places_;
  std::unordered_multimap<std::size_t, int> index_; ///< of the model's tensors, by their hashes
  std::map<std::size_t, std::pair<Span, double>> locking_; ///< nearly incompressible tensors
};

} // namespace hvi::lang
