// See actions.hpp.
#include "lang/editor/actions.hpp"

#include "lang/editor/edits.hpp"

#include <algorithm>

namespace hvi::lang {

namespace {

std::string after_edit(const SourceFile& file, const Edit& edit) {
  std::string text(file.text());
  for (auto change = edit.changes.rbegin(); change != edit.changes.rend(); ++change)
    text.replace(change->span.begin, change->span.length(), change->text);
  return text;
}

std::size_t warnings_in(const Script& script) {
  return script.diagnostics.size() - script.diagnostics.n_errors();
}

/// Gone is the mistake, and nothing else is wrong that was not before.
bool mends(const Analysis& before, const Analysis& now, const Diagnostic& d) {
  const Script& a = before.script();
  const Script& b = now.script();
  if (d.severity != Severity::error)
    return b.diagnostics.n_errors() <= a.diagnostics.n_errors() && warnings_in(b) < warnings_in(a);
  const auto count = [&](const Script& s) {
    return std::ranges::count(s.diagnostics.items(), d.code, &Diagnostic::code);
  };
  return b.diagnostics.n_errors() < a.diagnostics.n_errors() && count(b) < count(a);
}

Json action_json(const EditorPlace& place, const Diagnostic& d, const Edit& edit) {
  Json changes = Json::array();
  for (const Change& change : edit.changes)
    changes.push_back({{"range", place.range(change.span)}, {"newText", change.text}});
  return {{"title", edit.title},
          {"kind", "quickfix"},
          {"isPreferred", !edit.one_of_several},
          {"diagnostics", {to_json(d, place)}},
          {"edit", {{"changes", {{uri_of(place.analysis.script().path), changes}}}}}};
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
      if (!edit.one_of_several) break;
    }
  }
  return out;
}

} // namespace hvi::lang
