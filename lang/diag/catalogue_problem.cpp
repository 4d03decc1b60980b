// Catalogue of diagnostics, class E04: structure of the problem and values.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto problem_entries = std::to_array<CatalogueEntry>({
    {"E0401", "not linear in v",
     R"(
The test function occurs exactly once in every term.)",
     R"(
integral(slab, dot(v, v)))",
     R"(
integral(slab, dot(u, v)))"},
    {"E0402", "no test function",
     R"(
Every summand of an integral of the inequality contains the test function.)",
     R"(
integral(slab, dot(f, v) + 1))",
     R"(
integral(slab, dot(f, v)))"},
    {"E0403", "not linear in u",
     R"(
The forms of the inequality are bilinear. Nonlinear laws are superpotentials.)",
     R"(
integral(slab, dot(u, u) * v.x))",
     R"(
integral(slab, dot(u, v)))"},
    {"E0404", "no find statement",
     R"(
A script states one inequality with `find u in V ... such that ...`; without it there is nothing to solve.)",
     R"(
mesh slab = rectangle(1, 1, cells = [2, 2]))",
     R"(
find u in V such that for all v in V ...)"},
    {"E0405", "two find statements",
     R"(
A script states one inequality; imported files state none, and ask for nothing: `report`, `expect` and
`study` stand in the script.)",
     R"(
find u in V ...
find w in V ...)",
     R"(
find u in V ...)"},
    {"E0406", "not a positive whole number",
     R"(
Numbers of cells and steps are positive whole numbers.)",
     R"(
mesh slab = rectangle(1, 1, cells = [2.5, 2]))",
     R"(
mesh slab = rectangle(1, 1, cells = [2, 2]))"},
    {"E0407", "not a finite number",
     R"(
A constant divides by zero, overflows or is not a number.)",
     R"(
param a = 1/0)",
     R"(
param a = 1/2)"},
    {"E0408", "outside its range",
     R"(
A parameter, length, tolerance or exponent outside what it may be.)",
     R"(
param n = 0 in [1, 100])",
     R"(
param n = 8 in [1, 100])"},
    {"E0409", "negative factor before j^0",
     R"(
j^0 is the generalised directional derivative: its negative is not the directional derivative of
-j in the same direction. Put the sign into the superpotential.)",
     R"(
- integral(ground, layer^0(u.nu; v.nu)))",
     R"(
+ integral(ground, layer^0(u.nu; v.nu)))"},
    {"E0410", "superpotential on the right",
     R"(
Superpotentials stand on the left of >=.)",
     R"(
>= integral(ground, layer^0(u.nu; v.nu)))",
     R"(
+ integral(ground, layer^0(u.nu; v.nu)) >= 0)"},
    {"E0411", "equation with a superpotential",
     R"(
With a superpotential the statement is an inequality.)",
     R"(
integral(ground, layer^0(u.nu; v.nu)) = 0)",
     R"(
integral(ground, layer^0(u.nu; v.nu)) >= 0)"},
    {"E0412", "clause missing",
     R"(
u', memory, t and times need `for t in [t0, T] by N steps`, and a problem with u' its initial
state `from u = ...`.)",
     R"(
find u in V for t in [0, 1] by 8 steps such that ... u' ...)",
     R"(
find u in V for t in [0, 1] by 8 steps from u = 0 such that ... u' ...)"},
    {"E0413", "form depends on time",
     R"(
A form on cells may change in time: its coefficients are taken at the time of each step. Its integral
holds the unknown in every term, and an inertia does not change. On a boundary a superpotential may
depend on t, and so may loads and kernels q(t, s).)",
     R"(
integral(ground, (1 + t) * dot(u, v)))",
     R"(
superpotential bed(xi) = 0.5 * (1 + t) * norm(xi)^2
... integral(ground, bed^0(u; v)))"},
    {"E0414", "argument and direction differ",
     R"(
j^0(Mu; Mv) takes the same operator M twice: the trace, its normal or tangential part, a
component, or the value itself; inside a body also its gradient, a strain, `div(u)`, all of `eps(u)`, or
a vector of up to nine of these. A law of a gradient has its points inside the cells, so that
`rule = nodal` has none.)",
     R"(
layer^0(u.nu; v.x))",
     R"(
layer^0(u.nu; v.nu))"},
    {"E0415", "law through two operators",
     R"(
A law sees u, as a layer that is pressed, or u', as friction that dissipates, or a memory,
`history(q, u).nu`, or a sum of them, times constants, through one M: that of the direction. An argument
with several components may see another sum in each. Laws do not act on u''.)",
     R"(
