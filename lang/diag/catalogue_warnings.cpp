// Catalogue of diagnostics, class W: warnings.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto warnings_entries = std::to_array<CatalogueEntry>({
    {"W0101", "never used",
     R"(
A declaration that nothing uses. It is checked all the same, but for the body of a function: what
stands there is checked where the function is called, with what it is given. Of what is used, an argument
of a function or a parameter of a superpotential that its body does not read.)",
     R"(
param spare = 1)",
     R"(
param n = 8
mesh m = interval(1, cells = n))"},
    {"W0102", "inequality without a superpotential",
     R"(
Without a superpotential the statement is an equation; `=` says so.)",
     R"(
integral(slab, B : eps(u) : eps(v)) >= 0)",
     R"(
integral(slab, B : eps(u) : eps(v)) = 0)"},
    {"W0103", "form that is not symmetric",
     R"(
The forms in u, or those in u', are not symmetric: a(w, v) differs from a(v, w). The theory wants
coercivity only, so the script runs, by LU in place of Cholesky, in about twice the time. Mostly a
matrix has lost its transpose.)",
     R"(
tensor B = voigt([[3, 1, 0], [0, 3, 0], [0, 0, 1]]))",
     R"(
tensor B = voigt([[3, 1, 0], [1, 3, 0], [0, 0, 1]]))"},
    {"W0104", "nearly incompressible material with P1",
     R"(
A material whose volume is much stiffer than its shape (poisson beyond 0.49) makes linear elements lock:
they cannot change shape without changing volume, and the answer is much too stiff on any affordable
mesh. P2 has enough freedom (it loses an order of convergence), and so have both elements on crossed
rectangles (they lose none). The number printed is (lambda + 2 mu / d) / (2 mu) of an isotropic tensor.)",
     R"(
tensor B = isotropic(young = 70, poisson = 0.4999)
space V  = vector P1 on slab, zero on roof)",
     R"(
tensor B = isotropic(young = 70, poisson = 0.4999)
space V  = vector P2 on slab, zero on roof)"},
    {"W0107", "case that is never reached",
     R"(
Cases are read from the top: the first condition that holds decides. No argument is left for this one,
because the ones before it hold wherever it does. Mostly two lines have changed places, or a parameter is
not what was meant.)",
     R"(
superpotential layer(r) with slope | r < 0.08 -> 100*r | r < 0.02 -> 50*r | otherwise -> 8)",
     R"(
superpotential layer(r) with slope | r < 0.02 -> 50*r | r < 0.08 -> 100*r - 1 | otherwise -> 7)"},
    {"W0108", "load without an integral",
     R"(
Within the time of the run the load is infinite, and grows so fast that it has no integral over time: what
the run gives depends on how near the grid's times come. With `load = average`, where the mean over a step
is asked for, the run ends (E0423). Or it has poles on its part beside which its integral with v is
infinite, as 1/(x - 1) has: what the run gives depends on how near the points of the mesh come.)",
     R"(
find u in V for t in [0, 1] by 5 steps from u = 0 such that ... = integral(body, 1/(t - 0.5)*v))",
     R"(
find u in V for t in [0, 1] by 5 steps from u = 0 such that ... = integral(body, 1/(t + 0.5)*v))"},
    {"W0109", "setting without effect",
     R"(
A setting of the find statement that changes nothing of what this script computes: `hht_alpha` beside another
scheme, `scheme`, `load`, `interpolant` and `memory` of a static problem, `load = average` where no load changes
in time, `interpolant` where nothing is asked for between two steps, `memory` and `memory_tolerance` without a
memory, `branch` without a law, `quadrature` where each law brings a rule. Not said where `scheme` is
a parameter, which may have another value.)",
     R"(
find u in V for t in [0, 1] by 8 steps from u = 0 using scheme = newmark, hht_alpha = -0.1)",
     R"(
find u in V for t in [0, 1] by 8 steps from u = 0 using scheme = hht, hht_alpha = -0.1)"},
    {"W0110", "expectation without a row",
     R"(
An expectation asks for the value of a column at a time at which no table has a row: `hvi-run test` finds
nothing to judge, and it fails. Rows are those of the steps, with `every 4 steps` of each fourth and the
last one. Not said where parameters have other values than the script gives them.)",
     R"(
find u in V for t in [0, 1] by 8 steps from u = 0 ... report table a = u.y at [1, 0] expect a at t = 0.3 = 0 within 1e-9)",
     R"(
find u in V for t in [0, 1] by 10 steps from u = 0 ... report table a = u.y at [1, 0] expect a at t = 0.3 = 0 within 1e-9)"},
    {"W0111", "stress of a law",
     R"(
`sigma` is the sum of what is contracted with `eps(v)` in the forms. A law inside the body, `integral(body, j^0(eps(u); eps(v)))`,
adds its multiplier to the stress, `j.xi`, which lives at the points of the law and is not in `sigma`, nor in `mises(sigma)`, pictures and
rates of states: the whole stress is `sigma + j.xi`. Said once, at the first `sigma`, where no result reads `j.xi`.)",
     R"(
... integral(body, B : eps(u) : eps(v) + paste^0(eps(u); eps(v))) ... report table s = sigma.xy at [1, 0])",
     R"(
