// The language server: answers an editor over two file descriptors (Language Server Protocol 3.17).
// The scripts that are open are kept with their analysis, which is made anew when it is asked for
// after a change.
#pragma once

#include "lang/session.hpp"

namespace hvi::lang {

/// Serves until the editor says `exit` or closes its end. 0 where it said `shutdown` before.
int serve_editor(int input, int output, const CompileSettings& settings, const char* version);

} // namespace hvi::lang