layer^0(u.nu + 0.1*u'.x; v.nu))",
     R"(
layer^0(u.nu + 0.1*u'.nu; v.nu))"},
    {"E0416", "value imposed where the space is not zero",
     R"(
Values are imposed on parts where the space is zero, or on parts inside of these, and only once for
each component. Inside a larger part the value takes the place of its zeros.)",
     R"(
space V = vector P1 on slab
find u in V with u.y = 1 on roof)",
     R"(
space V = vector P1 on slab, zero.y on roof
find u in V with u.y = 1 on roof)"},
    {"E0418", "empty part",
     R"(
The part exists by its name, but no cell, facet or node is in it.)",
     R"(
part p = slab.boundary where x > 99)",
     R"(
part p = slab.boundary where x > 1.99)"},
    {"E0419", "overlapping parts",
     R"(
A superpotential acts on a face that is clamped, a law twice on a face, or two values are imposed
on one node. A shared node of a clamped and a contact part is normal; a shared face is not.)",
     R"(
space V = vector P1 on slab, zero on ground
... integral(ground, layer^0(u.nu; v.nu)))",
     R"(
space V = vector P1 on slab, zero on roof
... integral(ground, layer^0(u.nu; v.nu)))"},
    {"E0420", "law twice on a part",
     R"(
One superpotential acts once on a part; a factor before the integral doubles it.)",
     R"(
integral(ground, layer^0(u.nu; v.nu)) + integral(ground, layer^0(u.nu; v.nu)))",
     R"(
2*integral(ground, layer^0(u.nu; v.nu)))"},
    {"E0421", "second derivative",
     R"(
P1 and P2 functions have one weak derivative.)",
     R"(
integral(slab, div(grad(w)) * v))",
     R"(
integral(slab, dot(grad(w), grad(v))))"},
    {"E0422", "time outside the interval",
     R"(
A result is asked for at a time that is not computed.)",
     R"(
table a = u.y at [0, 0] at t = 2)",
     R"(
table a = u.y at [0, 0] at t = 1)"},
    {"E0423", "bad value",
     R"(
Data that is not finite somewhere, a point outside the mesh, an initial state that contradicts the
imposed values, or an unknown that is read where it does not live: a space on a piece of a mesh or on a
part of its cells (`space W = scalar P1 on pad`) has functions there only, so forms, loads, laws, states,
integrals and points that see the unknown stay inside.)",
     R"(
table a = u.y at [9, 9])",
     R"(
table a = u.y at [1, 1])"},
    {"E0425", "not coercive",
     R"(
What the script states does not determine the unknown: a rigid motion of the body or of a piece of it is
left, or the sum of the forms is not positive definite. Laws may hold a body, as a table does: then they have
to see each of its motions, and to balance the load at every time. Or the memory of a step within that step subtracts
more stiffness than the body has: shorter steps make it smaller.)",
     R"(
space V = vector P1 on slab)",
     R"(
space V = vector P1 on slab, zero on roof)"},
    {"E0426", "wrong times",
     R"(
The interval is [t0, T] with t0 < T, and listed times increase within it.)",
     R"(
for t in [1, 0] by 8 steps)",
     R"(
for t in [0, 1] by 8 steps)"},
    {"E0427", "second mesh",
     R"(
A problem lives on one mesh. Regions of it that differ are parts: physical groups of a mesh file, or
a condition in space.)",
     R"(
mesh slab = rectangle(2, 1, cells = [32, 16])
mesh base = rectangle(2, 1, cells = [16, 8]))",
     R"(
mesh slab = rectangle(2, 2, cells = [32, 32])
part base = slab where y < 1)"},
    {"E0428", "rate of a state out of reach",
     R"(
The rate of a state is asked at the points of the laws on its part: it may depend on states of that
part, on x and t, on values of the unknown and of its rate there (`u.nu`, `u.tau`, `u'.tau`) and on
multipliers of laws on that part (`layer.xi`). Gradients and memories are known inside a body only,
where multipliers are not; integrals nowhere.)",
     R"(
state wear on ground with rate 0.1*sigma.yy from wear = 0)",
     R"(
state wear on ground with rate 0.1*abs(layer.xi)*norm(u'.tau) from wear = 0)"},
    {"E0429", "state of another part",
     R"(
A state lives at the points of its part, and nowhere else: superpotentials and forms that read it, rates
and integrals are on the same part. Reports read the states of a body, those that no law has at its
points, on boundaries and pieces of the body, too: on a boundary that of the cell behind it.)",
     R"(
state beta on glue with rate -beta from beta = 1
superpotential bond(r) = 0.5*beta^2*r^2
... integral(ground, bond^0(u.nu; v.nu)))",
     R"(
