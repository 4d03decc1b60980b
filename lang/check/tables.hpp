// Tables of a report: a column for each number.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/probes.hpp"
#include "lang/check/results.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

class Tables {
public:
  Tables(const Context& context, Parts& parts, Pairs& pairs, Probes& probes, Results& results)
      : mistakes_(context.mistakes), model_(context.model), unknowns_(context.unknowns),
        evaluator_(context.evaluator), at_hand_(context.at_hand), parts_(parts), pairs_(pairs),
        probes_(probes), results_(results) {}

  void read(const ast::TableItem& item);

private:
  int norm_of_unknown(const ast::Expr& e) const;
  [[nodiscard]] bool binding(const ast::Binding& binding, solver::TableSpec& table);
  std::optional<Field> column_value(const ast::Binding& binding);
  bool take_side(const ast::Binding& binding, const Field& value, solver::Probe& probe);
  bool has_one_value(const ast::Binding& binding, const Field& value);
  bool column(const ast::Binding& binding, solver::Probe probe, solver::TableSpec& table);
  void take_at_its_time(std::size_t first, solver::Probe& p);

  Mistakes& mistakes_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Parts& parts_;
  Pairs& pairs_;
  Probes& probes_;
  Results& results_;
};

} // namespace hvi::lang
