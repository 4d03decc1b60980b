// What a phase says about a script. Every phase of lang/ reports into one Diagnostics; the driver
// renders it at the end (lang/diag/render.hpp). Texts and severities come from the catalogue.
#pragma once

#include "lang/diag/source.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace hvi::lang {

enum class Severity { error, warning, note };

/// A second place that explains the first: "opened here", "declared here".
struct Label {
  Span span;
  std::string text;
};

/// One message. The `with...` functions return the diagnostic itself, so that it can be written
/// in one expression:
///   diagnostics.add(diagnose("E0301", name.span, "unknown name `foo`").with_help("did you ..."));
struct Diagnostic {
  std::string code; // "E0301"; must stand in the catalogue (a test greps the sources)
  Severity severity = Severity::error;
  std::string message;            // one line, names quoted with backticks
  Span primary;                   // what the carets underline; invalid: no snippet
  std::string label;              // text behind the carets, may be empty
  std::vector<Label> secondary;   // other places, underlined with dashes
  std::vector<std::string> notes; // facts, "= note: ..."
  std::string help;               // what to do, "= help: ..."; may be empty

  Diagnostic&& with_label(std::string text) &&;
  Diagnostic&& with_secondary(const Span& span, std::string text) &&;
  Diagnostic&& with_note(std::string text) &&;
  Diagnostic&& with_help(std::string text) &&;
};

/// A diagnostic whose severity follows from its code: E... error, W... warning, N... note.
[[nodiscard]] Diagnostic diagnose(std::string_view code, const Span& primary, std::string message);

/// Collects diagnostics of all phases. A second one with the same code at the same span is dropped.
class Diagnostics {
public:
  void add(Diagnostic diagnostic);
  /// Shorthand for add(diagnose(...)).
  void add(std::string_view code, const Span& primary, std::string message);

  /// One mistake seen from several places (a name that is unknown wherever it stands): the first
  /// place in reading order is kept. `what` tells mistakes of one code apart.
  void add_once(const std::string& what, Diagnostic diagnostic);

  [[nodiscard]] bool has_errors() const { return n_errors_ > 0; }
  /// Whether an error was reported within this span.
  [[nodiscard]] bool has_error_in(const Span& span) const;
  /// Whether an error was reported of exactly this span.
  [[nodiscard]] bool has_error_at(const Span& span) const;
  [[nodiscard]] std::size_t n_errors() const { return n_errors_; }
  [[nodiscard]] std::size_t size() const { return items_.size(); }
  /// In the order they were reported.
  [[nodiscard]] const std::vector<Diagnostic>& items() const { return items_; }
  /// By file, then place; those without a place come last. Equal places keep their order.
  [[nodiscard]] std::vector<Diagnostic> sorted() const;

private:
  using Key = std::tuple<std::string, int, std::uint32_t, std::uint32_t, std::string>;
  std::vector<Diagnostic> items_;
  std::set<Key> seen_;
  std::map<std::string, std::size_t> once_; // index into items_ by code and mistake
  std::size_t n_errors_ = 0;
};

} // namespace hvi::lang
