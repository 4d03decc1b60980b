// Catalogue of diagnostics, class E06: meshes and files.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto files_entries = std::to_array<CatalogueEntry>({
    {"E0601", "file not found",
     R"(
The script, an import, a mesh or a table is not there or cannot be read.)",
     R"(
mesh m = gmsh("prat.msh"))",
     R"(
mesh m = gmsh("part.msh"))"},
    {"E0602", "unknown group",
     R"(
The mesh has no group of this name. The help line lists the groups there are.)",
     R"(
part roof = m.group("rof"))",
     R"(
part roof = m.group("roof"))"},
    {"E0603", "broken mesh",
     R"(
The file is not a mesh in MSH 2.2 or 4.1 format, or its cells are inverted, degenerate or
disconnected.)",
     R"(
mesh m = gmsh("notes.txt"))",
     R"(
mesh m = gmsh("part.msh"))"},
    {"E0604", "forbidden path",
     R"(
A script reads files beside it or below it, and writes into the output folder only. What is written
is as its name ends: pictures are `.png`, `.svg`, or `.apng` where they move, tables and lines `.csv`, fields
`.vtu` (or `.pvd`, which holds all times).)",
     R"(
import "../other/laws.hvi")",
     R"(
import "laws.hvi")"},
    {"E0605", "broken table",
     R"(
A table is a text of two columns of numbers, the first increasing.)",
     R"(
fn f() = table("notes.txt", 1))",
     R"(
fn f() = table("load.csv", 1))"},
    {"E0606", "geo file",
     R"(
gmsh runs what a .geo file says, programs too. It is read only where that was allowed.)",
     R"(
mesh m = gmsh("part.geo"))",
     R"(
mesh m = gmsh("part.msh"))"},
    {"E0607", "limit met",
     R"(
A mesh, a number of steps or a file beyond the limits of the program; or a run that needs more memory than
there is (exit code 3). What matrices, factor and memories will take is compared with the limits of the
process (ulimit -v, -d), of its control group and of the machine before it is taken; `plan` says it as well.
A process cannot see that others will want the same memory.)",
     R"(
mesh m = box(1, 1, 1, cells = [999, 999, 999]))",
     R"(
mesh m = box(1, 1, 1, cells = [99, 99, 99]))"},
    {"E0608",
     "folder in use",
     R"(
Another run writes into the output folder: it is named with its process, host and start. Two runs in one
folder would mix their results. The lock ends with the run that holds it, also when that is killed.)",
     {},
     {}},
    {"E0609",
     "result in the place of an input",
     R"(
A file that would be written is one that the script reads: the script itself, an import, a table or a
mesh; or another result would be written to it, as where the JSON is given the name of a table. Nothing was
computed and nothing written.)",
     {},
     {}},
    {"E0610",
     "script not formatted",
     R"(
The formatted script cannot be written: no permission, or a full disk. The file is unchanged.)",
     {},
     {}},
    {"E0611",
     "refused by the system",
     R"(
The system would not do something a run needs: read a file that is there, start a program or a thread.
The reason is the system's own; the script need not be wrong.)",
     {},
     {}},
});

} // namespace

std::span<const CatalogueEntry> catalogue_files() { return files_entries; }

} // namespace hvi::lang
