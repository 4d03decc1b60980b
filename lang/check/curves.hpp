// Curves of a report: values along a line, plots of columns.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/output_fields.hpp"
#include "lang/check/results.hpp"

#include <string>

namespace hvi::lang {

class Curves {
public:
  Curves(const Context& context, Results& results, OutputFields& fields)
      : mistakes_(context.mistakes), model_(context.model), evaluator_(context.evaluator),
        results_(results), fields_(fields) {}

  void line(const ast::LineItem& item);
  void plot(const ast::PlotItem& item);

private:
  Mistakes& mistakes_;
  Model& model_;
  Evaluator& evaluator_;
  Results& results_;
  OutputFields& fields_;
};

} // namespace hvi::lang
