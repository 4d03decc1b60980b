// Which files a script may read: those beside it or below it.
#pragma once

#include "lang/check/check.hpp"
#include "lang/check/mistakes.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

/// The whole path; nothing (reported) where the script may not read it.
std::optional<std::string> allowed_path(const std::string& path, const Span& span,
                                        const CheckOptions& options, Mistakes& mistakes);

} // namespace hvi::lang
