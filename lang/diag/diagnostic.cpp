// Diagnostics and their collector, see diagnostic.hpp.
#include "lang/diag/diagnostic.hpp"

#include "lang/diag/catalogue.hpp"

#include <algorithm>
#include <limits>

namespace hvi::lang {

Diagnostic&& Diagnostic::with_label(std::string text) && {
  label = std::move(text);
  return std::move(*this);
}

Diagnostic&& Diagnostic::with_secondary(const Span& span, std::string text) && {
  secondary.push_back({span, std::move(text)});
  return std::move(*this);
}

Diagnostic&& Diagnostic::with_note(std::string text) && {
  notes.push_back(std::move(text));
  return std::move(*this);
}

Diagnostic&& Diagnostic::with_help(std::string text) && {
  help = std::move(text);
  return std::move(*this);
}

Diagnostic diagnose(std::string_view code, const Span& primary, std::string message) {
  Diagnostic result;
  result.code = code;
  result.severity = severity_of(code);
  result.message = std::move(message);
  result.primary = primary;
  return result;
}

void Diagnostics::add(Diagnostic diagnostic) {
  // Things without a place (a command line flag) are told apart by their text.
  const Span& place = diagnostic.primary;
  const Key key{diagnostic.code, place.file, place.begin, place.end,
                place.valid() ? std::string() : diagnostic.message};
  if (!seen_.insert(key).second) return;
  if (diagnostic.severity == Severity::error) ++n_errors_;
  items_.push_back(std::move(diagnostic));
}

void Diagnostics::add(std::string_view code, const Span& primary, std::string message) {
  add(diagnose(code, primary, std::move(message)));
}

void Diagnostics::add_once(const std::string& what, Diagnostic diagnostic) {
  const auto [known, fresh] = once_.emplace(diagnostic.code + " " + what, items_.size());
  if (fresh) {
    const std::size_t before = items_.size();
    add(std::move(diagnostic));
    if (items_.size() == before) once_.erase(known); // said already, in another way
    return;
  }
  Diagnostic& first = items_[known->second];
  const bool earlier = diagnostic.primary.file == first.primary.file &&
                       diagnostic.primary.begin < first.primary.begin;
  if (earlier) first = std::move(diagnostic);
}

bool Diagnostics::has_error_in(const Span& span) const {
  return std::any_of(items_.begin(), items_.end(), [&](const Diagnostic& d) {
    return d.severity == Severity::error && d.primary.file == span.file &&
           d.primary.begin >= span.begin && d.primary.end <= span.end;
  });
}

std::vector<Diagnostic> Diagnostics::sorted() const {
  std::vector<Diagnostic> result = items_;
  const auto place = [](const Span& span) {
    const int file = span.valid() ? span.file : std::numeric_limits<int>::max();
    return std::pair{file, span.begin};
  };
  std::stable_sort(result.begin(), result.end(), [&](const Diagnostic& a, const Diagnostic& b) {
    return place(a.primary) < place(b.primary);
  });
  return result;
}

} // namespace hvi::lang
