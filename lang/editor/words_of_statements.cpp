// The table of words; see words_of_statements.hpp.
#include "lang/editor/words_of_statements.hpp"

#include <algorithm>
#include <array>

namespace hvi::lang {

namespace {

struct KnownWord {
  std::string_view word, meaning, pattern;
};

constexpr std::array table = {
    KnownWord{"import",
              "`import friction`: declarations of the standard library, or of a file beside "
              "the script",
              "import ${1:friction}"},
    KnownWord{"param",
              "`param n = 32 in [4, 512] \"cells\"`: a number or word that whoever runs the "
              "script may set",
              "param ${1:n} = ${2:32} \"${3:what it is}\""},
    KnownWord{"mesh",
              "`mesh body = rectangle(2, 1, cells = [32, 16])`, `box(...)`, "
              "`gmsh(\"file.msh\")`, or meshes side by side: `upper + lower`",
              "mesh ${1:body} = rectangle(${2:2}, ${3:1}, cells = [${4:32}, ${5:16}])"},
    KnownWord{"part",
              "`part roof = body.top`: a side, a group, or what a condition selects: "
              "`body.boundary where y > 0.99`",
              "part ${1:roof} = ${2:body}.${3:top}"},
    KnownWord{"tensor", "`tensor B = isotropic(young = 70, poisson = 0.3)`",
              "tensor ${1:B} = isotropic(young = ${2:70}, poisson = ${3:0.3})"},
    KnownWord{"kernel",
              "`kernel C(lag) = -exp(-lag/0.5) * B`, or of two times: `kernel q(t, s) = ...`",
              "kernel ${1:C}(lag) = -exp(-lag/${2:0.5}) * ${3:B}"},
    KnownWord{
        "superpotential",
        "a law, by its potential (`=`) or by its slope (`with slope`), whose "
        "jumps are filled in",
        "superpotential ${1:layer}(r) with slope\n  | r < 0 -> 0\n  | otherwise -> ${2:100}*r"},
    KnownWord{"state",
              "`state beta on glue with rate ... from beta = 1 in [0, 1]`: an ordinary "
              "differential equation at each point",
              "state ${1:beta} on ${2:glue} with rate ${3:-beta} from ${1:beta} = ${4:1}"},
    KnownWord{"fn", "`fn load(t) = 10*t`: a function of its arguments",
              "fn ${1:f}(${2:a}) = ${3:a}"},
    KnownWord{"space", "`space V = vector P1 on body, zero on roof`",
              "space ${1:V} = vector P1 on ${2:body}, zero on ${3:roof}"},
    KnownWord{
        "find", "the inequality: unknowns, times, and the form that holds for all test functions",
        "find ${1:u} in ${2:V} for t in [0, ${3:1}] by ${4:64} steps from ${1:u} = 0\nsuch that "
        "for all v in ${2:V}\n    integral(${5:body}, ${6:B} : eps(${1:u}) : eps(v))\n >= "
        "integral(${5:body}, dot([0, ${7:-10*t}], v))"},
    KnownWord{"report",
              "what a run prints and writes: `table`, `fields`, `line`, `plot`, `picture`",
              "report\n  table ${1:tip} = u.y at [${2:0, 0}]\n  fields u, sigma"},
    KnownWord{"expect",
              "`expect tip = 0.5 within 1e-9 relative \"analytic\"`: judged by `hvi-run test`",
              "expect ${1:tip} = ${2:0} within ${3:1e-9} relative \"${4:where it is from}\""},
    KnownWord{"study", "`study vary n in [8, 16, 32] against finest`: what accuracy costs",
              "study vary ${1:n} in [${2:8, 16, 32}] against finest"},
    KnownWord{"such", "`such that for all v in V`: the test functions", ""},
    KnownWord{"using", "settings of the solution: `using scheme = bdf2, quadrature = gauss`", ""},
    KnownWord{"with", "imposed values (`with u.y = -t on roof`), or the slope of a law", ""},
    KnownWord{"zero", "`zero on roof`, `zero.y on roof`: where functions of the space are 0", ""},
    KnownWord{"periodic",
              "`periodic left = right`, `periodic.x left = right`: the same values on both parts",
              ""},
    KnownWord{"otherwise", "the last case, where no condition holds", ""},
    KnownWord{"t", "time", ""},
    KnownWord{"lag", "t - s, of a kernel", ""},
    KnownWord{"pi", "3.14159...", ""},
    KnownWord{"normal", "the outward normal of a boundary part", ""},
    KnownWord{"sigma", "the stress: the sum of what stands against eps(v)", ""},
    KnownWord{"x", "the first coordinate; on axisymmetric meshes the radius", ""},
    KnownWord{"y", "the second coordinate; on axisymmetric meshes along the axis", ""},
    KnownWord{"z", "the third coordinate", ""},
};

const KnownWord* find_word(std::string_view word) {
  const auto found = std::ranges::find(table, word, &KnownWord::word);
  return found == table.end() ? nullptr : &*found;
}

} // namespace

std::string_view word_of_statement(std::string_view word) {
  const KnownWord* const found = find_word(word);
  return found ? found->meaning : std::string_view{};
}

std::string_view pattern_of_statement(std::string_view word) {
  const KnownWord* const found = find_word(word);
  return found ? found->pattern : std::string_view{};
}

} // namespace hvi::lang
