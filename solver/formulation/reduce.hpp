// Can the states of a run hold the contact unknowns only, and the change to them (interior.hpp).
#pragma once

#include "solver/formulation/formulation.hpp"
#include "solver/formulation/interior.hpp"
#include "solver/plan/plan.hpp"

#include <span>
#include <string>

namespace hvi::solver {

/// The first condition that fails, as a sentence; empty: states hold the contact unknowns only. The
/// conditions: one base matrix, symmetric; laws on few of the unknowns; loads that separate in
/// time; zero boundary values; no report that reads the interior at more than an eighth of the
/// steps.
std::string proportional_obstacle(const Plan& plan, const Operators& operators,
                                  const Contact& contact, const LoadAssembler& loads,
                                  const StateLayout& layout);

/// Does a probe read the fields at more than single points? (Multipliers live on contact points.)
bool reads_interior(const Probe& probe, int n_fields);

/// The problem for y = [contact unknowns; modes]; its initial state becomes a mode of `interior`,
/// as its loads have done (`of_loads`: what add_mode gave), and the parts that stay are taken from
/// `all`.
DiscreteProblem on_contact_unknowns(DiscreteProblem all, Interior& interior,
                                    std::span<const Vector> of_loads);

/// Steps, drawn at random, at which the equilibrium of all rows is computed in any case: with the
/// last one and the field that is read after it they fill one pack of eight numbers.
inline constexpr int random_checks = 6;

/// Steps at which the equilibrium of all rows is computed: where the report reads whole fields, the
/// last one, and `random_checks` more.
std::vector<char> checked_steps(const Plan& plan, int steps);

} // namespace hvi::solver
