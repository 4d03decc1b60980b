// A body that neither forms nor imposed values hold, but laws: which loads do they balance?
//
// Rigid motions v that K and K^T take to 0 see nothing of the body's stiffness: with N a basis of
// them, every solution of a step, K d + G^T W xi = r, has
//
//   N^T r = sum_p w_p (G_p N)^T xi_p,      xi_p in dj_p(z_p).                                  (*)
//
// That asks for K^T N = 0 alone. Where K N = 0 and K^T N is not (an unknown that another one
// drives, and that drives none) laws have to hold N as well, but what they balance there is a load
// that the solution is a part of: of it nothing is known beforehand.
//
// Let Xi_p be the values that law p's subgradients lie between (an interval, a ball; a cone for
// Coulomb's friction with its pressure) and C the convex set of the right sides of (*) with them.
// Outside C there is no solution, and a v with  <r, v> > sup { <c, v> : c in C }  is a motion that
// nothing stops. For convex laws that supremum is the recession function J_inf(M v) of J, and
// r inside C is the condition <f, v> < J_inf(M v) for all v != 0 under which the problem has a
// solution (C. Baiocchi, F. Gastaldi, F. Tomarelli, Some existence results on noncoercive
// variational inequalities, Ann. Sc. Norm. Super. Pisa 13 (1986) 617-659, after Fichera, Lions and
// Stampacchia).
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/discrete/rigid_motions.hpp"

#include <memory>
#include <optional>
#include <string>

namespace hvi::solver {

/// The motions N of a matrix K; null: K holds the body.
struct FreeBody {
  /// Those of one unknown.
  struct Part {
    RigidMotions motions;
    DenseMatrix on_unknowns; ///< of those that K does not see, a column each
    DenseMatrix chosen;      ///< such a column as a combination of all motions
    bool balances = true;    ///< K^T does not see them either: (*) holds
    std::string describe(const Vector& combination) const {
      return motions.describe(chosen * combination);
    }
  };
  std::vector<Part> parts; ///< of unknowns that have any
  DenseMatrix on_unknowns; ///< of all parts
  std::string describe(const Vector& combination) const;
};

/// What K leaves free of these motions, of each unknown by itself; null: nothing.
std::shared_ptr<const FreeBody> find_free_body(std::span<const RigidMotions> motions,
                                               const ForcesOfMotions& by_k,
                                               const StateLayout& layout);
std::shared_ptr<const FreeBody> find_free_body(std::span<const RigidMotions> motions,
                                               const SparseMatrix& k, const StateLayout& layout);

/// All of them, in words.
std::vector<std::string> free_motions(const FreeBody& body);

/// The motions of a free body that no law sees, in words: along them the laws' arguments stay.
std::vector<std::string> unseen_motions(const FreeBody& body, const Contact& contact);

/// Do laws whose slopes rise everywhere (springs) see all motions? With laws that do not soften a
/// step then has one solution.
bool held_strongly(const FreeBody& body, const Contact& contact);

/// Throws Failure(not_coercive) naming these motions, where there are any. `when`: "", or at what
/// time.
void refuse_free(const std::vector<std::string>& motions, const std::string& when,
                 const Origin& origin);

/// Throws Failure(not_coercive) naming the motion where no subgradients of the laws at hand
/// (`prepare` has made their graphs) balance the load r of a step at time t.
void refuse_unbalanced(const FreeBody& body, const Contact& contact, const Problem& problem,
                       const Vector& r, double t);

/// Of a step that found no solution: the motion by which the increment d goes astray.
std::string runaway(const FreeBody& body, const Vector& d);

/// How far the multipliers are from balancing the load on the free motions (*), by the sizes of the
/// forces: on rows of its own every force of a body far from where it was is small.
double balance_error(const FreeBody& body, const Contact& contact, const Vector& r,
                     const Vector& xi);

} // namespace hvi::solver
