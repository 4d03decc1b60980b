// Why a file gave nothing, or nothing of use.
#pragma once

#include <string>

namespace hvi::lang {

/// Why `read_text` gave nothing for a path, as a message; `name`: what the user calls it.
[[nodiscard]] std::string why_unreadable(const std::string& path, const std::string& name);

/// What may have been meant by the name of a file that is not there: one of its name in a folder
/// below `folder`, or one with a name like it where it should be, or in a folder with a name like
/// that. Files of its ending come first, then scripts. A help; empty where there is none.
[[nodiscard]] std::string meant_file(const std::string& folder, const std::string& name);

/// What is wrong in a file, with its name unless that is in it.
[[nodiscard]] std::string said_of_file(const std::string& name, const std::string& what);

} // namespace hvi::lang
