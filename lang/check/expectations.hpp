// The expect statements of a script.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/results.hpp"

#include <string>

namespace hvi::lang {

class Expectations {
public:
  Expectations(const Context& context, Results& results)
      : options_(context.options), mistakes_(context.mistakes), model_(context.model),
        evaluator_(context.evaluator), results_(results) {}

  void read(const ast::Program& script);
  /// Of which column an accuracy is asked for.
  void read_accuracy(const ast::Find& find);

private:
  void require_column(const std::string& name, const Span& place);
  bool has_row(double t) const;
  void require_row(const Expectation& e, const Span& time);

  const CheckOptions& options_;
  Mistakes& mistakes_;
  Model& model_;
  Evaluator& evaluator_;
  Results& results_;
};

} // namespace hvi::lang
