// Why a file gave nothing.
#pragma once

#include <string>

namespace hvi::lang {

/// Why `read_text` gave nothing for a path, as a message; `name`: what the user calls it.
[[nodiscard]] std::string why_unreadable(const std::string& path, const std::string& name);

} // namespace hvi::lang
