// Catalogue of diagnostics, class E01: lexical.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto lexical_entries = std::to_array<CatalogueEntry>({
    {"E0101", "character without a meaning",
     R"(
The character begins no name, number, text or sign of the language. Groups are written with round
brackets, lists with square ones; names begin with a letter.)",
     R"(
param n = 3 @)",
     R"(
param n = 3)"},
    {"E0102", "character that looks like an ASCII one",
     R"(
Text copied from a paper or a word processor often holds a Unicode minus, typographic quotes or
no-break spaces. They look like plain characters and are not; the message says which plain character
is meant.)",
     R"(
fn f(x) = x − 2)",
     R"(
fn f(x) = x - 2)"},
    {"E0103", "letter that cannot be part of a name",
     R"(
Names consist of the letters a-z and A-Z, digits and `_`, and begin with a letter. Greek letters are
written out: `lambda`, `mu`, `eps`. Texts and comments may hold any character.)",
     R"(
param λ = 5)",
     R"(
param lambda = 5)"},
    {"E0104", "malformed number",
     R"(
A letter, a digit group or a second decimal point is glued to a number. A product is written with
`*`, a unit stands in brackets (`2 [mm]`); there are no digit separators and no hexadecimal numbers.)",
     R"(
param width = 2n)",
     R"(
param width = 2*n)"},
    {"E0105", "number out of range",
     R"(
Numbers are double precision: their size lies between about 1e-308 and 1e308.)",
     R"(
param big = 1e999)",
     R"(
param big = 1e99)"},
    {"E0106", "text without a closing quote",
     R"(
A text stands between double quotes on one line. It cannot hold a double quote.)",
     R"(
param n = 4  "cells)",
     R"(
param n = 4  "cells")"},
    {"E0107", "control character in the script",
     R"(
The script holds a character that cannot be seen: often the trace of a broken copy or a binary file
given by mistake.)",
     R"(
param n = <the byte 0x01> 4)",
     R"(
param n = 4)"},
    {"E0108", "bytes that are not UTF-8",
     R"(
Scripts are UTF-8 text. The bytes shown are no character of that encoding, as happens with files
saved in Latin-1. Save the script as UTF-8.)",
     R"(
param n = <the byte 0xFF>)",
     R"(
param n = 4)"},
    {"E0109", "script too large",
     R"(
A script is larger than 4 MiB. Scripts are written by hand; measured curves belong into CSV files,
read by `table("file.csv")`, and meshes into mesh files.)",
     R"(
a script of five million characters)",
     R"(
fn load(t) = table("load.csv", t))"},
    {"E0110", "sign of another language",
     R"(
`and`, `or` and `not` are words, and comments begin with `#`. The signs `&&`, `&`, `!` and `%` do not
exist.)",
     R"(
part roof = slab.boundary where y > 0.9 && x < 1)",
     R"(
part roof = slab.boundary where y > 0.9 and x < 1)"},
});

} // namespace

std::span<const CatalogueEntry> catalogue_lexical() { return lexical_entries; }

} // namespace hvi::lang
