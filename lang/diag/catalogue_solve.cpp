// Catalogue of diagnostics, class E07: solving, E09: internal.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto solve_entries = std::to_array<CatalogueEntry>({
    {"E0701", "step without certificate",
     R"(
No solution of this step could be certified to the tolerance. Nothing after the last good step is
reported. A smaller step, or a law that softens less, makes the problem of the step convex.)",
     R"(
using tolerance = 1e-30)",
     R"(
using tolerance = 1e-10)"},
    {"E0702",
     "result not written",
     R"(
The output folder cannot be written: no permission, a full disk, or a file in the way.)",
     {},
     {}},
    {"E0703", "interrupted",
     R"(
The run was asked to stop. The last good state is on disk.)",
     R"(
(Ctrl-C))",
     R"(
(let it run))"},
    {"E0704",
     "checkpoint not usable",
     R"(
The checkpoint is damaged, was written by another version, or belongs to another problem: script,
parameters, mesh and options must be those it was written with; only the end time may be later, with
the same steps so far. Nothing was computed from it.)",
     {},
     {}},
    {"E0705",
     "accuracy out of reach",
     R"(
No setting within the limits (unknowns, steps, CPU seconds) promises the wanted accuracy, the runs that
were made never showed it, or the column asked for has no value in any row. The table of evidence stands
above the message. Ask for less, allow more seconds, or look at what limits the order: a corner, a load
with a kink between mesh lines.)",
     {},
     {}},
    {"E0706", "result is mostly rounding",
     R"(
Every step was solved, but numbers of 16 digits do not determine the answer: the data, the matrix or the
steps differ from the exact ones by a unit in the last place, and that changes the solution or a printed
column by more than a hundredth of its size, or the matrix is singular to double precision though the
script is right. Such a run is not certified; refinement with residuals in extended precision was tried and
did not help. Bodies a thousand times longer than thick, Poisson's ratios within 1e-7 of 1/2 and stiffnesses
many decades apart cause this; a mesh of better shaped cells or a softer contrast helps. Where a large
`tolerance` lets steps leave more of their equations than rounding does, the message says that instead.)",
     R"(
mesh beam = rectangle(100000, 1, cells = [8, 1]))",
     R"(
mesh beam = rectangle(100, 1, cells = [200, 2]))"},
    {"E0901", "internal error",
     R"(
A mistake of this program, not of the script. Please report it with the script.)",
     R"(
-)",
     R"(
-)"},
});

} // namespace

std::span<const CatalogueEntry> catalogue_solve() { return solve_entries; }

} // namespace hvi::lang
