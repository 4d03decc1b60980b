// See actions.hpp.
#include "lang/editor/actions.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang {

namespace {

struct Edit {
  Span span; ///< what is replaced
  std::string text;
  std::string title;
};

/// What stands between backticks and can be taken as it is: nothing with "...".
std::vector<std::string> proposals(const std::string& help) {
  std::vector<std::string> out;
  for (std::size_t open = help.find('`'); open != std::string::npos;) {
    const std::size_t close = help.find('`', open + 1);
    if (close == std::string::npos) break;
    const std::string text = help.substr(open + 1, close - open - 1);
    if (!text.empty() && text.find("...") == std::string::npos) out.push_back(text);
    open = help.find('`', close + 1);
  }
  return out;
}

/// The end of the statement that holds a span, without the blanks behind it.
Span end_of_statement(const Analysis& a, const Span& span) {
  const auto statement = statement_at(a.tokens[0], span.begin);
  return statement.empty() ? after(span) : after(statement.back().span);
}

/// The lines of a statement that nothing uses, their ends included.
Span lines_of(const Analysis& a, const Definition& d) {
  const SourceFile& file = a.source();
  const int first = file.position(d.statement.begin).line;
  const int behind = file.position(d.statement.end).line + 1;
  const std::uint32_t end = behind <= file.n_lines()
                                ? file.line_begin(behind)
                                : static_cast<std::uint32_t>(file.text().size());
  return {0, file.line_begin(first), end};
}

std::vector<Edit> edits_for(const Analysis& a, const Diagnostic& d) {
  std::vector<Edit> out;
  if (d.code == "W0101") {
    const NameUse* const use = a.names.at(0, d.primary.begin);
    if (!use) return out;
    const Definition& definition = a.names.definitions[use->definition];
    out.push_back({lines_of(a, definition), "", fmt::format("remove `{}`", definition.name)});
    return out;
  }
  for (const std::string& text : proposals(d.help)) {
    if (text.starts_with("import ")) {
      const std::uint32_t first = a.tokens[0].tokens.front().span.begin;
      out.push_back({{0, first, first}, text + "\n", fmt::format("add `{}`", text)});
      continue;
    }
    const std::string written = a.text(d.primary);
    if (!written.empty())
      out.push_back({d.primary, text, fmt::format("write `{}` in place of `{}`", text, written)});
    out.push_back({after(d.primary), " " + text, fmt::format("add `{}`", text)});
    out.push_back({end_of_statement(a, d.primary), " " + text, fmt::format("add `{}`", text)});
  }
  return out;
}

std::string after_edit(const SourceFile& file, const Edit& edit) {
  std::string text(file.text());
  return text.replace(edit.span.begin, edit.span.length(), edit.text);
}

std::size_t warnings_in(const Script& script) {
  return script.diagnostics.size() - script.diagnostics.n_errors();
}

/// Gone is the mistake, and nothing else is wrong that was not before.
bool mends(const Analysis& before, const Analysis& now, const Diagnostic& d) {
  const Script& a = before.script();
  const Script& b = now.script();
  if (d.severity != Severity::error)
    return b.diagnostics.n_errors() == 0 && warnings_in(b) < warnings_in(a);
  const auto count = [&](const Script& s) {
    return std::ranges::count(s.diagnostics.items(), d.code, &Diagnostic::code);
  };
  return b.diagnostics.n_errors() < a.diagnostics.n_errors() && count(b) < count(a);
}

Json action_json(const EditorPlace& place, const Diagnostic& d, const Edit& edit) {
  const Json change = {{{"range", place.range(edit.span)}, {"newText", edit.text}}};
  return {{"title", edit.title},
          {"kind", "quickfix"},
          {"isPreferred", true},
          {"diagnostics", {to_json(d, place)}},
          {"edit", {{"changes", {{uri_of(place.analysis.script().path), change}}}}}};
}

} // namespace

Json actions(const EditorPlace& place, const Span& range, const Compile& compile) {
  Json out = Json::array();
  const Analysis& a = place.analysis;
  for (const Diagnostic& d : a.script().diagnostics.sorted()) {
    if (d.primary.file != 0 || d.primary.end < range.begin || range.end < d.primary.begin) continue;
    for (const Edit& edit : edits_for(a, d)) {
      const auto tried = compile(after_edit(a.source(), edit));
      if (!mends(a, *tried, d)) continue;
      out.push_back(action_json(place, d, edit));
      break;
    }
  }
  return out;
}

} // namespace hvi::lang
