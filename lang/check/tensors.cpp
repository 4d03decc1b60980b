#include "lang/check/tensors.hpp"

#include "lang/check/across.hpp"
#include "solver/kernel/algebra.hpp"
#include "solver/linear/dense.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hvi::lang {

namespace {

/// The 6 x 6 matrix in the order of Voigt of a 4 x 4 one on xx, yy, zz, xy: no shear out of the
/// section.
std::vector<Symbol> without_twist(const std::vector<Symbol>& m) {
  constexpr std::array<std::size_t, 4> place = {0, 1, 2, 5};
  std::vector<Symbol> out(36, Symbol(0.0));
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) out[place[i] * 6 + place[j]] = m[i * 4 + j];
  return out;
}

/// Rows: two directions normal to `axis`, then `axis`, each of length one; a coordinate axis gives
/// coordinate axes.
std::array<solver::Point, 3> frame_around(const solver::Point& axis) {
  const Eigen::Vector3d a = Eigen::Map<const Eigen::Vector3d>(axis.data()).normalized();
  Eigen::Index least = 0;
  a.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d b = (Eigen::Vector3d::Unit(least) - a[least] * a).normalized();
  const Eigen::Vector3d c(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                          a[0] * b[1] - a[1] * b[0]);
  return {{{b[0], b[1], b[2]}, {c[0], c[1], c[2]}, {a[0], a[1], a[2]}}};
}

/// Symmetric part of the Mandel matrix of C, whose entries with shear are weighted by sqrt 2: the
/// form tau : C : tau in an orthonormal basis of the symmetric matrices.
Eigen::MatrixXd mandel_matrix(int d, const Field& c) {
  std::vector<std::array<int, 2>> pairs;
  for (int i = 0; i < d; ++i) pairs.push_back({i, i});
  for (int i = 0; i < d; ++i)
    for (int j = i + 1; j < d; ++j) pairs.push_back({i, j});
  const auto n = static_cast<int>(pairs.size());
  Eigen::MatrixXd mandel(n, n);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const auto [i, j] = pairs[a];
      const auto [k, l] = pairs[b];
      const double weight = (i == j ? 1.0 : std::sqrt(2.0)) * (k == l ? 1.0 : std::sqrt(2.0));
      mandel(a, b) = weight * c.components[((i * d + j) * d + k) * d + l].value();
    }
  return 0.5 * (mandel + mandel.transpose());
}

/// How much stiffer the volume is than the shape: the mean pressure for a unit volume change
/// against the largest eigenvalue on matrices without trace; (lambda + 2 mu / d) / (2 mu) if
/// isotropic.
double volume_over_shape(int d, const Eigen::MatrixXd& mandel) {
  Eigen::VectorXd identity = Eigen::VectorXd::Zero(mandel.rows());
  identity.head(d).setConstant(1.0 / std::sqrt(d));
  const Eigen::MatrixXd without =
      Eigen::MatrixXd::Identity(mandel.rows(), mandel.rows()) - identity * identity.transpose();
  const Eigen::MatrixXd shape = without * mandel * without;
  return identity.dot(mandel * identity) / d /
         solver::symmetric_eigenvalues(shape)[mandel.rows() - 1];
}

/// Beyond this (poisson = 0.49) P1 answers much too stiffly.
constexpr double locking = 24.0;

} // namespace

Value Tensors::tensor_call(const ast::Expr& e, const ast::Call& c, const std::string& name,
                           const Scope& scope) {
  Value value = material_call(e, c, name, scope);
  const auto* material = std::get_if<Field>(&value);
  if (material && twists(e.span, *material)) return Poison{};
  // A Voigt matrix may be part of a memory kernel, which need not be elliptic.
  if (!material || name == "voigt") return value;
  const Field solid = solid_tensor(*material);
  if (!is_constant(*material)) {
    places_.note(e.span, solid, true);
    return value;
  }
  const double least = solver::symmetric_eigenvalues(mandel_matrix(solid.rows, solid))[0];
  if (least > 0.0 && model_.dim > 1) {
    const int dim = tensor_dim(model_);
    if (const double ratio = volume_over_shape(dim, mandel_matrix(dim, *material)); ratio > locking)
      locking_.insert_or_assign(e.span.begin, std::pair(e.span, ratio));
  }
  if (least > 0.0) return value;
  mistakes_.error("E0504", e.span,
                  fmt::format("the tensor is not elliptic: its least eigenvalue is {:.6g}", least));
  return Poison{};
}

