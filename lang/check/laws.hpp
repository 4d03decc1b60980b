// Superpotentials: their bodies as functions of one argument, and the laws of the plan they become.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/limits.hpp"
#include "lang/check/states.hpp"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace hvi::lang {

/// Cases in the body of a law: one condition each, and the value of what remains.
struct LawCases {
  std::vector<Symbol> conditions;
  std::vector<Span> places, values; ///< of the conditions; of the values, the last one's too
};

class Laws {
public:
  Laws(const Context& context, Limits& limits, States& states)
      : mistakes_(context.mistakes), names_(context.names), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator), at_hand_(context.at_hand),
        limits_(limits), states_(states) {}

  /// In the body of another law.
  Value call(const ast::Expr& e, const ast::Call& call, int declaration, const Scope& scope);
  /// `layer.xi`.
  Value member(const ast::Member& member, int declaration, const Scope& scope);
  /// The law that a declaration has become where it was applied to a scalar or a vector.
  std::optional<int> made(int declaration, bool of_vector) const;
  /// Into the model; returns its index there.
  int add(ModelLaw law, bool reads_jumps);
  bool reads_jumps(int law) const { return laws_of_jumps_.contains(law); }
  /// Of the body that is read; those of the laws it calls are not looked at.
  void note_cases(LawCases cases);
  /// The law as an expression of its argument and of what it reads of the solution. False
  /// (reported) when it reads what it cannot.
  bool take_readings(const std::string& name, const Span& span, const Symbol& body, bool on_pair,
                     solver::LawSpec& spec);
  /// Its index in the model, made when it is first applied; nothing (reported) where it is wrong.
  std::optional<int> law_for(int declaration, bool radial, const Span& use);
  /// False (reported at the argument) when a law that reads well for a scalar is given a vector.
  bool is_law_of_vectors(int declaration, const ast::Expr& argument, const Field& at);
  /// One that nothing applies.
  void check_alone(int declaration);

private:
  std::optional<Field> body_of(int declaration, const Field& argument,
                               const std::map<std::string, Value>& parameters, const Span& use);
  Value coupled_multiplier(const ast::Member& member, int declaration);
  bool is_law_parameter(const Value& value, const ast::Expr& given);
  Span place_in_law(const solver::Failure& failure, const Span& otherwise) const;
  void warn_of_unreached_cases(bool radial);

  Mistakes& mistakes_;
  const Names& names_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  AtHand& at_hand_;
  Limits& limits_;
  States& states_;
  std::map<std::pair<int, bool>, int> law_index_; ///< by declaration, of a vector or not; -1: wrong
  std::vector<LawCases> law_cases_;               ///< of the law being checked, inner ones first
  std::string coupled_;          ///< the law whose multiplier the law being checked reads
  Span coupled_place_;           ///< and where
  std::set<int> laws_at_hand_;   ///< whose bodies are being read
  std::set<int> laws_in_circle_; ///< reported: they are defined by themselves
  std::set<int> laws_of_jumps_;  ///< of model_.laws: their bodies read jumps
};

} // namespace hvi::lang
