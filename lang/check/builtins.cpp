// The table of built-ins.
#include "lang/check/builtins.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace hvi::lang {

namespace {

using K = BuiltInKind;

constexpr std::array table = {
    BuiltIn{"abs", K::pointwise, "abs(a)", "absolute value"},
    BuiltIn{"acos", K::pointwise, "acos(a)", "inverse cosine"},
    BuiltIn{"asin", K::pointwise, "asin(a)", "inverse sine"},
    BuiltIn{"atan", K::pointwise, "atan(a)", "inverse tangent"},
    BuiltIn{"atan2", K::pointwise, "atan2(y, x)", "angle of the point (x, y)"},
    BuiltIn{"bessel_j", K::pointwise, "bessel_j(n, a)", "Bessel function of the first kind"},
    BuiltIn{"cos", K::pointwise, "cos(a)", "cosine"},
    BuiltIn{"cosh", K::pointwise, "cosh(a)", "hyperbolic cosine"},
    BuiltIn{"erf", K::pointwise, "erf(a)", "error function"},
    BuiltIn{"erfc", K::pointwise, "erfc(a)",
            "complementary error function, 1 - erf(a); write exp(a^2)*erfc(a), infinity times 0 "
            "beyond a = 27, as erfcx(a)"},
    BuiltIn{"erfcx", K::pointwise, "erfcx(a)",
            "exp(a^2)*erfc(a), which neither overflows nor vanishes where a is large"},
    BuiltIn{"exp", K::pointwise, "exp(a)", "exponential"},
    BuiltIn{"gamma", K::pointwise, "gamma(a)", "gamma function"},
    BuiltIn{"log", K::pointwise, "log(a)", "natural logarithm"},
    BuiltIn{"max", K::pointwise, "max(a, b, ...)", "largest of its arguments"},
    BuiltIn{"min", K::pointwise, "min(a, b, ...)", "least of its arguments"},
    BuiltIn{"mittag_leffler", K::pointwise, "mittag_leffler(alpha, [beta,] a)",
            "Mittag-Leffler function E_{alpha,beta}(a), beta = 1 when left out"},
    BuiltIn{"pos", K::pointwise, "pos(a)", "positive part, max(a, 0)"},
    BuiltIn{"sign", K::pointwise, "sign(a)", "-1, 0 or 1"},
    BuiltIn{"sin", K::pointwise, "sin(a)", "sine"},
    BuiltIn{"sinh", K::pointwise, "sinh(a)", "hyperbolic sine"},
    BuiltIn{"sqrt", K::pointwise, "sqrt(a)", "square root"},
    BuiltIn{"tan", K::pointwise, "tan(a)", "tangent"},
    BuiltIn{"tanh", K::pointwise, "tanh(a)", "hyperbolic tangent"},
    BuiltIn{"div", K::differential, "div(u)", "divergence of a vector"},
    BuiltIn{"eps", K::differential, "eps(u)", "symmetric gradient of a vector: the strain"},
    BuiltIn{"grad", K::differential, "grad(u)", "gradient of a scalar (vector) or vector (matrix)"},
    BuiltIn{"dev", K::algebraic, "dev(e)", "deviator e - tr(e)/d I of a matrix"},
    BuiltIn{"dot", K::algebraic, "dot(a, b)", "inner product; also matrix times vector"},
    BuiltIn{"identity", K::algebraic, "identity()", "identity matrix of the space dimension"},
    BuiltIn{"norm", K::algebraic, "norm(a)", "Euclidean norm; norm(u) alone in a table: V norm"},
    BuiltIn{"mises", K::algebraic, "mises(sigma)", "equivalent stress of von Mises of a stress"},
    BuiltIn{"tr", K::algebraic, "tr(e)", "trace of a matrix"},
    BuiltIn{"transpose", K::algebraic, "transpose(e)", "transposed matrix"},
    BuiltIn{"derivative", K::tensor, "derivative(a)",
            "of a by the lag in a kernel, by t elsewhere"},
    BuiltIn{"isotropic", K::tensor,
            "isotropic(lambda = , mu = ) or isotropic(young = , poisson = )",
            "lambda tr(e) I + 2 mu e; plane strain in 2D"},
    BuiltIn{"orthotropic", K::tensor,
            "orthotropic(young = [x, y, z], poisson = [xy, yz, xz], shear = [xy, yz, xz], axes = "
            "[[..], ..])",
            "three planes of symmetry; or by E1, E2, E3, nu12, nu23, nu13, G12, G23, G13"},
    BuiltIn{"prony", K::tensor, "prony(weights = [..], times = [..])",
            "sum of weights[i] exp(-lag/times[i]), in a kernel"},
    BuiltIn{"prony_relaxation", K::tensor, "prony_relaxation(weights = [..], times = [..])",
            "derivative of that sum: the kernel of a relaxation modulus"},
    BuiltIn{"table", K::tensor, "table(\"file.csv\", a, interpolation = linear)",
            "tabulated function of a; of the lag in kernels and of t elsewhere when a is left out"},
    BuiltIn{
        "transverse", K::tensor,
        "transverse(young = , poisson = , young_axis = , poisson_axis = , shear_axis = , axis = )",
        "transversely isotropic about an axis; or by E1 (along it), E2, nu12, nu23, G12"},
    BuiltIn{"voigt", K::tensor, "voigt([[..], ..])",
            "by its matrix on (xx, yy, [zz, yz, xz,] xy), axisymmetric (xx, yy, zz, xy), with "
            "engineering shear strains"},
    BuiltIn{"history", K::memory, "history(C, eps(u))", "int_0^t C(t - s) eps(u(s)) ds"},
    BuiltIn{"gap", K::interface, "gap(seam)", "distance of the sides of a pair, along the normal"},
    BuiltIn{"jump", K::interface, "jump(u)",
            "on a pair: the value on its first side minus that on the second"},
    BuiltIn{"mean", K::interface, "mean(theta)", "on a pair: the mean of the values on both sides"},
    BuiltIn{"pair", K::interface, "pair(upper.bottom, lower.top, reach = )",
            "two sides that touch; the first carries the integral and the normal"},
    BuiltIn{"integral", K::region, "integral(part, a, rule = nodal)", "integral over a part"},
    BuiltIn{"inside", K::region, "inside(part)", "condition: the point lies in the part"},
    BuiltIn{"largest", K::region, "largest(part, a)", "largest value on a part, in a report"},
    BuiltIn{"point", K::region, "point(mesh, [x, y])", "a node of the mesh as a part"},
    BuiltIn{"reaction", K::region, "reaction(part, of = u)",
            "force by which what holds a part, or a law on it, acts on the body"},
    BuiltIn{"smallest", K::region, "smallest(part, a)", "least value on a part, in a report"},
    BuiltIn{"box", K::mesh, "box(a, b, c, cells = [n, m, l])", "structured mesh of a box"},
    BuiltIn{"gmsh", K::mesh, "gmsh(\"file.msh\")", "mesh from a file"},
    BuiltIn{"interval", K::mesh, "interval(a, cells = n)", "mesh of (0, a)"},
    BuiltIn{"rectangle", K::mesh, "rectangle(a, b, cells = [n, m], pattern = diagonal)",
            "structured mesh of (0, a) x (0, b), one diagonal or two (crossed); with "
            "`axisymmetric = true` a body of revolution"},
};

constexpr std::array<std::string_view, 29> word_table = {
    "P1",        "P2",       "backward_euler", "bdf2",       "nodal",   "midpoint",     "gauss",
    "exact",     "endpoint", "average",        "continuing", "release", "least_energy", "automatic",
    "recursion", "fit",      "tree",           "direct",     "linear",  "cubic",        "affine",
    "constant",  "diagonal", "crossed",        "euler",      "newmark", "hht",          "true",
    "false"};

constexpr std::array<std::string_view, 8> reserved_names = {"t",  "x",   "y",      "z",
                                                            "pi", "lag", "normal", "sigma"};

} // namespace

