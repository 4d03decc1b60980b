// The files of lang/report/page, embedded at build.
#pragma once

#include <string_view>

namespace hvi::lang {

std::string_view page_html();
std::string_view page_style();
std::string_view page_code(); ///< all scripts, in their order

} // namespace hvi::lang
