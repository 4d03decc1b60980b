// Catalogue of diagnostics, class E02: syntax.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto syntax_entries = std::to_array<CatalogueEntry>({
    {"E0201", "something else was expected",
     R"(
The statement goes on in a way the grammar does not know. The message says what could stand there and
what was found. The statement is skipped; reading goes on at the next statement word.)",
     R"(
param n 4)",
     R"(
param n = 4)"},
    {"E0202", "not a statement",
     R"(
Every statement begins with one of the words import, units, param, mesh, part, tensor, kernel,
superpotential, state, fn, space, find, report, expect, study. What stands here is none of them, and does not
continue the statement before.)",
     R"(
tensr A = isotropic(lambda = 5, mu = 10))",
     R"(
tensor A = isotropic(lambda = 5, mu = 10))"},
    {"E0203", "reserved word used as a name",
     R"(
The words that begin statements (`state` only before a name and `on`), and `and`, `or`, `not`, `otherwise`, cannot be names.
They may follow a dot, as in `model.part`.)",
     R"(
param mesh = 4)",
     R"(
param cells = 4)"},
    {"E0204", "bracket not closed",
     R"(
A `(`, `[` or `^0(` has no partner: the line, the statement or the file ends, or the next term of the
inequality begins, before it is closed. The second mark shows where it was opened.)",
     R"(
tensor B = isotropic(young = 70, poisson = 0.3)",
     R"(
tensor B = isotropic(young = 70, poisson = 0.3))"},
    {"E0205", "wrong closing bracket",
     R"(
A closing bracket has no partner, or closes a bracket of the other kind.)",
     R"(
fn f(x) = exp(-x)))",
     R"(
fn f(x) = exp(-x))"},
    {"E0206", "`=` in a condition",
     R"(
In conditions equality is written `==`. A single `=` gives something its value.)",
     R"(
part roof = slab.boundary where y = 1)",
     R"(
part roof = slab.boundary where y == 1)"},
    {"E0207", "chained comparison",
     R"(
A comparison has two sides. A range is written as two comparisons joined by `and`.)",
     R"(
part strip = slab.boundary where 0 < x < 1)",
     R"(
part strip = slab.boundary where 0 < x and x < 1)"},
    {"E0208", "cases without `otherwise`",
     R"(
Cases are tried in order, and the last one, `otherwise`, says what holds where no condition does. So
a law or a function has a value everywhere, by construction.)",
     R"(
fn f(x) =
  | x < 0 -> 0
  | x < 1 -> x)",
     R"(
fn f(x) =
  | x < 0     -> 0
  | otherwise -> x)"},
    {"E0209", "condition and value not joined by `->`",
     R"(
Each case is written `| condition -> value`.)",
     R"(
fn f(x) =
  | x < 0 : 0
  | otherwise -> x)",
     R"(
fn f(x) =
  | x < 0     -> 0
  | otherwise -> x)"},
    {"E0210", "comment of another language",
     R"(
Comments begin with `#` and reach to the end of the line. `//` and `/* */` are not comments.)",
     R"(
param n = 4  // cells)",
     R"(
param n = 4  # cells)"},
    {"E0211", "`**` for a power",
     R"(
A power is written `^`; it binds tighter than a sign and is right associative: -a^b^c is -(a^(b^c)).)",
     R"(
fn f(x) = x**2)",
     R"(
fn f(x) = x^2)"},
    {"E0212", "operator of another language",
     R"(
`or` is a word; comparisons are written `<`, `<=`, `>`, `>=`, `==` and `!=`.)",
     R"(
part ends = slab.boundary where x < 0.1 || x > 1.9)",
     R"(
part ends = slab.boundary where x < 0.1 or x > 1.9)"},
    {"E0213", "wrong sign between the two sides",
     R"(
A hemivariational inequality has `>=` between its sides, an equation has `=`. An inequality the other
way round is the same statement after a change of all signs.)",
     R"(
find u in V such that for all v in V
    integral(slab, B : eps(u) : eps(v))
 <= integral(slab, dot(f, v)))",
     R"(
find u in V such that for all v in V
    integral(slab, B : eps(u) : eps(v))
 >= integral(slab, dot(f, v)))"},
    {"E0214", "`^0` forgotten",
     R"(
A law enters the inequality through its generalised directional derivative, written `j^0(u; v)`: j at
the point u in the direction v. A call such as `f(a, b)` has commas between its arguments.)",
     R"(
find u in V such that for all v in V
    integral(ground, layer(u.nu; v.nu))
 >= 0)",
     R"(
find u in V such that for all v in V
    integral(ground, layer^0(u.nu; v.nu))
 >= 0)"},
    {"E0215", "`such that` missing",
     R"(
The statement reads `find u in V ... such that for all v in V` and then the inequality.)",
     R"(
find u in V for all v in V
    integral(slab, B : eps(u) : eps(v))
  = 0)",
     R"(
