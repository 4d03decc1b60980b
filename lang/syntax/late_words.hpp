// Statement words that scripts had as names before: they are words where nothing else can be meant.
#pragma once

#include "lang/diag/source.hpp"
#include "lang/syntax/token.hpp"

#include <vector>

namespace hvi::lang {

void find_late_words(const SourceFile& source, std::vector<Token>& tokens);

} // namespace hvi::lang
