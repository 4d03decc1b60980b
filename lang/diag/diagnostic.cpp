// Diagnostics and their collector, see diagnostic.hpp.
#include "lang/diag/diagnostic.hpp"

#include "lang/diag/catalogue.hpp"
#include "lang/diag/utf8.hpp"

#include <algorithm>
#include <limits>

namespace hvi::lang {
namespace {

/// No path is that long and no name: what a text quotes beyond it is told by its ends.
constexpr std::size_t longest_quote = 500, head_of_quote = 120, tail_of_quote = 20;

std::string shortened(std::string_view quote) {
  std::size_t head = 0, tail = quote.size() - tail_of_quote;
  while (head < head_of_quote) head += utf8::decode(quote, head).length;
  while (tail > 0 && (static_cast<unsigned char>(quote[tail]) & 0xC0u) == 0x80u) --tail;
  return std::string(quote.substr(0, head)) + "..." + std::string(quote.substr(tail));
}

/// A number of a million digits stays readable as a word of a sentence.
void shorten_quotes(std::string& text) {
  if (text.size() <= longest_quote) return;
  std::string out;
  std::size_t at = 0;
  for (std::size_t open = 0; (open = text.find('`', at)) != std::string::npos;) {
    const std::size_t close = text.find('`', open + 1);
    if (close == std::string::npos) break;
    const std::string_view quote = std::string_view(text).substr(open + 1, close - open - 1);
    out.append(text, at, open + 1 - at);
    out += quote.size() > longest_quote ? shortened(quote) : std::string(quote);
    out += '`';
    at = close + 1;
  }
  text = out + text.substr(at);
}

} // namespace

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
  for (std::string* text : {&diagnostic.message, &diagnostic.label, &diagnostic.help})
    shorten_quotes(*text);
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

bool Diagnostics::has_error_at(const Span& span) const {
  return std::any_of(items_.begin(), items_.end(), [&](const Diagnostic& d) {
    return d.severity == Severity::error && d.primary.file == span.file &&
           d.primary.begin == span.begin && d.primary.end == span.end;
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
