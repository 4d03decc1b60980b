// What is known on a pair of sides: jumps and means of values, and its gap. See pairs.cpp for how
// they are kept.
#pragma once

#include "lang/check/context.hpp"

#include <string>
#include <vector>

namespace hvi::lang {

/// Jumps that a law's body reads.
bool has_jumps(const Symbol& symbol); ///< or means
bool has_jumps_and_values(const Symbol& symbol);
/// Of an expression on a pair, where its jumps have become values: are there means in it?
bool has_means(const std::vector<Symbol>& on_pair);
Symbol without_jumps(const Symbol& symbol);

/// A jump or a mean as it is kept: of a value of a field or of a test function.
bool is_jump(solver::Slot s);
solver::Slot jump_of(solver::Slot s);
solver::Slot mean_of(solver::Slot s);

class Pairs {
public:
  explicit Pairs(const Context& context)
      : mistakes_(context.mistakes), model_(context.model), unknowns_(context.unknowns),
        at_hand_(context.at_hand) {}

  bool is_pair(int part) const;
  /// Of an expression on a part (-1: unknown): on a pair jumps become values; jumps elsewhere,
  /// values on a pair and gaps of others are reported.
  bool take_jumps(const Span& span, std::vector<Symbol>& components, int part);
  /// Reports, once for each part, that it is no pair.
  void refuse_no_pair(const Span& span, const std::string& what, int part) const;
  /// Of a probe at a point: on the pair that has the point.
  bool take_jumps_at_point(const Span& span, Symbol& expression, solver::Probe& probe);
  /// True (reported) where the part is a pair.
  bool refuse(int part, const Span& span, const std::string& what);

private:
  Mistakes& mistakes_;
  const Model& model_;
  const Unknowns& unknowns_;
  AtHand& at_hand_;
};

} // namespace hvi::lang