/// What has to be elliptic. Constants by direction are those of a solid: a material with a negative
/// modulus across the plane is none in plane strain either, whose stiffness may hide that.
Field Tensors::solid_tensor(const Field& material) const {
  using Kind = solver::TensorSpec::Kind;
  const auto& spec = model_.tensors[static_cast<std::size_t>(*material.materials.front().tensor)];
  if (spec.kind != Kind::orthotropic && spec.kind != Kind::transverse) return material;
  return tensor_field(3, solver::components(spec, 3));
}

bool Tensors::twists(const Span& span, const Field& tensor) {
  if (!model_.mesh.axisymmetric || tensor.rank != 4) return false;
  double largest = 0.0;
  for (const Symbol& c : tensor.components)
    if (c.is_constant()) largest = std::max(largest, std::abs(c.value()));
  constexpr double rounding = 1e-12;
  for (int at = 0; at < 81; ++at) {
    const std::array<int, 4> index = {at / 27, at / 9 % 3, at / 3 % 3, at % 3};
    const bool left = (index[0] == 2) != (index[1] == 2),
               right = (index[2] == 2) != (index[3] == 2);
    const Symbol& c = tensor.components[static_cast<std::size_t>(at)];
    if (left == right || (c.is_constant() && std::abs(c.value()) <= rounding * largest)) continue;
    mistakes_.error("E0442", span, "this tensor couples the section with shears out of it",
                    "the body would be twisted: axes lie in the section or along the circles (z)");
    return true;
  }
  return false;
}

void Tensors::check_locking() {
  const bool free = model_.mesh.crossed && !model_.mesh.axisymmetric;
  if (!model_.space.vector || model_.space.order != 1 || free) return;
  for (const auto& [at, tensor] : locking_)
    mistakes_.add(
        diagnose("W0104", tensor.first,
                 fmt::format("nearly incompressible: the volume is {:.3g} times stiffer than the "
                             "shape, and P1 locks",
                             tensor.second))
            .with_help(
                std::string("take P2, `space V = vector P2 on ...`") +
                (model_.mesh.axisymmetric
                     ? ""
                     : "; on a rectangle `pattern = crossed` keeps the full order of both")));
}

Field Tensors::tensor_value(solver::TensorSpec spec) {
  Field out = tensor_field(tensor_dim(model_), components(spec, tensor_dim(model_)));
  if (tensor_dim(model_) == 2) out.across = across_of_tensor(spec);
  out.materials = {{.tensor = add_tensor(std::move(spec))}};
  return out;
}

namespace {

/// The same for tensors that are the same, whatever they are called.
std::size_t hash_of(const solver::TensorSpec& spec) {
  auto out = static_cast<std::size_t>(spec.kind);
  for (const Symbol& constant : spec.constants) out = 31 * out + constant.hash();
  return out;
}

} // namespace

int Tensors::add_tensor(solver::TensorSpec spec) {
  auto& known = model_.tensors;
  const std::size_t hash = hash_of(spec);
  const auto [first, past] = index_.equal_range(hash);
  const auto same = std::find_if(first, past, [&](const auto& other) {
    return same_tensor(spec, known[static_cast<std::size_t>(other.second)]);
  });
  if (same != past) return same->second;
  known.push_back(std::move(spec));
  const int index = static_cast<int>(known.size()) - 1;
  index_.emplace(hash, index);
  return index;
}

void Tensors::name_tensor(Field& value, const ast::Name& name) {
  using Kind = solver::TensorSpec::Kind;
  if (value.materials.size() != 1)
    value.materials = {{.tensor = add_tensor({{}, {}, Kind::general, value.components})}};
  const MaterialUse& use = value.materials.front();
  solver::TensorSpec& spec = model_.tensors[static_cast<std::size_t>(*use.tensor)];
  if (!use.factor.is(1.0) || !spec.name.empty()) return;
  spec.name = name.text;
  spec.origin = model_.origin(name.span);
}

std::optional<Symbol> Tensors::symbol_of(const ast::Expr* a, const Scope& scope) {
  auto f = evaluator_.scalar(*a, scope);
  return f ? std::optional(f->scalar()) : std::nullopt;
}

std::optional<Symbols3> Tensors::three_symbols(const ast::Expr* a, const char* what,
                                               const Scope& scope) {
  auto f = evaluator_.field(*a, scope);
  if (!f) return std::nullopt;
  if (f->rank == 1 && f->rows == 3)
    return Symbols3{f->components[0], f->components[1], f->components[2]};
  mistakes_.error("E0307", a->span,
                  fmt::format("`{}` is a list of three, not {}", what, describe(*f)));
  return std::nullopt;
}

