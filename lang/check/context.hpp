// What all parts of the checker share, and what is given to each of them when it is made.
#pragma once

#include "lang/check/check.hpp"
#include "lang/check/evaluator.hpp"
#include "lang/check/unknowns.hpp"

namespace hvi::lang {

/// Where the expression stands that is read: it changes as the checker goes through a script.
struct AtHand {
  int declaration = -1;       ///< that is evaluated
  int part = -1;              ///< of the integral that is read
  int gap = -1;               ///< the part whose gap the expression has read
  bool source = false;        ///< the form term has `slip.xi` or a state of a boundary in it
  bool reads_stress = false;  ///< it has sigma in it
  bool normal_missed = false; ///< in the integral a normal was missed and reported
};

struct Context {
  const CheckOptions& options;
  const ast::Find* find; ///< null: the script has none
  Mistakes& mistakes;
  Names& names;
  Model& model; ///< under construction
  Unknowns& unknowns;
  Evaluator& evaluator;
  AtHand& at_hand;
};

/// Of tensors: 3 on axisymmetric meshes, where zz is along the circles.
inline int tensor_dim(const Model& model) { return model.mesh.axisymmetric ? 3 : model.dim; }

} // namespace hvi::lang
