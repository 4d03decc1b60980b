#include "lang/check/mistakes.hpp"

#include <algorithm>
#include <utility>

namespace hvi::lang {

void Mistakes::error(std::string_view code, const Span& span, std::string message, std::string help,
                     std::string label) {
  diagnostics_.add(told(code, span, std::move(message), std::move(help), std::move(label)));
}

void Mistakes::error_once(const std::string& what, std::string_view code, const Span& span,
                          std::string message, std::string help) {
  diagnostics_.add_once(what, told(code, span, std::move(message), std::move(help), {}));
}

/// At the call in the script, where the mistake is met in a module.
Diagnostic Mistakes::told(std::string_view code, const Span& span, std::string message,
                          std::string help, std::string label) const {
  Span place = span;
  if (in_library(span))
    for (const OpenCall& open : calls_)
      if (!in_library(open.call)) place = open.call;
  Diagnostic d = diagnose(code, place, std::move(message));
  if (place.file != span.file) d.secondary.push_back({span, "met here"});
  tell_calls(place, d);
  d.help = std::move(help);
  d.label = std::move(label);
  return d;
}

/// What a function is given may be what is wrong in it: the call, and the calls that lead to it.
void Mistakes::tell_calls(const Span& place, Diagnostic& diagnostic) const {
  constexpr std::size_t most_calls = 3;
  Span inside = place;
  for (auto open = calls_.rbegin(); open != calls_.rend(); ++open) {
    const Span& body = open->body;
    const bool leads_there =
        body.file == inside.file && body.begin <= inside.begin && inside.end <= body.end;
    if (!leads_there || diagnostic.secondary.size() >= most_calls) continue;
    diagnostic.secondary.push_back({open->call, "called here"});
    inside = open->call;
  }
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
