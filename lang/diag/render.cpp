// Diagnostics as text and as JSON, see render.hpp; the snippets are in snippet.cpp.
#include "lang/diag/render.hpp"

#include "lang/diag/snippet.hpp"
#include "lang/diag/utf8.hpp"

#include <fmt/format.h>

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

// One line of JSON, written as it is read: an editor asks for it at every key stroke.
class JsonLine {
public:
  JsonLine() { out_.reserve(512); }
  void string(std::string_view text) {
    out_ += '"';
    for (std::size_t i = 0; i < text.size();) {
      const auto character = utf8::decode(text, i);
      append(text.substr(i, character.length), character);
      i += character.length;
    }
    out_ += '"';
  }
  void field(std::string_view key, std::string_view text) {
    out_ += fmt::format(",\"{}\":", key);
    string(text);
  }
  void raw(std::string_view text) { out_ += text; }
  [[nodiscard]] std::string take() { return std::move(out_); }

private:
  // Scripts may hold bytes that are no UTF-8; JSON may not.
  void append(std::string_view bytes, const utf8::Character& character) {
    if (!character.valid)
      out_ += utf8::encode(0xFFFD);
    else if (character.code == U'"' || character.code == U'\\')
      (out_ += '\\') += bytes;
    else if (character.code < 0x20)
      out_ += fmt::format("\\u{:04x}", static_cast<unsigned>(character.code));
    else
      out_ += bytes;
  }

  std::string out_;
};

void place_json(JsonLine& out, const SourceMap& sources, const Span& span) {
  out.raw("\"file\":");
  if (!span.valid())
    return out.raw(R"(null,"line":null,"column":null,"end_line":null,"end_column":null)");
  const Position begin = sources.begin(span);
  const Position end = sources.end(span);
  out.string(sources.file(span.file).path());
  out.raw(fmt::format(R"(,"line":{},"column":{},"end_line":{},"end_column":{})", begin.line,
                      begin.column, end.line, end.column));
}

std::string to_json(const Diagnostic& diagnostic, const SourceMap& sources) {
  JsonLine out;
  out.raw("{");
  place_json(out, sources, diagnostic.primary);
  out.field("code", diagnostic.code);
  out.field("severity", word(diagnostic.severity));
  out.field("message", diagnostic.message);
  out.field("label", diagnostic.label);
  out.raw(",\"secondary\":[");
  for (std::size_t i = 0; i < diagnostic.secondary.size(); ++i) {
    out.raw(i == 0 ? "{" : ",{");
    place_json(out, sources, diagnostic.secondary[i].span);
    out.field("text", diagnostic.secondary[i].text);
    out.raw("}");
  }
  out.raw("],\"notes\":[");
  for (std::size_t i = 0; i < diagnostic.notes.size(); ++i) {
    if (i > 0) out.raw(",");
    out.string(diagnostic.notes[i]);
  }
  out.raw("]");
  out.field("help", diagnostic.help);
  out.raw("}\n");
  return out.take();
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
  for (const Diagnostic& diagnostic : diagnostics.sorted()) result += to_json(diagnostic, sources);
  return result;
}

} // namespace hvi::lang
