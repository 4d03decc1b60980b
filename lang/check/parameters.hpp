// Parameters: their values in this run, and those that are set from outside.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/operators.hpp"

#include <string>

namespace hvi::lang {

class Parameters {
public:
  Parameters(const Context& context, Operators& operators)
      : options_(context.options), mistakes_(context.mistakes), names_(context.names),
        model_(context.model), evaluator_(context.evaluator), operators_(operators) {}

  Value value(const ast::Param& param);
  void check_defines();

private:
  Value defined_value(const ast::Param& param);
  Value refuse_range(const ast::Param& param, const Word& word, const ModelParam& entry);
  bool is_in_range(const ast::Param& param, double value, ModelParam& entry);

  const CheckOptions& options_;
  Mistakes& mistakes_;
  const Names& names_;
  Model& model_;
  Evaluator& evaluator_;
  Operators& operators_;
};

} // namespace hvi::lang
