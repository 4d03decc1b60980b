// Diagnostics as text and as JSON, see render.hpp; the snippets are in snippet.cpp.
#include "lang/diag/render.hpp"

#include "lang/diag/snippet.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>

namespace hvi::lang {
namespace {

using Marks = std::map<int, std::vector<Mark>>; // by file

Marks collect_marks(const Diagnostic& diagnostic, const SourceMap& sources) {
  Marks result;
  const auto collect = [&](const Span& span, bool primary, const std::string& text) {
    if (!span.valid()) return;
    auto& marks = result[span.file];
    const auto more = marks_of(sources.file(span.file), span, primary, text);
    marks.insert(marks.end(), more.begin(), more.end());
  };
  collect(diagnostic.primary, true, diagnostic.label);
  for (const Label& label : diagnostic.secondary) collect(label.span, false, label.text);
  return result;
}

std::size_t gutter_width(const Marks& marks) {
  int last = 1;
  for (const auto& [file, items] : marks)
    for (const Mark& mark : items) last = std::max(last, mark.line);
  return std::to_string(last).size();
}

std::string place(const SourceMap& sources, const Span& span) {
  const Position position = sources.begin(span);
  return sources.file(span.file).path() + ":" + std::to_string(position.line) + ":" +
         std::to_string(position.column);
}

// "= note: ..." with the following lines of the text below the first.
std::string footnote(std::string_view word, const std::string& text, std::size_t gutter,
                     const Palette& palette) {
  const std::string head = std::string(gutter + 1, ' ') + "= ";
  std::string result = palette.secondary(head) + palette.strong(word) + ": ";
  const std::string indent(head.size() + word.size() + 2, ' ');
  for (const char c : text) result += c == '\n' ? "\n" + indent : std::string(1, c);
  return result + "\n";
}

std::string first_line(const Diagnostic& diagnostic, const Palette& palette) {
  const std::string head = std::string(word(diagnostic.severity)) + "[" + diagnostic.code + "]";
  return palette.primary(head) + palette.strong(": " + diagnostic.message) + "\n";
}

nlohmann::ordered_json place_json(const SourceMap& sources, const Span& span) {
  if (!span.valid())
    return {{"file", nullptr},
            {"line", nullptr},
            {"column", nullptr},
            {"end_line", nullptr},
            {"end_column", nullptr}};
  const Position begin = sources.begin(span);
  const Position end = sources.end(span);
  return {{"file", sources.file(span.file).path()},
          {"line", begin.line},
          {"column", begin.column},
          {"end_line", end.line},
          {"end_column", end.column}};
}

nlohmann::ordered_json to_json(const Diagnostic& diagnostic, const SourceMap& sources) {
  nlohmann::ordered_json result = place_json(sources, diagnostic.primary);
  result["code"] = diagnostic.code;
  result["severity"] = word(diagnostic.severity);
  result["message"] = diagnostic.message;
  result["label"] = diagnostic.label;
  result["secondary"] = nlohmann::ordered_json::array();
  for (const Label& label : diagnostic.secondary) {
    auto item = place_json(sources, label.span);
    item["text"] = label.text;
    result["secondary"].push_back(std::move(item));
  }
  result["notes"] = diagnostic.notes;
  result["help"] = diagnostic.help;
  return result;
}

} // namespace

std::string_view word(Severity severity) {
  switch (severity) {
  case Severity::error:
    return "error";
  case Severity::warning:
    return "warning";
  case Severity::note:
    return "note";
  }
  return "error";
}

std::string render(const Diagnostic& diagnostic, const SourceMap& sources,
                   const RenderOptions& options) {
  const Palette palette{options.colour, diagnostic.severity};
  std::string result = first_line(diagnostic, palette);
  Marks marks = collect_marks(diagnostic, sources);
  const std::size_t gutter = gutter_width(marks);
  const auto show = [&](int file, std::string_view arrow, const Span& span) {
    result += std::string(gutter, ' ') + palette.secondary(arrow) + " " + place(sources, span);
    result += "\n" + snippet(sources.file(file), std::move(marks[file]), gutter, palette);
    marks.erase(file);
  };
  if (diagnostic.primary.valid()) show(diagnostic.primary.file, "-->", diagnostic.primary);
  for (const Label& label : diagnostic.secondary)
    if (marks.contains(label.span.file)) show(label.span.file, ":::", label.span);
  for (const std::string& note : diagnostic.notes)
    result += footnote("note", note, gutter, palette);
  if (!diagnostic.help.empty()) result += footnote("help", diagnostic.help, gutter, palette);
  return result;
}

std::string render(const Diagnostics& diagnostics, const SourceMap& sources,
                   const RenderOptions& options) {
  const auto items = diagnostics.sorted();
  const std::size_t shown = std::min(options.limit, items.size());
  std::string result;
  for (std::size_t i = 0; i < shown; ++i)
    result += (i == 0 ? "" : "\n") + render(items[i], sources, options);
  if (shown < items.size()) result += "\nand " + std::to_string(items.size() - shown) + " more\n";
  return result;
}

std::string render_json(const Diagnostics& diagnostics, const SourceMap& sources) {
  std::string result;
  for (const Diagnostic& diagnostic : diagnostics.sorted()) {
    // Scripts may hold bytes that are no UTF-8; JSON may not.
    result += to_json(diagnostic, sources)
                  .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    result += '\n';
  }
  return result;
}

} // namespace hvi::lang
