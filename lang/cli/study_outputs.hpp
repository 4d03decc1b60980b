// What a study leaves behind: lines, files, pictures.
#pragma once

#include "lang/cli/options.hpp"
#include "lang/study.hpp"

#include <string>

namespace hvi::lang {

/// The processor and the program that the numbers are of.
std::string machine_line();

/// Files, then the table, then pictures: what fails takes nothing with it that came before.
int report_study(const std::string& path, const Study& study, const std::string& folder,
                 const Options& options);

} // namespace hvi::lang
