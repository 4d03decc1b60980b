// Tensors that vary in place, and the parts on which they are used: they are looked at there, on
// the mesh.
#pragma once

#include "lang/check/context.hpp"

#include <map>
#include <set>
#include <vector>

namespace hvi::lang {

class MaterialPlaces {
public:
  explicit MaterialPlaces(const Context& context)
      : model_(context.model), at_hand_(context.at_hand) {}

  /// Of an expression that is of place alone.
  void note(const Span& span, const Field& value, bool elliptic);
  /// A declaration is used where we are.
  void note_use(int declaration);
  /// Gives every material the parts on which its declaration is used, directly or through others.
  void place_all();

private:
  Model& model_;
  AtHand& at_hand_;
  std::vector<int> owners_;               ///< of model_.materials: a declaration, or -1
  std::map<int, std::set<int>> parts_of_; ///< by declaration: parts on which it is used
  std::map<int, std::set<int>> used_by_;  ///< by declaration: declarations that use it
};

} // namespace hvi::lang
