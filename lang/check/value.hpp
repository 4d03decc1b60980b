// What an expression of a script means: a typed, symbolic value. A pointwise quantity is kept as
// scalar expressions of the solver's slots, one per component, so that linearity, kernels and
// tensors can be taken apart symbolically. Made by the checker, read by lang/lower.
#pragma once

#include "lang/diag/source.hpp"
#include "solver/kernel/expr.hpp"
#include "solver/kernel/prony_series.hpp"
#include "solver/plan/problem.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace hvi::lang {

/// One function for each alternative of a variant: std::visit(Overloaded{...}, value).
template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

using Symbol = solver::Expr; ///< a scalar symbolic expression
using Symbols3 = std::array<Symbol, 3>;

/// Row c of a law's argument: sum_i u[i] D_i u + offset, by derivative index (slot::value,
/// slot::gradient).
struct LawRow {
  std::array<Symbol, solver::slot::own_derivatives> u{};
  Symbol offset = 0.0;
  bool sees_gradient() const {
    return std::any_of(u.begin() + solver::slot::gradient(0, 0), u.end(),
                       [](const Symbol& of) { return !of.is(0.0); });
  }
};

/// One j^0( at; direction ) inside an integrand, times a factor.
struct LawUse {
  int law = -1; ///< index into Model::laws
  std::string name;
  Span span; ///< of the whole j^0(...)
  Symbol factor = 1.0;
  Span factor_span;       ///< where a factor stands, if any
  int field = 0;          ///< what the law sees (solver::field_of_u, field_of_memory)
  double of_memory = 1.0; ///< and how many times a memory
  /// By row, where that is not all: see solver::LawTerm.
  std::vector<std::vector<solver::SeenField>> seen;
  int unknown = 0;            ///< of which unknown
  bool mean = false;          ///< of both sides of a pair
  std::optional<int> rule_of; ///< see solver::LawTerm
  std::vector<LawRow> rows;
  int columns = 0; ///< of an argument that is a matrix, whose rows of a law are its entries; else 0
  bool sees_gradient() const {
    return std::ranges::any_of(rows, [](const LawRow& row) { return row.sees_gradient(); });
  }
};

/// factor * C : eps(w) : eps(v), with a tensor C of the model, w an unknown, its rate or a memory.
/// What stands there follows from the rank: w or v alone (1), C : eps(w) or one of its strains (2),
/// the whole (0), C (4).
struct MaterialUse {
  Symbol factor = 1.0;
  std::optional<int> tensor{}; ///< index into Model::tensors
  std::optional<int> of{};     ///< w, in the numbering of slot::field
  bool tested = false;         ///< with eps(v)
  int unknown = 0;             ///< of w and of v
};

/// What a kernel was written as: a Prony series of the lag times quantities of place.
struct SeriesTimes {
  solver::PronySeries series;
  Symbol sum;                         ///< the series as an expression
  std::vector<Symbol> of_place;       ///< one for each component
  std::vector<MaterialUse> materials; ///< that these are the sum of; see Field
};

/// How a quantity depends on a function: not at all, homogeneously linear, affine, or otherwise.
enum class Degree { none, linear, affine, nonlinear };

/// A pointwise quantity: rank 0 (scalar), 1 (vector), 2 (matrix), 4 (fourth-order tensor).
struct Field {
  int rank = 0;
  int rows = 1, columns = 1;         ///< rank 1: rows; rank 2: rows x columns; rank 4: rows = d
  std::vector<Symbol> components;    ///< row-major
  Degree test = Degree::none;        ///< in v
  Degree trial = Degree::none;       ///< in u, u' and the memory of u
  bool rate = false;                 ///< contains u' or u''
  bool acceleration = false;         ///< contains u''
  bool memory = false;               ///< contains history(...)
  bool read = false;                 ///< in a superpotential: is of what it reads of the solution
  bool by_slope = false;             ///< the body of a superpotential: a slope, not a potential
  bool law_vector = false;           ///< the vector argument of a superpotential: norm(xi) only
  std::vector<LawUse> laws;          ///< rank 0 only
  std::optional<SeriesTimes> series; ///< of a scalar or a fourth-order tensor written as that
  std::vector<Symbol> across;        ///< in plane strain: see across.hpp; empty: not known
  /// The value is the sum of these. None: it was written in some other way.
  std::vector<MaterialUse> materials;
  int depth = 0; ///< operations within each other, at most

  const Symbol& scalar() const { return components.front(); }
};

/// A word that stands for itself: P1, bdf2, nodal.
struct Word {
  std::string text;
};
struct TextValue {
  std::string text;
};
/// A declared thing that is no quantity, by its index in the model.
struct MeshValue {
  int index; ///< 0: the mesh of the problem, i: its i-th piece
};
struct PartValue {
  int index;
};
struct SpaceValue {
  int index;
};
/// Things that are called: by their declaration.
struct FunctionValue {
  int declaration;
};
struct KernelValue {
  int declaration;
};
struct LawValue {
  int declaration;
};
/// Something wrong that has been reported: silences what follows from it.
struct Poison {};

using Value = std::variant<Poison, Field, Word, TextValue, MeshValue, PartValue, SpaceValue,
                           FunctionValue, KernelValue, LawValue>;

inline bool is_poison(const Value& value) { return std::holds_alternative<Poison>(value); }

Field scalar_field(Symbol symbol);
Field vector_field(std::vector<Symbol> components);
Field matrix_field(int rows, int columns, std::vector<Symbol> components);
Field tensor_field(int dim, std::vector<Symbol> components);

/// "a scalar", "a vector of 2", "a 2 x 2 matrix", "a fourth-order tensor".
std::string describe(const Field& field);
std::string describe(const Value& value);
/// The same; of a number that is known the number: "the number 3".
std::string describe_with_number(const Value& value);
bool same_shape(const Field& a, const Field& b);
/// Neither x, t, lag, u nor v in it.
bool is_constant(const Field& field);

} // namespace hvi::lang
