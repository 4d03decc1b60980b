#include "lang/check/mistakes.hpp"

#include <algorithm>
#include <utility>

namespace hvi::lang {

void Mistakes::error(std::string_view code, const Span& span, std::string message, std::string help,
                     std::string label) {
  Span place = span;
  if (in_library(span))
    for (const Span& call : calls_)
      if (!in_library(call)) place = call;
  Diagnostic d = diagnose(code, place, std::move(message));
  if (place.file != span.file) d.secondary.push_back({span, "met here"});
  d.help = std::move(help);
  d.label = std::move(label);
  diagnostics_.add(std::move(d));
}

bool Mistakes::in_library(const Span& place) const {
  return std::any_of(programs_.begin(), programs_.end(),
                     [&](const auto& p) { return p.library && p.file == place.file; });
}

Diagnostics Mistakes::said_by(const std::function<void()>& work) {
  Diagnostics said;
  std::swap(said, diagnostics_);
  work();
  std::swap(said, diagnostics_);
  return said;
}

} // namespace hvi::lang
