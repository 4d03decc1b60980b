// The catalogue: one table of every diagnostic the program can give. `hvi-run explain` prints an
// entry, docs/diagnostics.md is generated from it, and tests hold every code used in lang/ to it.
// The entries live in one file per class (catalogue_lexical.cpp, ...).
#pragma once

#include "lang/diag/diagnostic.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::lang {

/// One diagnostic. `wrong` is a script (or the telling part of one) that raises it, `right` the
/// same lines put right. Both are empty where the mistake is in what was asked of the program: see
/// ExampleCall. Raw strings may start with a newline; it is trimmed on output.
struct CatalogueEntry {
  std::string_view code;        // "E0312"
  std::string_view title;       // a few words, no full stop: "unknown name"
  std::string_view explanation; // one or more paragraphs
  std::string_view wrong;
  std::string_view right;
};

/// A wrong and a right way to call the program, in the words of its user interface.
struct ExampleCall {
  std::string_view code;
  std::string_view wrong;
  std::string_view right;
};

/// The tables by class.
[[nodiscard]] std::span<const CatalogueEntry> catalogue_lexical();    // E01
[[nodiscard]] std::span<const CatalogueEntry> catalogue_syntax();     // E02
[[nodiscard]] std::span<const CatalogueEntry> catalogue_names();      // E03
[[nodiscard]] std::span<const CatalogueEntry> catalogue_problem();    // E04
[[nodiscard]] std::span<const CatalogueEntry> catalogue_hypotheses(); // E05
[[nodiscard]] std::span<const CatalogueEntry> catalogue_files();      // E06
[[nodiscard]] std::span<const CatalogueEntry> catalogue_solve();      // E07, E09
[[nodiscard]] std::span<const CatalogueEntry> catalogue_warnings();   // W

/// Every entry, sorted by code.
[[nodiscard]] std::vector<CatalogueEntry> catalogue();

/// The entry of a code (upper or lower case); nothing when there is none.
[[nodiscard]] std::optional<CatalogueEntry> find_entry(std::string_view code);

/// "error" ... of a code by its first letter: E error, W warning, N note.
[[nodiscard]] Severity severity_of(std::string_view code);

/// Name of the class of a code: "lexical", "syntax", "names, types and shapes", ...
[[nodiscard]] std::string_view class_of(std::string_view code);

/// What `hvi-run explain CODE` prints; nothing for an unknown code.
[[nodiscard]] std::optional<std::string> explain(std::string_view code,
                                                 std::span<const ExampleCall> calls);

/// The whole of docs/diagnostics.md.
[[nodiscard]] std::string catalogue_markdown(std::span<const ExampleCall> calls);

} // namespace hvi::lang
