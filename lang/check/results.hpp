// What all results of a report have: a file, times, places.
#pragma once

#include "lang/check/context.hpp"

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
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
  /// The file of a result, which is written as its ending says, "": none is given; nothing where it
  /// is wrong (reported). Of a table or a line, of fields, of a picture:
  std::optional<std::string> columns_name(const std::optional<ast::Text>& to);
  std::optional<std::string> fields_name(const std::optional<ast::Text>& to);
  std::optional<std::string> picture_name(const std::optional<ast::Text>& to,
                                          const char* ending = ".png"); ///< of a name without one
  /// E0302 where two results are written to one file. After all are read.
  void check_files();
  /// `from start`, which is of problems in time.
  bool from_start(const Span& words);
  /// A point; false: reported.
  bool place(const ast::Expr& e, solver::Point& out);

private:
  std::optional<std::string> output_name(const std::optional<ast::Text>& to);
  std::optional<std::string> name_ending(const std::optional<ast::Text>& to,
                                         std::initializer_list<std::string_view> endings,
                                         const char* what, const char* help);
  Span name_within(const Span& item) const;

  const CheckOptions& options_;
  Mistakes& mistakes_;
  const Model& model_;
  Evaluator& evaluator_;
  std::vector<Span> names_given_; ///< of files, with `to`
};

} // namespace hvi::lang
