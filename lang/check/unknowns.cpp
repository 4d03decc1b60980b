#include "lang/check/unknowns.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

std::string either(const std::vector<ast::Unknown>& all, ast::Name ast::Unknown::*name) {
  std::string out;
  for (std::size_t b = 0; b < all.size(); ++b)
    out += fmt::format("{}`{}`",
                       b == 0               ? ""
                       : b + 1 < all.size() ? ", "
                                            : " or ",
                       (all[b].*name).text);
  return out;
}

} // namespace

int Unknowns::named(const std::string& name) const {
  for (std::size_t b = 0; find_ && b < find_->unknowns.size(); ++b)
    if (find_->unknowns[b].unknown.text == name) return static_cast<int>(b);
  return -1;
}

int Unknowns::tested_by(const std::string& name) const {
  for (std::size_t b = 0; find_ && b < find_->unknowns.size(); ++b)
    if (find_->unknowns[b].test.text == name) return static_cast<int>(b);
  return -1;
}

std::string Unknowns::names() const { return either(find_->unknowns, &ast::Unknown::unknown); }

std::string Unknowns::names_of_tests() const {
  return either(find_->unknowns, &ast::Unknown::test);
}

const std::string& Unknowns::name_of(int unknown) const {
  return find_->unknowns[static_cast<std::size_t>(unknown)].unknown.text;
}

bool Unknowns::is_vector(int unknown) const {
  return unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
}

int Unknowns::components_of(int unknown) const {
  return solver::components_of(unknowns_of(model_.space)[static_cast<std::size_t>(unknown)],
                               model_.dim);
}

int Unknowns::first_vector() const {
  const auto all = unknowns_of(model_.space);
  const auto found = std::ranges::find(all, true, &solver::UnknownSpec::vector);
  return found == all.end() ? 0 : static_cast<int>(found - all.begin());
}

/// A derivative in time of the b-th unknown, or its test function. A law knows what it reads: there
/// it is a number like any other.
Field Unknowns::value(int unknown, int order, bool is_test, const Scope& scope) const {
  std::vector<Symbol> components;
  for (int i = 0; i < components_of(unknown); ++i) {
    const int of = slot::of_unknown(unknown, slot::value(i));
    components.push_back(
        Symbol::variable(is_test ? slot::test(of) : slot::field(solver::field_of_u(order), of)));
  }
  const bool vector = is_vector(unknown);
  Field f = vector ? vector_field(components) : scalar_field(components[0]);
  if (is_test || scope.unknown)
    (is_test ? f.test : f.trial) = Degree::linear;
  else
    f.read = true;
  f.rate = order > 0;
  f.acceleration = order == 2;
  if (vector && is_test)
    f.materials = {{.tested = true, .unknown = unknown}};
  else if (vector && scope.unknown)
    f.materials = {{.of = solver::field_of_u(order), .unknown = unknown}};
  return f;
}

} // namespace hvi::lang
