// What the terminal shows of a run.
#pragma once

#include "lang/cli/options.hpp"

namespace hvi::lang {

/// The table, the certificate with what else there is to know of the run, and, as asked for, its
/// profile. `bandwidth`: bytes a second that this machine reads.
void print_result(const Session& session, const Options& options, double bandwidth);

} // namespace hvi::lang
