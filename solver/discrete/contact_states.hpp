// Where the states of a plan live: at the points of a law on their part, or inside a body
// (body_states.hpp).
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/discrete/discretisation.hpp"

namespace hvi::solver {

/// When a law is asked at each of its points before the first step: with the initial states, and
/// with what it reads then (empty: nothing, or it is not known). Throws Failure(bad_value) where a
/// state is not finite or outside its range.
std::vector<LawTime> initial_law_times(const Problem& problem, const Law& law,
                                       const LawPoints& points, double t,
                                       std::span<const Readings> first_readings = {});

/// Throws Failure(bad_value) where a state inside a body begins with what is no number, or outside
/// its range: before the forms that read it are made.
void check_initial_states(const Problem& problem, const Discretisation& discretisation);
/// Does its rate read nothing that a run finds?
bool is_of_place_and_time(const StateTerm& state);
/// Rates that read nothing that a run finds, and change in time: throws Failure(bad_value) as the
/// step of a run to time t does where one is no number.
void check_given_rates(const Problem& problem, const Contact& contact, double t);

/// Sets the groups of states with their initial values and the inputs of their rates. Throws
/// Failure(bad_value) where no law acts on the part of a state, where laws that read it or are read
/// by its rate have other points than the first one that does, or act elsewhere.
void add_states(const Problem& problem, const Discretisation& discretisation,
                const StateLayout& layout, Contact& contact);

} // namespace hvi::solver