/// Rows of length one; the identity where nothing is written.
std::optional<std::array<solver::Point, 3>> Tensors::material_axes(const ast::Expr* a) {
  std::array<solver::Point, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  if (!a) return rows;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> m(rows[0].data());
  Scope constants;
  constants.what = "material axes";
  auto f = evaluator_.field(*a, constants);
  if (!f) return std::nullopt;
  if (f->rank == 2 && f->rows == f->columns && (f->rows == 2 || f->rows == 3) && is_constant(*f)) {
    for (int i = 0; i < f->rows; ++i)
      for (int j = 0; j < f->rows; ++j) m(i, j) = f->components[i * f->rows + j].value();
    for (int i = 0; i < 3; ++i) m.row(i).normalize();
    if ((m * m.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-10) return rows;
  }
  mistakes_.error("E0308", a->span,
                  "axes are 2 or 3 orthogonal constant vectors: `[[1, 1], [-1, 1]]`");
  return std::nullopt;
}

/// The third direction where nothing is written.
std::optional<solver::Point> Tensors::material_axis(const ast::Expr* a) {
  if (!a) return solver::Point{0, 0, 1};
  auto list = evaluator_.constant_list(*a, "the axis");
  if (!list) return std::nullopt;
  if (list->size() != 3 && static_cast<int>(list->size()) != model_.dim) {
    mistakes_.error("E0307", a->span, fmt::format("the axis is a vector of {} or 3", model_.dim));
    return std::nullopt;
  }
  solver::Point axis{};
  std::ranges::copy(*list, axis.begin());
  if (axis != solver::Point{}) return axis;
  mistakes_.error("E0308", a->span, "the axis is a vector that is not zero");
  return std::nullopt;
}

Value Tensors::isotropic_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  auto args = evaluator_.match(e, c, "isotropic", {"lambda", "mu", "young", "poisson"}, 0);
  if (!args) return Poison{};
  const bool lame = (*args)[0] && (*args)[1] && !(*args)[2] && !(*args)[3];
  const bool engineering = (*args)[2] && (*args)[3] && !(*args)[0] && !(*args)[1];
  if (!lame && !engineering) {
    mistakes_.error("E0305", e.span,
                    "`isotropic` takes either `lambda` and `mu`, or `young` and `poisson`");
    return Poison{};
  }
  auto a = symbol_of((*args)[lame ? 0 : 2], scope), b = symbol_of((*args)[lame ? 1 : 3], scope);
  if (!a || !b) return Poison{};
  if (lame) return tensor_value({{}, {}, solver::TensorSpec::Kind::isotropic, {*a, *b}});
  if (b->is_constant() && !(b->value() > -1.0 && b->value() < 0.5)) {
    mistakes_.error(
        "E0504", (*args)[3]->span,
        fmt::format("poisson = {} is outside (-1, 0.5): the tensor is not elliptic", b->value()),
        b->value() == 0.5 ? "an incompressible body needs a mixed method; take `0.4999` with P2"
                          : "");
    return Poison{};
  }
  const Symbol one = 1.0, two = 2.0;
  return tensor_value({{},
                       {},
                       solver::TensorSpec::Kind::isotropic,
                       {*a * *b / ((one + *b) * (one - two * *b)), *a / (two * (one + *b))}});
}

Value Tensors::voigt_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  auto args = evaluator_.match(e, c, "voigt", {"matrix"}, 1);
  if (!args) return Poison{};
  auto f = evaluator_.field(*(*args)[0], scope);
  if (!f) return Poison{};
  const bool ring = model_.mesh.axisymmetric;
  const int d = model_.dim, n = ring ? 4 : d * (d + 1) / 2;
  if (f->rank != 2 || f->rows != n || f->columns != n) {
    mistakes_.error("E0307", (*args)[0]->span,
                    fmt::format("{} a Voigt matrix is {} x {}, not {}",
                                ring ? "in a body of revolution" : fmt::format("in {}D", d), n, n,
                                describe(*f)),
                    ring     ? "order: xx, yy, zz, xy, where zz is along the circles"
                    : d == 2 ? "order: xx, yy, xy"
                             : "order: xx, yy, zz, yz, xz, xy");
    return Poison{};
  }
  return tensor_field(tensor_dim(model_),
                      ring ? solver::of_voigt_matrix(3, without_twist(f->components))
                           : solver::of_voigt_matrix(d, f->components));
}

