// Calls: functions of the script, laws and built-in functions.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/functions.hpp"
#include "lang/check/laws.hpp"
#include "lang/check/limits.hpp"
#include "lang/check/memories.hpp"
#include "lang/check/pair_calls.hpp"
#include "lang/check/probes.hpp"
#include "lang/check/series.hpp"
#include "lang/check/tensors.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

class Calls {
public:
  Calls(const Context& context, Limits& limits, PairCalls& pair_calls, Tensors& tensors,
        Series& series, Memories& memories, Laws& laws, Probes& probes, Functions& functions)
      : mistakes_(context.mistakes), names_(context.names), unknowns_(context.unknowns),
        evaluator_(context.evaluator), limits_(limits), pair_calls_(pair_calls), tensors_(tensors),
        series_(series), memories_(memories), laws_(laws), probes_(probes), functions_(functions) {}

  Value call(const ast::Expr& e, const ast::Call& call, const Scope& scope);

private:
  std::optional<bool> leaves_meaning(const ast::Call& call, const Scope& scope);
  Value call_function(const ast::Expr& e, const ast::Call& call, int declaration,
                      const Scope& scope);
  Value call_built_in(const ast::Expr& e, const ast::Call& call, const std::string& name,
                      const Scope& scope);

  Mistakes& mistakes_;
  Names& names_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  Limits& limits_;
  PairCalls& pair_calls_;
  Tensors& tensors_;
  Series& series_;
  Memories& memories_;
  Laws& laws_;
  Probes& probes_;
  Functions& functions_;
  std::vector<int> functions_at_hand_; ///< declarations, as they call one another
};

} // namespace hvi::lang
