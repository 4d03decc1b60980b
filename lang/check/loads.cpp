// See loads.hpp. Used by the checker of forms and by the lowering.
#include "lang/check/loads.hpp"

#include <algorithm>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

bool knows_fields(const Symbol& e) {
  return e.depends_on_any(slot::first_field, slot::first_multiplier);
}

} // namespace

bool is_affine(const Symbol& against) {
  using solver::Op;
  if (!knows_fields(against)) return true;
  const auto& args = against.args();
  const auto all_affine = [&] { return std::ranges::all_of(args, is_affine); };
  switch (against.op()) {
  case Op::slot:
    return true;
  case Op::add:
  case Op::neg:
    return all_affine();
  case Op::mul:
    return std::ranges::count_if(args, knows_fields) == 1 && all_affine();
  case Op::div:
    return !knows_fields(args[1]) && is_affine(args[0]);
  case Op::select:
    return !knows_fields(args[0]) && all_affine();
  default:
    return false;
  }
}

bool reads_solution(const ModelTerm& term) {
  if (!term.right || term.integrand.rank != 0) return false;
  const Symbol& integrand = term.integrand.scalar();
  return std::ranges::any_of(solver::slots_of(integrand), [&](solver::Slot s) {
    return slot::is_test(s) && !is_affine(derivative(integrand, s));
  });
}

} // namespace hvi::lang