... integral(body, B : eps(u) : eps(v) + paste^0(eps(u); eps(v))) ... report table s = sigma.xy + paste.xi.xy at [1, 0])"},
    {"W0601",
     "picture not drawn",
     R"(
What draws it is not there or refused: libcairo2 paints the PNG pictures of a run (SVG pictures need nothing), gnuplot draws those of
`study` and `stability`. Everything else is on the disk: pictures come last. A picture whose
file the script names (`to "slab.png"`) is a result that was asked for: without it the run ends with E0702.)",
     {},
     {}},
    {"W0602",
     "curved cells become straight",
     R"(
A mesh of second order gives each edge a node in its middle, so that cells can follow a curved boundary.
The cells of a space have straight edges here, P2 too: such nodes are dropped. The message has the largest
distance of one from the middle of its straight edge and the change of the body's area or volume; distances
of the size of rounding (1e-9 of the edge) do not count. On a curved boundary that costs P2 its third order.)",
     {},
     {}},
    {"W0603", "open seam",
     R"(
Nodes of the boundary stand at one place without a cell that joins them, or a node lies inside a side of a
cell without being its corner: the body comes apart there, as along a crack. Mostly two parts were meshed
separately and not merged. Places count as one when they are closer than 1e-8 of the body and a thousandth
of the edges there.)",
     R"(
Merge "left.msh"; Merge "right.msh"; Save "both.msh";)",
     R"(
Merge "left.msh"; Merge "right.msh"; Coherence Mesh; Save "both.msh";)"},
    {"W0604", "cells overlap",
     R"(
Cells share more than their common corners, edges and sides: the body is there twice, with twice its
stiffness and load. The depth is how far a cell would have to be moved to come free. Overlaps of less than
1e-6 of a cell or 1e-9 of the body are not seen.)",
     R"(
Rectangle(1) = {0, 0, 0, 1, 1}; Rectangle(2) = {0.9, 0, 0, 1, 1};)",
     R"(
Rectangle(1) = {0, 0, 0, 1, 1}; Rectangle(2) = {0.9, 0, 0, 1, 1};
BooleanUnion{ Surface{1}; Delete; }{ Surface{2}; Delete; })"},
    {"W0605", "body in pieces",
     R"(
The cells are not all connected by common sides. Each piece moves by itself: what holds it is said for
each. A piece that nothing holds has no equilibrium (E0425).)",
     R"(
Rectangle(1) = {0, 0, 0, 1, 1}; Rectangle(2) = {2, 0, 0, 1, 1};)",
     R"(
Rectangle(1) = {0, 0, 0, 3, 1};)"},
    {"W0607", "points without a partner",
     R"(
The sides of a pair are matched once, in the reference state: along the averaged normal of the first
side, with facets of the second one that face it and are no farther than `reach` (the size of the
first side when left out). Nodes of the first side around which there are none are free.)",
     R"(
part seam = pair(upper.bottom, lower.top, reach = 0.01))",
     R"(
part over = upper.bottom where x < 1
part seam = pair(over, lower.top))"},
    {"W0608", "condition that cuts cells",
     R"(
A part that a condition selects has whole cells, or whole sides: those that lie partly inside are left
out, and the part is smaller than the condition says. Said where that is more than a tenth of it.)",
     R"(
mesh bar = rectangle(1, 1, cells = [4, 4])
part top = bar.top where x < 0.6)",
     R"(
mesh bar = rectangle(1, 1, cells = [5, 4])
part top = bar.top where x < 0.6)"},
    {"W0609", "normals to both sides",
     R"(
On the boundary normals point out of the body. Facets inside it, which a group of a file names, have the
normal that the order of their nodes in the file gives: to the right of a line in the plane, by the right-hand
rule in space. Where two of them that meet point to different sides, a pressure, a law on `u.nu` or an
integral with the normal changes its sign from one to the other, and gradients and stresses are those of one
material on the one and of another on the other. A facet that two groups have, each the other way round, has the
normal that the first of them gives. Said of parts on which such things are counted.)",
     R"(
Physical Curve("seam") = {5, 6};)",
     R"(
Physical Curve("seam") = {5, -6};)"},
    {"W0610", "lines in space",
     R"(
A group of curves in a mesh of tetrahedra stands for its nodes: those at the ends of edges. An integral over
it is the sum of the values at them, so that a load of it grows as the mesh is refined, and of a P2 space the
values in the middle of the edges are free where the part is held. A line has no trace in the theory either:
its nodes serve to hold a body that would move freely.)",
     R"(
part edge = body.group("edge"))",
     R"(
part strip = body.top where x < 0.1)"},
    {"W0611", "boundary and a group of that name",
     R"(
`body.boundary` is all of the boundary. A file may have a group that is called so and is a part of it, or
cells: that one is `body.group("boundary")`.)",
     R"(
part rim = body.boundary)",
     R"(
part rim = body.group("boundary"))"},
    {"W0612", "table finer than the mesh",
     R"(
A table over space, `table("pressure.csv", x)`, is read at the points of an integral's rule, as any function is. Where it has
several points within one cell or side, what lies between those of the rule is not seen. Said where the mean of the table over
a cell differs by more than a hundredth of its largest value from the mean of three points, with the numbers of the worst cell.)",
     R"(
mesh bar = interval(1, cells = 10) ... integral(bar, table("thousand_points.csv", x)*v))",
     R"(
mesh bar = interval(1, cells = 1000) ... integral(bar, table("thousand_points.csv", x)*v))"},
    {"W0613", "value at a point of two sides",
     R"(
Where two bodies touch, and on the two sides of a crack, each side has nodes of its own, and a value at a point there is that of
one of them: of the piece that stands first in the sum of meshes. `on` and a piece of the mesh, or a part of its cells, says
which side is meant; on a pair `jump(u)` is the difference of both, `mean(u)` their mean.)",
     R"(
mesh both = upper + lower ... table tip = u.y at [0.5, 1])",
     R"(
table tip = u.y at [0.5, 1] on upper, below = u.y at [0.5, 1] on lower)"},
});

} // namespace

std::span<const CatalogueEntry> catalogue_warnings() { return warnings_entries; }

} // namespace hvi::lang
