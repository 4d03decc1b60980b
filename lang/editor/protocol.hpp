// JSON of the Language Server Protocol 3.17 that several answers share.
#pragma once

#include "lang/editor/analysis.hpp"
#include "lang/editor/positions.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <string_view>

namespace hvi::lang {

using Json = nlohmann::json;

/// What an answer is about: a script, a place in it and how the editor counts.
struct EditorPlace {
  const Analysis& analysis;
  std::uint32_t offset = 0;
  CharacterUnit unit = CharacterUnit::utf16;

  [[nodiscard]] Json range(const Span& span) const;
  /// The place of a span in whichever file it lies; null in a module that is no file here.
  [[nodiscard]] Json location(const Span& span) const;
};

[[nodiscard]] Json to_json(const EditorRange& range);
[[nodiscard]] Json markdown(const std::string& text);
/// A fenced block of a script.
[[nodiscard]] std::string code_block(std::string_view code);

[[nodiscard]] std::string uri_of(const std::string& path);
/// The path in a file: URI; nothing for other schemes.
[[nodiscard]] std::optional<std::string> path_of(std::string_view uri);
/// Where the file of an import lies; nothing where a module of the library is not installed.
[[nodiscard]] std::optional<std::string> path_of(const Script& script, int file);

/// All diagnostics of the script's own file; those of its imports stand at their import.
[[nodiscard]] Json diagnostics_json(const EditorPlace& place);
[[nodiscard]] Json to_json(const Diagnostic& diagnostic, const EditorPlace& place);

} // namespace hvi::lang
