// See law_fields.hpp.
#include "solver/discrete/law_fields.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {

void LawFields::add(int field, double factor, Vector value) {
  others_.push_back({field, factor, std::move(value)});
}

const LawFields::Other& LawFields::other(int field) const {
  return *std::ranges::find(others_, field, &Other::field);
}

const Vector& LawFields::operator[](int field) const {
  return field == field_of_u(0) ? u_ : other(field).value;
}

double LawFields::factor(int field) const {
  return field == field_of_u(0) ? 1.0 : other(field).factor;
}

} // namespace hvi::solver
