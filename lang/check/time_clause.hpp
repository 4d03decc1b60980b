// The time grid and the initial state of a find statement.
#pragma once

#include "lang/check/context.hpp"

#include <optional>
#include <vector>

namespace hvi::lang {

class TimeClause {
public:
  explicit TimeClause(const Context& context)
      : mistakes_(context.mistakes), names_(context.names), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator) {}

  void read(const ast::Find& find);

private:
  void time_grid(const ast::TimeClause& clause);
  bool is_static_start(const ast::InitialValue& initial) const;
  bool misspells_static(const ast::InitialValue& initial);
  void check_static_start(const ast::Find& find);
  void initial_state(const ast::Find& find);
  std::optional<std::vector<Symbol>> initial_value(const ast::InitialValue& initial, int unknown);

  Mistakes& mistakes_;
  const Names& names_;
  Model& model_;
  Unknowns& unknowns_;
  Evaluator& evaluator_;
};

} // namespace hvi::lang
