// Settings of a find statement that change nothing of what the script computes.
#pragma once

#include "lang/check/context.hpp"

namespace hvi::lang {

/// W0109 of each. What a parameter may change is not looked at.
void tell_unheeded_settings(const ast::Find& find, const Model& model, Mistakes& mistakes);

} // namespace hvi::lang
