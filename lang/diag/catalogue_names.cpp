// Catalogue of diagnostics, class E03: names, types and shapes.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto names_entries = std::to_array<CatalogueEntry>({
    {"E0301", "unknown name",
     R"(
Nothing of this name is declared in the script, in its imports or in the language. The help line
proposes the nearest name, or the `import` of the module that declares this one.)",
     R"(
tensor B = isotropic(young = yuong, poisson = 0.3))",
     R"(
param young = 70
tensor B = isotropic(young = young, poisson = 0.3))"},
    {"E0302", "declared twice",
     R"(
Every name is declared once. Reading order does not matter, so a second declaration would be
ambiguous. Columns have names of their own, beside `t`, and two results do not go to one file:
tables end in `.csv`, fields in `.pvd` with `NAME_00001.vtu` and the like. Nothing is said twice:
`zero on p` and `zero.x on p` of one space, `fields u, u`, `vary n in [2, 2]`.)",
     R"(
param n = 8
param n = 16)",
     R"(
param n = 8
param m = 16)"},
    {"E0303", "no such member",
     R"(
The thing before the dot has no member of this name. A `.` is member access only: products are
`*`, `:` and `dot`.)",
     R"(
part roof = slab.tpo)",
     R"(
part roof = slab.top)"},
    {"E0304", "unknown argument",
     R"(
The called thing has no argument of this name.)",
     R"(
tensor B = isotropic(lambda = 1, nu = 2))",
     R"(
tensor B = isotropic(lambda = 1, mu = 2))"},
    {"E0305", "wrong number of arguments",
     R"(
An argument is missing, given twice, or one too many.)",
     R"(
tensor B = isotropic(young = 70))",
     R"(
tensor B = isotropic(young = 70, poisson = 0.3))"},
    {"E0306", "wrong kind of thing",
     R"(
A number, tensor, mesh, part, law or kernel stands where another kind is expected.)",
     R"(
integral(slab, B : eps(u)))",
     R"(
integral(slab, B : eps(u) : eps(v)))"},
    {"E0307", "shapes differ",
     R"(
Both sides of a sum, the entries of a list and an imposed value have one shape.)",
     R"(
param a = 1
fn f() = [1, 2] + a)",
     R"(
fn f() = [1, 2] + [1, 1])"},
    {"E0308", "wrong ranks in a product",
     R"(
`*` multiplies by a scalar, `dot` contracts one index, `:` contracts two.)",
     R"(
integral(slab, [0, -1] * v))",
     R"(
integral(slab, dot([0, -1], v)))"},
    {"E0309", "not visible here",
     R"(
The name exists, but not in this place: a tensor does not depend on time, a kernel of the lag not
on `t`, only boundary integrals have a normal.)",
     R"(
kernel C(lag) = -exp(-t) * B)",
     R"(
kernel C(lag) = -exp(-lag) * B)"},
    {"E0310", "not a function",
     R"(
Only functions, superpotentials (inside superpotentials) and built-in functions are called.)",
     R"(
param k = 2
fn f() = k(3))",
     R"(
param k = 2
fn f() = k * 3)"},
    {"E0311", "built in",
     R"(
Names of the language cannot be declared again.)",
     R"(
param eps = 1e-3)",
     R"(
param epsilon = 1e-3)"},
    {"E0312", "wrong test space",
     R"(
The unknown and the test functions run through the same space.)",
     R"(
find u in V such that for all v in W)",
     R"(
find u in V such that for all v in V)"},
    {"E0313", "circular definition",
     R"(
A value cannot depend on itself, neither directly nor through other declarations.)",
     R"(
param a = b
param b = a)",
     R"(
param a = 1
param b = a)"},
    {"E0315", "no such component",
     R"(
Components are called x, y and in 3D z; a scalar has none.)",
     R"(
integral(slab, v.z))",
     R"(
integral(slab, v.y))"},
    {"E0316", "unknown setting or word",
     R"(
A setting, element, rule or scheme that does not exist.)",
     R"(
space V = vector P3 on slab)",
     R"(
space V = vector P2 on slab)"},
    {"E0318", "unknown module",
     R"(
There is no module of this name in the standard library. A file is imported by its name in quotes.)",
     R"(
import frictoin)",
     R"(
import friction)"},
    {"E0319", "unknown column",
     R"(
An expectation names a column of a table of the report.)",
     R"(
expect u_z = 1 within 1e-6)",
     R"(
expect u_y = 1 within 1e-6)"},
    {"E0320",
     "unknown parameter set",
     R"(
What is set from outside is a declared `param`; the script declares none of this name.)",
     {},
     {}},
    {"E0321",
     "parameter set to a wrong value",
     R"(
A parameter is set to a number or a word of the language.)",
     {},
     {}},
    {"E0330", "unknown unit",
     R"(
Units are those of the SI and those derived from them, with prefixes: `mm`, `kN`, `MPa`, `kg/m^3`, `W/(m*K)`, `1/s`; the
list is in docs/language.md. Temperatures are in `K`: `degC` does not begin at zero, so that it is no unit to multiply by.)",
     R"(
param E = 70 [Gpa])",
     R"(
param E = 70 [GPa])"},
    {"E0331", "units that do not fit",
     R"(
Both sides of a sum, a comparison and a case, the arguments of `min` and `max` and the entries of a list are of one dimension;
so are all integrals of the inequality, for each unit of the test function. The argument of `exp` and an exponent are numbers.)",
     R"(
param width = 3 [mm]
param total = width + 2 [s])",
     R"(
param width = 3 [mm]
param total = width + 2 [mm])"},
    {"E0332", "a bare number beside a quantity",
     R"(
In a script with units a number without one is a number: it cannot be added to a length, nor be one. Only 0 is the same in
every unit. Lengths of meshes, coordinates, times and values of unknowns need theirs; `[0, 10] [s]` gives it to a whole list.)",
     R"(
param width = 3 [mm]
param total = width + 2)",
     R"(
param width = 3 [mm]
param total = width + 2 [mm])"},
    {"E0333", "a wrong system of units",
     R"(
`units mm, N, s` says what a script is computed and shown in: once, by units of which none follows from those before it.)",
     R"(
units mm, N, MPa)",
     R"(
units mm, N, s)"},
    {"E0334",
     "parameter set with a unit in a script without units",
     R"(
A parameter is set with a unit, `E=70[GPa]`, where the script has units. Where it has none, numbers are in whatever units its
author thought of.)",
     {},
     {}},
});

} // namespace

std::span<const CatalogueEntry> catalogue_names() { return names_entries; }

} // namespace hvi::lang
