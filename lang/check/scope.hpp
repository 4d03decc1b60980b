// What may be used in an expression, by where it stands.
#pragma once

#include "lang/check/value.hpp"

#include <map>
#include <string>

namespace hvi::lang {

/// What may be used in an expression, and what the names of its frame stand for.
struct Scope {
  std::string what;      ///< "a parameter", "a load": for messages
  bool position = false; ///< x y z
  bool time = false;     ///< t
  bool lag = false;      ///< lag
  bool normal = false;   ///< normal, and u.nu
  bool unknown = false;  ///< u, u', history(...)
  bool test = false;     ///< v
  bool report = false;   ///< nonlinear in u is welcome; sigma, layer.xi, integral(...)
  bool law = false;      ///< the body of a superpotential
  bool states = false;   ///< states of points
  bool source = false;   ///< a source that reads multipliers of laws, nonlinear in u as it likes
  bool load = false;     ///< a load, nonlinear in u as it likes; sigma
  int part = -1;         ///< on which it is asked; -1: on no part that is said
  std::map<std::string, Value> locals;
  Span call; ///< the call that brought us into another file, if any

  [[nodiscard]] bool may_be_nonlinear() const { return report || source || load; }

  /// The same things visible inside a function, whose arguments are its only locals.
  [[nodiscard]] Scope without_locals() const {
    return {what, position, time,   lag,  normal, unknown, test, report,
            law,  states,   source, load, part,   {},      call};
  }
};

} // namespace hvi::lang
