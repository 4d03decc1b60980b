// Scripts to start from: `hvi-run new KIND`. They lie in examples/new.
#pragma once

#include "lang/stdlib.hpp"

#include <span>

namespace hvi::lang {

/// By kind; the first line of each says in a comment what it is.
std::span<const Module> scripts_to_start_from();

} // namespace hvi::lang
