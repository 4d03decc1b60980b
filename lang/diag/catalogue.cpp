// The catalogue as a whole: lookup, `hvi-run explain`, docs/diagnostics.md. Entries:
// catalogue_*.cpp.
#include "lang/diag/catalogue.hpp"

#include <algorithm>
#include <cctype>

namespace hvi::lang {
namespace {

struct ClassName {
  std::string_view prefix;
  std::string_view name;
};

constexpr auto classes = std::to_array<ClassName>({
    {"E01", "lexical"},
    {"E02", "syntax"},
    {"E03", "names, types and shapes"},
    {"E04", "problem structure and values"},
    {"E05", "hypotheses"},
    {"E06", "meshes and files"},
    {"E07", "solve"},
    {"E09", "internal"},
    {"W", "warnings"},
    {"N", "notes"},
});

std::string_view severity_word(std::string_view code) {
  switch (severity_of(code)) {
  case Severity::error:
    return "error";
  case Severity::warning:
    return "warning";
  case Severity::note:
    return "note";
  }
  return "error";
}

// Raw strings in the tables begin behind the quote with a newline, for the reader's sake.
std::string_view trimmed(std::string_view text) {
  while (text.starts_with('\n')) text.remove_prefix(1);
  while (text.ends_with('\n')) text.remove_suffix(1);
  return text;
}

std::string indented(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) result.append("    ").append(text.substr(0, end));
    result += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return result;
}

std::string fenced(std::string_view text) {
  // Not ```hvi: these are fragments, which the test of the runnable blocks must not pick up.
  return "```text\n" + std::string(trimmed(text)) + "\n```\n";
}

std::string markdown_section(const CatalogueEntry& entry) {
  std::string result = "### " + std::string(entry.code) + ": " + std::string(entry.title) + "\n\n";
  result.append(trimmed(entry.explanation)).append("\n\n");
  result.append("Wrong:\n\n").append(fenced(entry.wrong));
  result.append("\nRight:\n\n").append(fenced(entry.right)).append("\n");
  return result;
}

/// The entry with the example that it leaves to the caller.
CatalogueEntry completed(CatalogueEntry entry, std::span<const ExampleCall> calls) {
  const auto call = std::ranges::find(calls, entry.code, &ExampleCall::code);
  if (!entry.wrong.empty() || call == calls.end()) return entry;
  entry.wrong = call->wrong;
  entry.right = call->right;
  return entry;
}

} // namespace

std::vector<CatalogueEntry> catalogue() {
  std::vector<CatalogueEntry> result;
  for (const auto& part :
       {catalogue_lexical(), catalogue_syntax(), catalogue_names(), catalogue_problem(),
        catalogue_hypotheses(), catalogue_files(), catalogue_solve(), catalogue_warnings()})
    result.insert(result.end(), part.begin(), part.end());
  std::sort(result.begin(), result.end(),
            [](const CatalogueEntry& a, const CatalogueEntry& b) { return a.code < b.code; });
  return result;
}

std::optional<CatalogueEntry> find_entry(std::string_view code) {
  std::string wanted(code);
  for (char& c : wanted) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const CatalogueEntry& entry : catalogue())
    if (entry.code == wanted) return entry;
  return std::nullopt;
}

Severity severity_of(std::string_view code) {
  if (code.starts_with('W')) return Severity::warning;
  return code.starts_with('N') ? Severity::note : Severity::error;
}

std::string_view class_of(std::string_view code) {
  for (const ClassName& entry : classes)
    if (code.starts_with(entry.prefix)) return entry.name;
  return "unknown";
}

std::optional<std::string> explain(std::string_view code, std::span<const ExampleCall> calls) {
  auto entry = find_entry(code);
  if (!entry) return std::nullopt;
  *entry = completed(*entry, calls);
  std::string result(severity_word(entry->code));
  result.append("[").append(entry->code).append("]: ").append(entry->title);
  result.append(" (").append(class_of(entry->code)).append(")\n\n");
  result.append(trimmed(entry->explanation)).append("\n\n");
  result.append("Wrong:\n\n").append(indented(trimmed(entry->wrong)));
  result.append("\nRight:\n\n").append(indented(trimmed(entry->right)));
  return result;
}

std::string catalogue_markdown(std::span<const ExampleCall> calls) {
  std::string result = R"(# Diagnostics

Every message of `hvi-run` has a code; `hvi-run explain CODE` prints the section below. Codes are
grouped by the phase that finds the mistake. This file is generated from the tables in
`lang/diag/catalogue_*.cpp`; a test compares the two.

)";
  std::string_view current;
  for (const CatalogueEntry& entry : catalogue()) {
    if (const auto name = class_of(entry.code); name != current) {
      const std::size_t length = entry.code.starts_with('E') ? 3 : 1;
      result.append("## ").append(entry.code.substr(0, length)).append(": ");
      result.append(name).append("\n\n");
      current = name;
    }
    result += markdown_section(completed(entry, calls));
  }
  result.pop_back();
  return result;
}

} // namespace hvi::lang
