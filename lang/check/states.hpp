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

  /// The value at a point; rate, initial value and range are read when all laws are known.
  Value state(int declaration);
  /// Those that nothing reads, too. Rates may read states that were not met before.
  void read_rates();
  /// Without the states of bodies: a report may read them on any part of cells, facets or points,
  /// and the mesh says whether they live there (LawSampler).
  Symbol without_states_of_bodies(Symbol expression, int part) const;
  /// False (reported) where an expression on one part reads a state of another.
  bool reads_states_of(const Span& span, const Symbol& expression, int part,
                       const std::string& who);
  /// The states that a law reads: its expression gets their numbers among them.
  std::optional<std::vector<int>> take_states(Symbol& expression, const Span& span);
  /// States in the coefficients of a form.
  bool states_of_form(const ModelTerm& term, const Span& span);
  /// A form in a body whose coefficients depend on t is one that a state changes, the time itself.
  bool take_time(ModelTerm& term, const Span& span);
  /// Laws and forms read states of their own part; states live where a law acts, or in a body.
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
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Parts& parts_;
  Pairs& pairs_;
  Multipliers& multipliers_;
  std::map<int, int> clocks_; ///< by part: the state that is t
};

} // namespace hvi::lang