find u in V such that for all v in V
    integral(slab, B : eps(u) : eps(v))
  = 0)"},
    {"E0216", "nested too deeply",
     R"(
Brackets stand within each other more than 400 times, or more than 1200 operations build on each
other in one formula. Name parts of it with `fn` or `tensor`. Names and functions that lead from one
to the next may be 2000 levels deep: a name is one and each operation of its value is another, so that
a chain of names alone, each the value of the one before, has 1000; functions call one another 100 levels deep at
most, a part is put together of 1200 places, a superpotential of 256 cases.)",
     R"(
fn f(x) = ((( ... 1000 brackets ... ))))",
     R"(
fn g(x) = exp(-x)
fn f(x) = g(g(x)))"},
    {"E0217", "semicolon",
     R"(
Statements need no sign at their end. `;` stands only between the point and the direction of
`j^0(u; v)`.)",
     R"(
param n = 4;)",
     R"(
param n = 4)"},
    {"E0218", "number with a comma",
     R"(
Numbers have a decimal point, and no separators between groups of digits: `0.5`, `1000`. A comma
separates arguments and list items.)",
     R"(
param load = 0,5)",
     R"(
param load = 0.5)"},
    {"E0219", "clause of `find` twice or out of order",
     R"(
The clauses of `find` come in this order, each at most once: `with` (imposed values), `for t` (time),
`using` (settings), `such that`.)",
     R"(
find u in V using scheme = backward_euler for t in [0, 1] by 8 steps
such that for all v in V
    integral(slab, B : eps(u) : eps(v)) = 0)",
     R"(
find u in V for t in [0, 1] by 8 steps using scheme = backward_euler
such that for all v in V
    integral(slab, B : eps(u) : eps(v)) = 0)"},
    {"E0220", "call of something that is not a name",
     R"(
Only names are called. Two factors next to each other are not a product; write `*`.)",
     R"(
fn f(x) = (x + 1)(x - 1))",
     R"(
fn f(x) = (x + 1)*(x - 1))"},
    {"E0221", "comparison used as a value",
     R"(
A comparison is a condition, not a number. Conditions stand in cases, behind `where` and behind
`when`. A named argument is written with a single `=`.)",
     R"(
fn step(x) = x > 0)",
     R"(
fn step(x) =
  | x > 0     -> 1
  | otherwise -> 0)"},
    {"E0222", "factor not before its integral",
     R"(
A constant factor stands before the integral, followed by `*`; a quotient needs parentheses there.)",
     R"(
find u in V such that for all v in V
    integral(slab, B : eps(u) : eps(v)) / 2
  = 0)",
     R"(
find u in V such that for all v in V
    (1/2) * integral(slab, B : eps(u) : eps(v))
  = 0)"},
    {"E0223", "term that is not an integral",
     R"(
Both sides of the inequality are sums of integrals over parts; 0 stands for an empty side.)",
     R"(
find u in V such that for all v in V
    B : eps(u) : eps(v)
  = 0)",
     R"(
find u in V such that for all v in V
    integral(slab, B : eps(u) : eps(v))
  = 0)"},
    {"E0224", "operator missing",
     R"(
Two values stand next to each other without an operator. A product is written with `*`.)",
     R"(
param m = 2 n)",
     R"(
param m = 2*n)"},
    {"E0225", "text in single quotes",
     R"(
The sign `'` is the time derivative and follows a name: `u'`. Texts stand between double quotes.)",
     R"(
import 'laws.hvi')",
     R"(
import "laws.hvi")"},
    {"E0226", "cases at a wrong place",
     R"(
`|` begins the cases of a definition. Within a formula cases stand in parentheses. The absolute value
is `abs(x)`, the length of a vector `norm(x)`.)",
     R"(
fn f(x) = 2*|x|)",
     R"(
fn f(x) = 2*abs(x))"},
    {"E0227", "kernel with more than two arguments",
     R"(
A kernel has one argument, the lag t - s, or the two arguments t and s.)",
     R"(
kernel C(t, s, r) = exp(-(t - s)))",
     R"(
kernel C(t, s) = exp(-(t - s)))"},
    {"E0228", "point and direction of a derivative not separated by `;`",
     R"(
The generalised directional derivative of a law j at the point u in the direction v is written
`j^0(u; v)`, as in the literature.)",
     R"(
find u in V such that for all v in V
    integral(ground, layer^0(u.nu, v.nu))
 >= 0)",
     R"(
find u in V such that for all v in V
    integral(ground, layer^0(u.nu; v.nu))
 >= 0)"},
    {"E0229", "`otherwise` not the last of several cases",
     R"(
`otherwise` takes everything no case before it took, so it stands last and not alone.)",
     R"(
fn f(x) =
  | x < 0     -> 0
  | otherwise -> x
  | x > 1     -> 1)",
     R"(
fn f(x) =
  | x < 0     -> 0
  | x > 1     -> 1
  | otherwise -> x)"},
    {"E0230", "a unit that is not written as one",
     R"(
Between the brackets behind a number stand names of units, joined by `*` and `/`, with powers: `[kg/m^3]`, `[N*m]`, `[1/s]`,
`[MPa*m^(1/2)]`.)",
     R"(
param K = 3 [N m])",
     R"(
param K = 3 [N*m])"},
});

} // namespace

std::span<const CatalogueEntry> catalogue_syntax() { return syntax_entries; }

} // namespace hvi::lang
