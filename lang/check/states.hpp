// States: ordinary differential equations at the points of a part, those of its laws or inside a
// body.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/multipliers.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/parts.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

class States {
public:
  States(const Context& context, Parts& parts, Pairs& pairs, Multipliers& multipliers)
      : mistakes_(context.mistakes), names_(context.names), find_(context.find),
        model_(context.model), unknowns_(context.unknowns), evaluator_(context.evaluator),
        at_hand_(context.at_hand), parts_(parts), pairs_(pairs), multipliers_(multipliers) {}

  Value state(int declaration);
  void read_rates();
  Symbol without_states_known(Symbol expression, int part) const;
  bool reads_states_of(const Span& span, const Symbol& expression, int part,
                       const std::string& who);
  std::optional<std::vector<int>> take_states(Symbol& expression, const Span& span);
  bool states_of_form(const ModelTerm& term, const Span& span);
  bool take_time(ModelTerm& term, const Span& span);
  void check_states_of_laws();

private:
  void state_rate(ModelState& state);
  void state_range(ModelState& state);
  void state_initial(ModelState& state);
  bool lives_in_body(int part) const;
  Symbol clock_on(int part);
  void check_changing_form(const ModelTerm& term);

  Mistakes& mistakes_;
  Names& names_;
  const ast::Find* const find_;
  Model& model_;
  Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Parts& parts_;
  Pairs& pairs_;
  Multipliers& multipliers_;
  std::map<int, int> clocks_; ///< by part: the state that is t
};

} // namespace hvi::lang
