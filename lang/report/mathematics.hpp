// A script's model as mathematics: MathML as data, which the page turns into elements.
#pragma once

#include "lang/syntax/ast.hpp"

#include <nlohmann/json_fwd.hpp>

namespace hvi::lang {

/// A node is ["mi", child, ...]; a child is a node or a text. No text is markup.
nlohmann::ordered_json mathematics_of(const ast::Expr& expression);

/// {"find": node, "declarations": [{"what", "mathematics": node}]}: the problem with
/// one row for each term, then tensors, kernels, laws and functions of the script.
nlohmann::ordered_json mathematics_of(const ast::Program& program);

} // namespace hvi::lang
