// The integrals of the inequality, term by term.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/parts.hpp"
#include "lang/check/sources.hpp"
#include "lang/check/states.hpp"

#include <optional>

namespace hvi::lang {

class Forms {
public:
  Forms(const Context& context, Parts& parts, Pairs& pairs, States& states, Sources& sources)
      : mistakes_(context.mistakes), find_(context.find), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator), at_hand_(context.at_hand),
        parts_(parts), pairs_(pairs), states_(states), sources_(sources) {}

  void read(const ast::Find& find);

private:
  std::optional<Symbol> form_factors(const ast::FormTerm& term);
  Scope scope_of(std::optional<int> part, bool right, bool source) const;
  void take_rule(const ast::Integral& integral, ModelTerm& term);
  void form_term(const ast::FormTerm& term, bool right, bool source);
  bool check_load(ModelTerm& load, const Span& span);
  bool check_integrand(const ModelTerm& term, const ast::FormTerm& written, bool source);
  void law_factors(ModelTerm& term, const ast::FormTerm& source);

  Mistakes& mistakes_;
  const ast::Find* const find_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Parts& parts_;
  Pairs& pairs_;
  States& states_;
  Sources& sources_;
};

} // namespace hvi::lang
