// What does not fit, with both places and both dimensions.
#pragma once

#include "lang/units/named_dimensions.hpp"

#include <set>
#include <string>
#include <vector>

namespace hvi::lang::units {

/// A quantity with the place where it stands, for messages.
struct Side {
  const Measured* value;
  const ast::Expr* place;
};

class DimensionMistakes {
public:
  DimensionMistakes(const std::vector<ast::Program>& programs, const System& system,
                    const NamedDimensions& names, Inference& inference, Diagnostics& diagnostics);

  // What has to be: false where it is not, and then it is reported.
  bool same(Side left, Side right, const std::string& what);
  /// Has to be of this dimension; `what` it is, "a length of a mesh".
  bool wants(Side given, const Dimension& dimension, const std::string& what);
  bool wants_number(const ast::Expr& e, const Measured& given, const std::string& what);

  void report(Diagnostic diagnostic);
  std::size_t count() const { return diagnostics_.size(); }
  bool none_yet() const { return !diagnostics_.has_errors(); }
  std::string shown(const Dimension& dimension) const;
  std::string shown_with_words(const Dimension& dimension) const;

  /// Around the body of a function or a law that is called.
  void enter_call(const Span& call) { calls_.push_back(call); }
  void leave_call() { calls_.pop_back(); }

private:
  std::string help_for_bare(Side given, const Dimension& wanted) const;

  const System& system_;
  const NamedDimensions& names_;
  Inference& inference_;
  Diagnostics& diagnostics_;
  std::set<int> library_;   ///< files of the standard library
  std::vector<Span> calls_; ///< of functions and laws whose bodies are read
};

} // namespace hvi::lang::units
