// See example_calls.hpp.
#include "lang/cli/example_calls.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto calls = std::to_array<ExampleCall>({
    {"E0320", R"(hvi-run slab.hvi -D m=8)", R"(hvi-run slab.hvi -D n=8)"},
    {"E0321", R"(hvi-run slab.hvi -D n=eight)", R"(hvi-run slab.hvi -D n=8)"},
    {"E0334", R"(hvi-run slab.hvi -D n=8[mm])", R"(hvi-run slab.hvi -D n=8)"},
    {"E0608", R"(hvi-run slab.hvi -o results & hvi-run slab.hvi -o results)",
     R"(hvi-run slab.hvi -o first & hvi-run slab.hvi -o second)"},
    {"E0609", R"(hvi-run slab.hvi --json load.csv)", R"(hvi-run slab.hvi --json slab.json)"},
    {"E0610", R"(chmod a-w slab.hvi; hvi-run fmt slab.hvi)",
     R"(chmod u+w slab.hvi; hvi-run fmt slab.hvi)"},
    {"E0611", R"(ulimit -u 1; hvi-run mesh part.geo --allow-geo)",
     R"(hvi-run mesh part.geo --allow-geo)"},
    {"E0702", R"(hvi-run slab.hvi -o /proc)", R"(hvi-run slab.hvi -o results)"},
    {"E0704", R"(hvi-run slab.hvi -D n=64 --resume)", R"(hvi-run slab.hvi -D n=32 --resume)"},
    {"E0705", R"(hvi-run slab.hvi --accuracy 1e-9)", R"(hvi-run slab.hvi --accuracy 1e-2)"},
    {"W0601", R"(PATH= hvi-run stability slab.hvi)",
     R"(sudo apt-get install libcairo2 gnuplot-nox)"},
    {"W0602", R"(gmsh -2 -order 2 disk.geo; hvi-run disk.hvi)",
     R"(gmsh -2 -clscale 0.5 disk.geo; hvi-run disk.hvi)"},
});

} // namespace

std::span<const ExampleCall> example_calls() { return calls; }

} // namespace hvi::lang
