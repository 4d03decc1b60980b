// The laws of a plan as the reduced problem of one step.
//
// Law term l has points p with arguments z_p = G_p w + offset_p(t), w the field that it acts on: u,
// or u'. In the increment form of a step, u_n = u_known + d (u_known: u_{n-1} with the values
// imposed at t_n), w = w_known + s d (evolution.hpp), and the reduced problem is stated for c = d
// on the contact unknowns:  z = s G_c c + (G w_known + offset(t_n)),  s = 1 for u.
//
// States live at the points of a law of their part (contact_states.hpp); laws and offsets that read
// them are those of `state_values`.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/law_readings.hpp"
#include "solver/discrete/state.hpp"
#include "solver/inequality/inequality.hpp"
#include "solver/linear/basis_change.hpp"
#include "solver/linear/pieces.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace hvi::solver {

/// One law term: its points, and where its rows stand in xi.
struct ContactTerm {
  LawPoints points;
  int field = field_of_u(0);
  int first_point = 0, first_row = 0;
  int coupled_row = -1; ///< first row of the term whose multiplier this one's law reads; -1: none
  std::vector<int> first_states{}; ///< of the states that its law reads: the first in state_values
  bool offset_of_states = false;
  Vector offsets; ///< scratch of `prepare`
  /// By point: those that see the same argument, itself among them. Empty: no two do.
  std::vector<std::vector<int>> alike{};
  std::vector<Readings> first_readings{}; ///< what its law reads at the initial time, by point
  /// Calls f(field, times) for what row `row` of a point sees.
  template <class F>
  void for_seen(int row, const F& f) const {
    if (points.seen.empty()) return f(field, 1.0);
    for (const SeenField& seen : points.seen[static_cast<std::size_t>(row)])
      f(seen.field, seen.times);
  }
  /// Do rows of a point move with different factors?
  bool mixed() const {
    return std::ranges::any_of(points.seen,
                               [&](const auto& row) { return row != points.seen.front(); });
  }
  int n_points() const { return static_cast<int>(points.x.size()); }
  int n_rows() const { return n_points() * points.rows; }
};

/// The points of a body where states live, as those of a law that does nothing there.
struct BodyPoints {
  LawTerm term;
  LawPoints points;
};

/// The states of one part, and what their rates read at their points: those of a law term there, or
/// points inside the cells. Input j of point p has the number first_input + j n_points + p: first
/// values of fields, then multipliers.
struct StateGroup {
  int part = 0;
  int host = -1;                          ///< the term at whose points they live; -1: in a body
  std::shared_ptr<const BodyPoints> body; ///< null: not in a body
  std::vector<int> states;                ///< of the plan
  std::vector<Slot> fields, multipliers;
  int first_input = 0, n_points = 0;
  int n_inputs() const { return static_cast<int>(fields.size() + multipliers.size()) * n_points; }
};

/// What laws do to the rows of the matrix: force xi.
struct Reactions {
  const SparseMatrix& force;
  std::span<const std::uint8_t> of_unknown; ///< see Contact
};

struct Contact {
  std::vector<std::unique_ptr<Law>> laws;
  std::vector<ContactTerm> terms;
  ReducedProblem problem;        ///< g on `unknowns`; offset and graphs set by `prepare`
  std::vector<double> scales;    ///< slope scale of each law
  std::vector<double> softening; ///< steepest descent of each law's slope
  std::vector<int> unknowns;     ///< the contact unknowns, increasing
  /// They are some of the x of a change u = T x (pair_unknowns.hpp); null: of the u themselves.
  std::shared_ptr<const BasisChange> change{};
  std::vector<int> loaded{}; ///< the u that laws see; without a change those of `unknowns`
  /// By unknown of the matrix: of which of several unknowns it is; empty: there is one.
  std::vector<std::uint8_t> of_unknown;
  std::size_t unknown_of(int i) const {
    return of_unknown.empty() ? 0 : of_unknown[static_cast<std::size_t>(i)];
  }
  bool whole = false;   ///< every unknown is kept: no Schur complement is formed
  SparseMatrix g;       ///< all rows x state
  SparseMatrix force;   ///< unknowns x all rows: G^T W
  bool mixed = false;   ///< of a term: then a step's laws have no potential
  bool coupled = false; ///< a law's bound is another law's multiplier: `prepare` reads xi
  std::vector<LawReadings> readings; ///< of the terms whose laws read the solution
  Vector offset;                     ///< of the argument at the time of the last `prepare`
  Vector reach; ///< of states, 0 but on `unknowns`: a displacement each (find_reach)
  /// Of several unknowns each, at least: where one went back to zero its values are rounding of its
  /// largest ones.
  ByUnknown least_reach{};
  std::vector<int> other_fields; ///< that laws act on, or read, besides u
  std::vector<StateGroup> state_groups;
  std::vector<int> first_state;  ///< of each state of the plan in state_values; -1: no group has it
  Vector state_values;           ///< at the points, which `prepare` reads
  std::vector<int> state_fields; ///< that rates read besides u
  /// Inputs of rates that are values of fields: all of them x state, and x unknowns.
  SparseMatrix trace, trace_c;
  SparseMatrix body_trace; ///< the same of states in bodies, which make no unknown one of contact

