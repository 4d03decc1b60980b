// See protocol.hpp.
#include "lang/editor/protocol.hpp"

#include "lang/diag/real_path.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <charconv>
#include <filesystem>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view scheme = "file://";

/// Where modules of the standard library may lie as files: installed, or beside the build.
std::optional<std::string> module_path(const std::string& module) {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  if (none) return std::nullopt;
  for (const char* folder : {"../share/hvi", "../..", ".."}) {
    const fs::path path = (program.parent_path() / folder / module).lexically_normal();
    if (fs::is_regular_file(path, none)) return path.string();
  }
  return std::nullopt;
}

/// The import statement of the script that brought a file.
Span import_of(const Script& script, int file) {
  for (const ast::Statement& statement : script.programs[0].statements) {
    const auto* import = std::get_if<ast::Import>(&statement);
    if (!import) continue;
    const auto* name = std::get_if<ast::Name>(&import->module);
    const std::string path =
        name ? fmt::format("stdlib/{}.hvi", name->text) : std::get<ast::Text>(import->module).text;
    if (script.sources.file(file).path() == path) return import->span;
  }
  return {0, 0, 0};
}

int severity_number(Severity severity) {
  return severity == Severity::error ? 1 : severity == Severity::warning ? 2 : 3;
}

} // namespace

Json to_json(const EditorRange& range) {
  return {{"start", {{"line", range.begin.line}, {"character", range.begin.character}}},
          {"end", {{"line", range.end.line}, {"character", range.end.character}}}};
}

Json markdown(const std::string& text) { return {{"kind", "markdown"}, {"value", text}}; }

std::string code_block(std::string_view code) { return fmt::format("```hvi\n{}\n```", code); }

Json EditorPlace::range(const Span& span) const {
  return to_json(range_of(analysis.script().sources.file(span.file), span, unit));
}

Json EditorPlace::location(const Span& span) const {
  const auto path = path_of(analysis.script(), span.file);
  if (!path) return nullptr;
  return {{"uri", uri_of(*path)}, {"range", range(span)}};
}

std::string uri_of(const std::string& path) {
  std::string out(scheme);
  for (const char c : fs::absolute(path).lexically_normal().string()) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = std::isalnum(byte) || std::string_view("/-._~").find(c) != std::string::npos;
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return out;
}

std::optional<std::string> path_of(std::string_view uri) {
  if (!uri.starts_with(scheme)) return std::nullopt;
  uri.remove_prefix(scheme.size());
  uri.remove_prefix(std::min(uri.find('/'), uri.size())); // a host
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    const char* const digits = uri.data() + i + 1;
    const bool coded = uri[i] == '%' && i + 2 < uri.size() &&
                       std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2;
    out += coded ? static_cast<char>(value) : uri[i];
    if (coded) i += 2;
  }
  return out;
}

std::optional<std::string> path_of(const Script& script, int file) {
  if (file == 0) return script.path;
  const std::string& path = script.sources.file(file).path();
  const bool library = static_cast<std::size_t>(file) < script.programs.size() &&
                       script.programs[static_cast<std::size_t>(file)].library;
  if (library) return module_path(path);
  return (fs::path(script.path).parent_path() / path).lexically_normal().string();
}

Json to_json(const Diagnostic& d, const EditorPlace& place) {
  const Script& script = place.analysis.script();
  const bool here = d.primary.valid() && d.primary.file == 0;
  const Span span = here                ? d.primary
                    : d.primary.valid() ? import_of(script, d.primary.file)
                                        : Span{0, 0, 0};
  std::string message = d.message;
  if (!d.label.empty()) message += ": " + d.label;
  if (!here && d.primary.valid())
    message += fmt::format(" ({}:{})", script.sources.file(d.primary.file).path(),
                           script.sources.begin(d.primary).line);
  for (const std::string& note : d.notes) message += "\n" + note;
  if (!d.help.empty()) message += "\nhelp: " + d.help;
  Json out = {{"range", place.range(span)},
              {"severity", severity_number(d.severity)},
              {"code", d.code},
              {"source", "hvi-run"},
              {"message", message}};
  if (d.code == "W0101") out["tags"] = {1}; // unnecessary: shown faded
  for (const Label& label : d.secondary)
    if (Json location = place.location(label.span); label.span.valid() && !location.is_null())
      out["relatedInformation"].push_back({{"location", location}, {"message", label.text}});
  return out;
}

Json diagnostics_json(const EditorPlace& place) {
  Json out = Json::array();
  if (place.analysis.script().programs.empty()) return out;
  for (const Diagnostic& d : place.analysis.script().diagnostics.sorted())
    out.push_back(to_json(d, place));
  return out;
}

} // namespace hvi::lang