std::span<const BuiltIn> built_ins() { return table; }

const BuiltIn* find_built_in(std::string_view name) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const BuiltIn& b) { return b.name == name; });
  return found == table.end() ? nullptr : &*found;
}

bool is_function_name(std::string_view name) { return find_built_in(name) != nullptr; }

bool is_word(std::string_view name) {
  return std::find(word_table.begin(), word_table.end(), name) != word_table.end();
}

std::span<const std::string_view> words() { return word_table; }

std::span<const std::string_view> setting_names() {
  static constexpr std::array<std::string_view, 14> names = {
      "scheme",           "load",      "quadrature", "tolerance",   "branch",
      "memory_tolerance", "memory",    "accuracy",   "accuracy_of", "threads",
      "interpolant",      "hht_alpha", "solver",     "factor"};
  return names;
}

bool is_reserved_builtin(std::string_view name) {
  const BuiltIn* const found = find_built_in(name);
  // Scripts had names of their own before these.
  constexpr std::array<std::string_view, 9> later = {
      "pos",  "mises", "largest", "reaction", "smallest", "derivative", "prony_relaxation",
      "erfc", "erfcx"};
  const bool free = std::ranges::find(later, name) != later.end() ||
                    (found && found->kind == BuiltInKind::interface);
  return (found && !free) ||
         std::find(reserved_names.begin(), reserved_names.end(), name) != reserved_names.end();
}

std::vector<std::string_view> visible_built_ins() {
  std::vector<std::string_view> names;
  names.reserve(table.size() + reserved_names.size());
  for (const BuiltIn& b : table) names.push_back(b.name);
  for (std::string_view name : reserved_names) names.push_back(name);
  return names;
}

std::optional<int> pointwise_arity(std::string_view name) {
  const BuiltIn* found = find_built_in(name);
  if (!found || found->kind != BuiltInKind::pointwise) return std::nullopt;
  if (name == "atan2" || name == "bessel_j" || name == "min" || name == "max") return 2;
  return name == "mittag_leffler" ? 3 : 1;
}

solver::Op pointwise_op(std::string_view name) {
  using solver::Op;
  constexpr std::array<std::pair<std::string_view, Op>, 22> ops = {{
      {"abs", Op::abs},   {"acos", Op::acos},   {"asin", Op::asin},
      {"atan", Op::atan}, {"atan2", Op::atan2}, {"bessel_j", Op::bessel_j},
      {"cos", Op::cos},   {"cosh", Op::cosh},   {"erf", Op::erf},
      {"exp", Op::exp},   {"gamma", Op::gamma}, {"log", Op::log},
      {"max", Op::max},   {"min", Op::min},     {"sign", Op::sign},
      {"sin", Op::sin},   {"sinh", Op::sinh},   {"sqrt", Op::sqrt},
      {"tan", Op::tan},   {"tanh", Op::tanh},   {"mittag_leffler", Op::mittag_leffler},
      {"erfc", Op::erfc},
  }};
  for (const auto& [op_name, op] : ops)
    if (op_name == name) return op;
  return Op::constant;
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

} // namespace hvi::lang