state beta on glue with rate -beta from beta = 1
superpotential bond(r) = 0.5*beta^2*r^2
... integral(glue, bond^0(u.nu; v.nu)))"},
    {"E0430", "state without a place",
     R"(
A state on a boundary lives at the points of a law there. A state of cells lives inside them (damage,
ageing) and may stand in coefficients of forms there; where a law acts on the same cells it lives at the
law's points, and no form knows it.)",
     R"(
state beta on glue with rate -beta from beta = 1
... integral(ground, layer^0(u.nu; v.nu)))",
     R"(
state beta on glue with rate -beta from beta = 1
... integral(glue, layer^0(u.nu; v.nu)))"},
    {"E0431", "inertia missing",
     R"(
Initial velocities, the schemes `newmark`, `hht` and `midpoint`, and u'' in a report are for problems
with a term in u'', the inertia.)",
     R"(
find u in V for t in [0, 1] by 8 steps from u = 0, u' = [0, -1] such that for all v in V
  integral(body, B : eps(u) : eps(v)) >= 0)",
     R"(
find u in V for t in [0, 1] by 8 steps from u = 0, u' = [0, -1] such that for all v in V
  integral(body, rho*dot(u'', v)) + integral(body, B : eps(u) : eps(v)) >= 0)"},
    {"E0432", "what a law cannot read",
     R"(
A bound or coefficient of a law may depend on the solution at the law's point: on unknowns, their
rates and memories, by components, by the normal and the tangential part, not on derivatives. A law
reads up to four such quantities; what depends on the solution alone is one of them, however long
its expression. The multiplier that it reads of another law is that of a law of a scalar. The same
holds for a source, a load that reads a multiplier or a state of a boundary.)",
     R"(
superpotential rub(w) = (1 + abs(div(history(q, u)))) * norm(w))",
     R"(
superpotential rub(w) = (1 + abs(history(q, u).nu)) * norm(w))"},
    {"E0440", "pieces of a mesh",
     R"(
Meshes that are put together share no node, and are all of the mesh that the space lives on. A side
that several of them have is called by its piece. Each is made by a call, once; `adapted` is for a
mesh alone.)",
     R"(
mesh upper = rectangle(1, 1, cells = [8, 8], at = [0.5, 1])
mesh lower = rectangle(2, 1, cells = [12, 6])
mesh both  = upper + lower
part base  = both.bottom)",
     R"(
mesh upper = rectangle(1, 1, cells = [8, 8], at = [0.5, 1])
mesh lower = rectangle(2, 1, cells = [12, 6])
mesh both  = upper + lower
part base  = lower.bottom)"},
    {"E0441", "pair",
     R"(
A pair is of two parts of the boundary, the first of which carries the integral and the normal. Laws
act on it, on jumps: `jump(u)` is the value on the first side minus that on the second, `gap(seam)`
their distance. Superpotentials, sources and states also read `mean(u)`, the mean of both sides. None
of them is known anywhere else, and on a pair nothing else of the unknown is.)",
     R"(
part seam = pair(upper.bottom, lower.top)
... integral(seam, glue^0(u.nu; v.nu)))",
     R"(
part seam = pair(upper.bottom, lower.top)
... integral(seam, glue^0(jump(u).nu; jump(v).nu)))"},
    {"E0442", "no body of revolution",
     R"(
`axisymmetric = true` makes a mesh in 2D the half of a section of a body of revolution: x is the
distance from the axis, at least 0, y runs along the axis. Its fields have no part along the circles:
a tensor or a matrix that turns what lies in the section out of it has no place there.)",
     R"(
mesh tube = rectangle(1, 2, cells = [4, 8], origin = [-1, 0], axisymmetric = true))",
     R"(
mesh tube = rectangle(1, 2, cells = [4, 8], origin = [1, 0], axisymmetric = true))"},
    {"E0443", "unknowns and test functions",
     R"(
Each unknown has a test function of its own, in the same order and the same space, and brings one
equation: that of the terms with its test function. There are four unknowns at most.)",
     R"(
find u in V, p in Q such that for all v in V
  integral(body, 2*mu*(eps(u) : eps(v)) - p*div(v)) = integral(body, dot(f(), v)))",
     R"(
find u in V, p in Q such that for all v in V, q in Q
  integral(body, 2*mu*(eps(u) : eps(v)) - p*div(v) + q*div(u)) = integral(body, dot(f(), v)))"},
    {"E0444", "a law of two unknowns",
     R"(
A law sees one unknown, and stands in the equation of that unknown: j^0(Mu; Mv) takes the same M of
an unknown and of its own test function.)",
     R"(
... integral(ground, layer^0(u.nu + p; v.nu)))",
     R"(
