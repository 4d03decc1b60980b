// The checker: it owns the parts that read a script and gives them to one another. Public entry:
// lang/check/check.hpp.
//
// Declarations are evaluated when first used (reading order is free), each at most once; a circle
// is an error. An expression is evaluated to a symbolic Value in a Scope that says what is visible.
// Each part has a header of its own, and is given what it uses when it is made:
//
//   Mistakes Names Unknowns Limits    what is said, declared, sought; how deep a script may go
//   Evaluator                         how the others ask for the value of an expression
//   MeshGroups Meshes Parts           the mesh, its pieces, groups and parts
//   Pairs PairCalls                   jumps, means, gaps
//   Operators Functions Tensors       what values can be made of values
//   Series Memories                   data, kernels and history(C, eps(u))
//   States Multipliers Laws           superpotentials, what they read, what reads them
//   LawApplications Sources           j^0(at; direction), `slip.xi * eta`
//   Probes                            integrals, extremes, reactions
//   Parameters Spaces DeclaredValues  the value of a declaration
//   References Calls Expressions      the value of an expression
//   FindStatement                     Forms FormChecks ImposedValues TimeClause Settings
//   Report Expectations Studies       Results Tables OutputFields Pictures Curves
#pragma once

#include "lang/check/calls.hpp"
#include "lang/check/declared_values.hpp"
#include "lang/check/expectations.hpp"
#include "lang/check/expressions.hpp"
#include "lang/check/find_statement.hpp"
#include "lang/check/functions.hpp"
#include "lang/check/law_applications.hpp"
#include "lang/check/meshes.hpp"
#include "lang/check/pair_calls.hpp"
#include "lang/check/parameters.hpp"
#include "lang/check/references.hpp"
#include "lang/check/report.hpp"
#include "lang/check/sources.hpp"
#include "lang/check/studies.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

class Checker : private Evaluator {
public:
  Checker(const std::vector<ast::Program>& programs, const CheckOptions& options,
          Diagnostics& diagnostics);
  std::optional<Model> run();

private:
  Value expr(const ast::Expr& e, const Scope& scope) override {
    return expressions_.expr(e, scope);
  }
  std::optional<Symbol> condition(const ast::Condition& c, const Scope& scope) override {
    return expressions_.condition(c, scope);
  }
  Value reference(const ast::Expr& e, const std::string& name, const Scope& scope) override {
    return references_.reference(e, name, scope);
  }
  Value& value_of(int declaration, const Span& use) override {
    return declared_.value_of(declaration, use);
  }

  void check_finds();
  void locate_pieces();
  bool meshes_are_good() const;
  void check_declarations();
  void check_unused();
  void warn_of_unused_arguments(const ast::Statement& statement);
  void tell_facts() const;

  const std::vector<ast::Program>& programs_;
  const CheckOptions& options_;
  const ast::Find* const find_;
  Mistakes mistakes_;
  Names names_;
  Model model_;
  Unknowns unknowns_;
  Limits limits_;
  AtHand at_hand_;
  const Context context_{options_, find_, mistakes_, names_, model_, unknowns_, *this, at_hand_};

  MeshGroups groups_;
  Meshes meshes_{context_, groups_};
  Parts parts_{context_, groups_};
  Pairs pairs_{context_};
  PairCalls pair_calls_{context_, parts_, pairs_};
  MaterialPlaces places_{context_};
  Operators operators_{context_};
  Functions functions_{context_, operators_};
  Tensors tensors_{context_, places_};
  Series series_{context_, operators_};
  Memories memories_{context_, tensors_};
  Multipliers multipliers_{context_};
  States states_{context_, parts_, pairs_, multipliers_};
  Laws laws_{context_, limits_, states_};
  LawApplications applications_{context_, pairs_, laws_};
  Sources sources_{context_, pairs_, multipliers_, states_, laws_};
  Probes probes_{context_, parts_, pairs_, states_};
  Parameters parameters_{context_, operators_};
  Spaces spaces_{context_, parts_, pairs_};
  DeclaredValues declared_{context_, limits_, meshes_,     parts_, places_,
                           tensors_, states_, parameters_, spaces_};
  References references_{context_};
  Calls calls_{context_,  limits_, pair_calls_, tensors_,  series_,
               memories_, laws_,   probes_,     functions_};
  Expressions expressions_{context_, limits_, parts_,        operators_,
                           tensors_, laws_,   applications_, calls_};
  FindStatement statement_{
      context_, {groups_, parts_, pairs_, places_, series_, memories_, states_, sources_, spaces_}};
  Report report_{context_, parts_, pairs_, probes_, memories_, laws_};
  Expectations expectations_{context_, report_.results()};
  Studies studies_{context_};
};

} // namespace hvi::lang