  int n_rows() const { return static_cast<int>(g.rows()); }
  bool none() const { return terms.empty(); }
  Reactions reactions() const { return {force, of_unknown}; }
};

/// Where the states of a group live.
const LawPoints& points_of(const Contact& contact, const StateGroup& group);

/// Laws whose points touch most unknowns (or very many) are not condensed: a dense Schur complement
/// would cost more than the sparse matrix itself.
/// `keep_all`: nothing is condensed in any case.
Contact make_contact(const Problem& problem, const Discretisation& discretisation,
                     const StateLayout& layout, bool keep_all = false);

/// Which unknowns are the contact unknowns of rows and points, and what these are on them.
void find_unknowns(const Problem& problem, const Space& space, const StateLayout& layout,
                   Contact& contact, bool keep_all);

/// From now on the contact unknowns are some of the x, u = T x. `problem` as for make_contact.
void change_unknowns(const Problem& problem, const Space& space, const StateLayout& layout,
                     std::shared_ptr<const BasisChange> change, Contact& contact);

/// c = the contact unknowns of d.
void contact_part(const Contact& contact, const Vector& d, Vector& c);

/// d = 0 where no chain of entries of K leads to from a load or a multiplier: a body that nothing
/// moves is at rest exactly. What a factor of T^T K T leaves there is rounding of the body that T
/// joins it with, however small. `k` has to hold all bodies. False: there is nothing at rest.
bool put_at_rest(const SparseMatrix& k, const Contact& contact, const Vector& rhs, const Vector& xi,
                 Vector& d);
/// The same by the pieces of K.
void put_at_rest(const Pieces& pieces, const Contact& contact, const Vector& rhs, const Vector& xi,
                 Vector& d);

/// What laws read is read in these fields and multipliers of the time t: `prepare` makes their
/// graphs of it.
void read_solution(Contact& contact, double t, const LawFields& fields, const Vector& xi);

/// Sets offset, graphs of laws that change in time or with states, and the reduced problem's known
/// part. `xi`: the multipliers that coupled laws read. `moved`: an increment that `known` has
/// already, whose size is in that of the arguments, too, where the two cancel.
void prepare(Contact& contact, const Problem& problem, double t, const LawFields& known,
             const Vector& xi, const Vector* moved = nullptr);

/// Offsets of a term's arguments at time t with these states.
void offsets_of(const Contact& contact, const Problem& problem, const ContactTerm& term, double t,
                const Vector& states, Vector& out);
/// z += G w, w the field of each law.
void add_arguments(const Contact& contact, const LawFields& fields, Vector& z);
/// The arguments of all laws of a state at time t.
void arguments_of(const Contact& contact, const Problem& problem, double t, const LawFields& fields,
                  Vector& z);

/// The factors s of the rows of every law term, as many each as laws have arguments at most, from
/// those of the fields; empty where all laws act on u.
std::vector<double> law_factors(const Contact& contact, const Vector& of_fields);

/// Multiplier of point p of a term in the global frame (scalar laws: component 0); the mean of
/// points that are alike.
std::array<double, slot::most_arguments> global_multiplier(const ContactTerm& term,
                                                           const Vector& xi, int point);

} // namespace hvi::solver