... integral(ground, layer^0(u.nu; v.nu)) + integral(ground, p*v.nu))"},
    {"E0446", "a pair of elements that is not stable",
     R"(
An unknown without a form of its own, such as the pressure of an incompressible body or flow, is known
through the couplings alone. Where it sees the divergence of an unknown of the same order, some of its
functions are seen by none of that unknown: the inf-sup condition fails, and the matrix is singular or
worse with every refinement. P2 with P1 is stable.)",
     R"(
space V = vector P1 on body, zero on walls
space Q = scalar P1 on body
find u in V, p in Q such that for all v in V, q in Q
  integral(body, 2*mu*(eps(u) : eps(v)) - p*div(v) + q*div(u)) = integral(body, dot(f(), v)))",
     R"(
space V = vector P2 on body, zero on walls
space Q = scalar P1 on body
find u in V, p in Q such that for all v in V, q in Q
  integral(body, 2*mu*(eps(u) : eps(v)) - p*div(v) + q*div(u)) = integral(body, dot(f(), v)))"},
    {"E0447", "a source that reads a multiplier or a state",
     R"(
A linear form on the part of a law may read the law's multiplier and, as it likes, the solution
there: the heat that friction makes is `dot(slip.xi, u'.tau) * eta`, on a pair, where half of it goes
to either side, `dot(slip.xi, jump(u').tau) * mean(eta)`. So may it read a state that lives at the law's
points, `leak(wear) * eta`. It is found with each step. It stands in an integral of its own, before
values of a test function.)",
     R"(
find u in V, theta in W for t in [0, 1] by 8 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(body, A : eps(u') : eps(v)) + integral(body, dot(grad(theta), grad(eta)))
  + integral(ground, slip^0(u'.tau; v.tau))
  - integral(ground, dot(slip.xi, grad(eta))) >= 0)",
     R"(
find u in V, theta in W for t in [0, 1] by 8 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(body, A : eps(u') : eps(v)) + integral(body, dot(grad(theta), grad(eta)))
  + integral(ground, slip^0(u'.tau; v.tau))
  - integral(ground, dot(slip.xi, u'.tau) * eta) >= 0)"},
    {"E0448", "a stress across the plane is not known",
     R"(
The equivalent stress of von Mises needs all stresses in space. In plane strain the stress `zz` across the
plane is known where the stress is made of `isotropic`, `orthotropic` and `transverse` tensors on `eps(u)`, of
memories of these, and of terms such as `p*div(v)`, with the shears `xz` and `yz` that strains in the plane make of
a material none of whose axes stands across it; a `voigt` matrix of the plane does not tell them. In 1D nothing tells what holds the bar sideways.)",
     R"(
tensor A = voigt([[3, 1, 0], [1, 3, 0], [0, 0, 1]])
report table worst = largest(body, mises(sigma)))",
     R"(
tensor A = isotropic(lambda = 1, mu = 1)
report table worst = largest(body, mises(sigma)))"},
    {"E0449", "a static start",
     R"(
`from u = static` begins with the solution of the static problem at the initial time: what stands
against rates and memories is zero there, and states have their initial values. All unknowns start so,
or none. A law on rates that exerts a force where nothing moves has none that a static problem knows.)",
     R"(
find u in V, theta in W for t in [0, 1] by 8 steps from u = static, theta = 20)",
     R"(
find u in V, theta in W for t in [0, 1] by 8 steps from u = static, theta = static)"},
    {"E0450", "graphs of laws and kernels",
     R"(
`picture layer, slip, C` shows laws and kernels of the inequality as graphs, one beside the other, jumps
as vertical lines. They have no deformation and no time. Fields of the body stand beside each other in
another picture: `picture sigma.xx, u.y`, or one at several times: `picture u.y at t = [0.2, 0.5, 1]`.)",
     R"(
report picture layer deformed = 10)",
     R"(
report picture layer)"},
    {"E0451", "a load that reads the solution",
     R"(
A load stands on the right. Where it is not linear in the solution, as the heat of viscous flow or a
reaction, it is found with each step, at Gauss's points of its part: it may read unknowns, their
rates and memories, the gradients of all of them, `sigma`, and states inside the body, but no u'', and
no multipliers. Linear terms are forms: on the left.)",
     R"(
find u in V, theta in W for t in [0, 1] by 8 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(body, A : eps(u') : eps(v)) + integral(body, dot(grad(theta), grad(eta)))
  = integral(body, (A : eps(u') : eps(u')) * eta, rule = nodal))",
     R"(
find u in V, theta in W for t in [0, 1] by 8 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(body, A : eps(u') : eps(v)) + integral(body, dot(grad(theta), grad(eta)))
  = integral(body, (A : eps(u') : eps(u')) * eta))"},
});

} // namespace

std::span<const CatalogueEntry> catalogue_problem() { return problem_entries; }

} // namespace hvi::lang
