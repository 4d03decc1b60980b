// The find statement: what it asks for, in the order in which its clauses need one another.
#pragma once

#include "lang/check/form_checks.hpp"
#include "lang/check/forms.hpp"
#include "lang/check/imposed_values.hpp"
#include "lang/check/material_places.hpp"
#include "lang/check/memories.hpp"
#include "lang/check/series.hpp"
#include "lang/check/settings.hpp"
#include "lang/check/spaces.hpp"
#include "lang/check/time_clause.hpp"

namespace hvi::lang {

/// What it shares with the expressions of a script.
struct FindParts {
  MeshGroups& groups;
  Parts& parts;
  Pairs& pairs;
  MaterialPlaces& places;
  Series& series;
  Memories& memories;
  States& states;
  Sources& sources;
  Spaces& spaces;
};

class FindStatement {
public:
  FindStatement(const Context& context, const FindParts& with);

  /// False where the names of the unknowns are not clear: then nothing else can be read.
  bool read(const ast::Find& find);

private:
  bool check_names(const ast::Find& find);

  Mistakes& mistakes_;
  const Names& names_;
  Model& model_;
  const Unknowns& unknowns_;
  MaterialPlaces& places_;
  Series& series_;
  Memories& memories_;
  States& states_;
  Spaces& spaces_;
  ImposedValues imposed_;
  TimeClause time_;
  Forms forms_;
  Settings settings_;
  FormChecks form_checks_;
};

} // namespace hvi::lang
