// What was typed wrong, where the command is known: options that it does not have, words too many.
#pragma once

#include <CLI/App.hpp>

#include <string>
#include <vector>

namespace hvi::lang {

/// `words`: what stands behind the program's name. "": nothing that can be told better than by the
/// parser itself.
std::string slip_of(const CLI::App& app, const std::vector<std::string>& words);

} // namespace hvi::lang
