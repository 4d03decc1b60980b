// What messages call the ways to ask for something else. A message of the engine or of the checker
// is the same for whoever asks; the command line puts in its options (lang/cli/options.cpp).
#pragma once

#include "solver/common/failure.hpp"

#include <string>

namespace hvi::lang {

struct Words {
  std::string define = "the setting ";                ///< before the `name=value` of a parameter
  std::string allow_geometry = "allow it";            ///< of a file that can run programs
  std::string output_folder = "the output folder";    ///< where results go
  std::string (*help)(solver::FailureKind) = nullptr; ///< where a failure brings none; "": none
  /// What can be done about a failure; may be empty.
  std::string help_for(const solver::Failure& failure) const {
    return failure.help.empty() && help != nullptr ? help(failure.kind) : failure.help;
  }
};

} // namespace hvi::lang
