// The study statement of a script: its ladders and what errors are measured against.
#pragma once

#include "lang/check/context.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

class Studies {
public:
  explicit Studies(const Context& context)
      : mistakes_(context.mistakes), names_(context.names), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator) {}

  void read(const ast::Program& script);

private:
  bool varies(const ast::Name& name, std::vector<std::string>& known);
  bool study_value(const ast::Expr& item, std::vector<std::string>& out);
  std::optional<StudyLadder> study_ladder(const ast::Ladder& ladder, const ModelStudy& study);
  bool climbs(const ast::Expr& item, const StudyLadder& ladder);
  std::vector<Symbol> exact_solution(const ast::Expr& written);
  void norm_of_study(const ast::Name& space, ModelStudy& study);

  Mistakes& mistakes_;
  const Names& names_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
};

} // namespace hvi::lang
