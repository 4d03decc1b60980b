// Fields of a report, written for every point of the body or drawn.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/results.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hvi::lang {

class OutputFields {
public:
  OutputFields(const Context& context, Results& results)
      : mistakes_(context.mistakes), model_(context.model), evaluator_(context.evaluator),
        results_(results) {}

  std::optional<solver::FieldSpec> output_field(const ast::Expr& e);
  /// A field that has a value at every point of the body.
  std::optional<solver::FieldSpec> drawn_field(const ast::Expr& e, const std::string& what);
  void read(const ast::FieldsItem& item);

  /// False (reported) where one of `before` is the same field: one result would have it twice.
  bool is_new(const solver::FieldSpec& field, const std::vector<solver::FieldSpec>& before);

private:
  bool fits(const Field& field) const;
  std::string name_of(const ast::Expr& e, const std::vector<Symbol>& components);

  Mistakes& mistakes_;
  Model& model_;
  Evaluator& evaluator_;
  Results& results_;
  std::vector<std::pair<std::string, std::vector<Symbol>>> named_;
};

} // namespace hvi::lang