/// Constants given one by one (`nu12 = ..`) instead of what a call takes otherwise: all of them and
/// nothing else, but for its last argument. None: the call has no such constant; false: said why
/// not.
std::optional<bool> Tensors::takes_constants(const ast::Expr& e, const std::string& callee,
                                             std::span<const ast::Expr* const> others,
                                             std::span<const ast::Expr* const> constants,
                                             const std::string& names) {
  const auto given = [](const ast::Expr* a) { return a != nullptr; };
  if (std::ranges::none_of(constants, given)) return std::nullopt;
  if (std::ranges::all_of(constants, given) && std::ranges::none_of(others, given)) return true;
  mistakes_.error("E0305", e.span,
                  fmt::format("`{}` takes all of {}, and nothing in their place", callee, names));
  return false;
}

Value Tensors::orthotropic_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  auto args = evaluator_.match(e, c, "orthotropic",
                               {"young", "poisson", "shear", "axes", "E1", "E2", "E3", "nu12",
                                "nu23", "nu13", "G12", "G23", "G13"},
                               0);
  if (!args) return Poison{};
  const std::span<const ast::Expr* const> all(*args);
  const auto one_by_one = takes_constants(e, "orthotropic", all.subspan(0, 3), all.subspan(4),
                                          "E1, E2, E3, nu12, nu23, nu13, G12, G23, G13");
  if (one_by_one == false) return Poison{};
  const auto three = [&](std::size_t list, std::size_t first,
                         const char* what) -> std::optional<Symbols3> {
    if (!one_by_one && !all[list]) {
      mistakes_.error("E0305", e.span, fmt::format("`orthotropic` needs its argument `{}`", what));
      return std::nullopt;
    }
    if (!one_by_one) return three_symbols(all[list], what, scope);
    Symbols3 out;
    for (std::size_t i = 0; i < 3; ++i) {
      auto value = symbol_of(all[first + i], scope);
      if (!value) return std::nullopt;
      out[i] = *value;
    }
    return out;
  };
  const auto young = three(0, 4, "young"), poisson = three(1, 7, "poisson"),
             shear = three(2, 10, "shear");
  auto axes = material_axes((*args)[3]);
  if (!young || !poisson || !shear || !axes) return Poison{};
  std::vector<Symbol> constants;
  for (const Symbols3* list : {&*young, &*poisson, &*shear})
    constants.insert(constants.end(), list->begin(), list->end());
  return tensor_value({{}, {}, solver::TensorSpec::Kind::orthotropic, std::move(constants), *axes});
}

/// Isotropic in the plane normal to `axis`.
Value Tensors::transverse_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  const std::vector<std::string> names = {"young",      "poisson", "young_axis", "poisson_axis",
                                          "shear_axis", "axis",    "E2",         "nu23",
                                          "E1",         "nu12",    "G12"};
  auto args = evaluator_.match(e, c, "transverse", names, 0);
  if (!args) return Poison{};
  const std::span<const ast::Expr* const> all(*args);
  const auto one_by_one = takes_constants(e, "transverse", all.subspan(0, 5), all.subspan(6),
                                          "E1, E2, nu12, nu23, G12");
  if (one_by_one == false) return Poison{};
  std::vector<Symbol> constants;
  for (std::size_t i = 0; i < 5; ++i) {
    const ast::Expr* const given = all[one_by_one ? 6 + i : i];
    if (!given) {
      mistakes_.error("E0305", e.span,
                      fmt::format("`transverse` needs its argument `{}`", names[i]));
      return Poison{};
    }
    if (const auto v = symbol_of(given, scope)) constants.push_back(*v);
  }
  const auto axis = constants.size() == 5 ? material_axis((*args)[5]) : std::nullopt;
  if (!axis) return Poison{};
  return tensor_value(
      {{}, {}, solver::TensorSpec::Kind::transverse, std::move(constants), frame_around(*axis)});
}

Value Tensors::material_call(const ast::Expr& e, const ast::Call& c, const std::string& name,
                             const Scope& scope) {
  if (name == "isotropic") return isotropic_call(e, c, scope);
  if (name == "voigt") return voigt_call(e, c, scope);
  if (name == "orthotropic") return orthotropic_call(e, c, scope);
  return transverse_call(e, c, scope);
}

} // namespace hvi::lang
