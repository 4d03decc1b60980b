// What the checker has to say about a script. What goes wrong within the library is said of the
// script's call that leads there; of what goes wrong in a function of the script the call is told.
#pragma once

#include "lang/diag/diagnostic.hpp"
#include "lang/syntax/ast.hpp"

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hvi::lang {

class Mistakes {
public:
  Mistakes(const std::vector<ast::Program>& programs, Diagnostics& diagnostics)
      : programs_(programs), diagnostics_(diagnostics) {}

  void error(std::string_view code, const Span& span, std::string message, std::string help = {},
             std::string label = {});
  /// The first time only, for each `what`.
  void error_once(const std::string& what, std::string_view code, const Span& span,
                  std::string message, std::string help);
  void add(Diagnostic diagnostic) { diagnostics_.add(std::move(diagnostic)); }
  void add_once(const std::string& what, Diagnostic diagnostic) {
    diagnostics_.add_once(what, std::move(diagnostic));
  }
  bool has_errors() const { return diagnostics_.has_errors(); }
  bool has_error_in(const Span& span) const { return diagnostics_.has_error_in(span); }
  /// What `work` would say; nothing of it is said.
  Diagnostics said_by(const std::function<void()>& work);

  /// Around the evaluation of a function or a law that is called: the call, and what is evaluated.
  void enter_call(const Span& call, const Span& body) { calls_.push_back({call, body}); }
  void leave_call() { calls_.pop_back(); }

private:
  struct OpenCall {
    Span call, body;
  };
  Diagnostic told(std::string_view code, const Span& span, std::string message, std::string help,
                  std::string label) const;
  void tell_calls(const Span& place, Diagnostic& diagnostic) const;
  bool in_library(const Span& place) const;

  const std::vector<ast::Program>& programs_;
  Diagnostics& diagnostics_;
  std::vector<OpenCall> calls_; ///< of functions and laws that are being evaluated
};

} // namespace hvi::lang
