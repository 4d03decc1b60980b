// The unknowns of the find statement and their test functions: by name, and as values.
#pragma once

#include "lang/check/model.hpp"
#include "lang/check/scope.hpp"
#include "lang/syntax/ast.hpp"

#include <string>

namespace hvi::lang {

class Unknowns {
public:
  Unknowns(const ast::Find* find, const Model& model) : find_(find), model_(model) {}

  /// Which unknown has this name, -1: none.
  int named(const std::string& name) const;
  /// Which unknown has the test function of this name, -1: none.
  int tested_by(const std::string& name) const;
  const std::string& name_of(int unknown) const;
  /// "`u`", "`u` or `theta`": for messages.
  std::string names() const;
  std::string names_of_tests() const;

  /// Are the spaces of all known? Before, nothing below is.
  bool known = false;
  bool is_vector(int unknown) const;
  /// Of the values of the b-th unknown.
  int components_of(int unknown) const;
  /// The first unknown that is a vector, else the first.
  int first_vector() const;
  /// The derivative in time of this order, or the test function.
  Field value(int unknown, int order, bool is_test, const Scope& scope) const;

private:
  const ast::Find* const find_;
  const Model& model_;
};

} // namespace hvi::lang
