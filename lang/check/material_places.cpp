#include "lang/check/material_places.hpp"

#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

void MaterialPlaces::note_use(int declaration) {
  if (at_hand_.part >= 0) parts_of_[declaration].insert(at_hand_.part);
  if (at_hand_.declaration >= 0) used_by_[declaration].insert(at_hand_.declaration);
}

void MaterialPlaces::note(const Span& span, const Field& value, bool elliptic) {
  for (const Symbol& c : value.components)
    for (solver::Slot s : solver::slots_of(c))
      if (s > slot::x(2) && (s < slot::first_inside || s >= slot::first_state)) return;
  ModelMaterial material{span, value, elliptic, {}};
  if (at_hand_.part >= 0) material.parts.insert(at_hand_.part);
  model_.materials.push_back(std::move(material));
  owners_.push_back(at_hand_.declaration);
}

void MaterialPlaces::place_all() {
  for (std::size_t i = 0; i < owners_.size(); ++i) {
    std::vector<int> open;
    std::set<int> seen;
    if (owners_[i] >= 0) open.push_back(owners_[i]);
    while (!open.empty()) {
      const int declaration = open.back();
      open.pop_back();
      if (!seen.insert(declaration).second) continue;
      const std::set<int>& parts = parts_of_[declaration];
      model_.materials[i].parts.insert(parts.begin(), parts.end());
      for (int user : used_by_[declaration]) open.push_back(user);
    }
  }
}

} // namespace hvi::lang
