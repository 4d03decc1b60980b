// What all results of a report have: a file, times, places.
#pragma once

#include "lang/check/context.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// Was a column of this name, or of a vector of which it is one, left out by a mistake?
bool may_have_column(const Model& model, const std::string& name);

/// Of every expression of a report.
Scope report_scope();

class Results {
public:
  explicit Results(const Context& context)
      : options_(context.options), mistakes_(context.mistakes), model_(context.model),
        evaluator_(context.evaluator) {}

  /// A time within the run.
  std::optional<double> report_time(const ast::Expr& e);
  /// The file of a result, "": none is given; nothing where it is wrong (reported).
  std::optional<std::string> output_name(const std::optional<ast::Text>& to);
  /// E0302 where two results are written to one file. After all are read.
  void check_files();
  /// The same of a picture, which is written as its ending says.
  std::optional<std::string> picture_name(const std::optional<ast::Text>& to);
  /// `from start`, which is of problems in time.
  bool from_start(const Span& words);
  /// A point; false: reported.
  bool place(const ast::Expr& e, solver::Point& out);

private:
  Span name_within(const Span& item) const;

  const CheckOptions& options_;
  Mistakes& mistakes_;
  const Model& model_;
  Evaluator& evaluator_;
  std::vector<Span> names_given_; ///< of files, with `to`
};

} // namespace hvi::lang
