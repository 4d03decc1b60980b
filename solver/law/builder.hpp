// Builds the graph of a law at a point: breaks, pieces, limits. Internal to solver/law.
#pragma once

#include "solver/law/law.hpp"
#include "solver/law/roots.hpp"
#include "solver/law/smooth.hpp"
#include "solver/law/switches.hpp"

#include <deque>
#include <map>
#include <mutex>

namespace hvi::solver {

class GraphBuilder {
public:
  explicit GraphBuilder(const LawSpec& spec);

  LawGraph build(const Point& x, LawTime t) const;
  const SmoothFunction& function(int id) const { return functions_[id]; }

private:
  struct Cell {
    double low, high, sample;
    int function;
  };
  std::vector<double> candidates(const Point& x, LawTime t) const;
  std::vector<double> without_doubles(const std::vector<double>& sorted, const Point& x,
                                      LawTime t) const;
  void add_roots(int i, const Signature& prefix, const Point& x, LawTime t, double low, double high,
                 std::vector<double>& roots) const;
  const RootFinder& finder(int i, const Signature& prefix) const;
  bool is_live(int i, Signature signature) const;
  Signature signature_at(double r, const Point& x, LawTime t, std::size_t n) const;
  int function_for(const Signature& signature) const;
  Cell cell_at(double low, double high, const Point& x, LawTime t) const;
  bool singular_at(double r, const Point& x, LawTime t) const;
  void merge(std::vector<Cell>& cells, const Point& x, LawTime t) const;
  void set_limits(LawGraph& graph) const;
  double value_beside(const Expr& e, double direct, double at, double inner, const Point& x,
                      LawTime t) const;
  double slope_at_origin(const LawGraph& graph, double inner) const;
  void check_number(double value, const char* of, double at, const LawGraph& graph) const;
  void close_rounding_gaps(LawGraph& graph) const;
  void set_offsets(LawGraph& graph) const;
  void check_potential(const LawGraph& graph) const;
  double limit(int function, double at, double inner, const Point& x, LawTime t) const;

  const LawSpec& spec_;
  Expr expression_;
  std::vector<Switch> switches_;
  PointTape values_; ///< of all switch functions
  // Found on demand, once per combination of sides; the lock makes graph() safe to call anywhere.
  mutable std::recursive_mutex lock_;
  mutable std::map<std::pair<int, Signature>, RootFinder> finders_;
  mutable std::map<std::pair<int, Signature>, bool> live_;
  mutable std::map<Signature, int> by_signature_;
  mutable std::deque<SmoothFunction> functions_;
};

/// Potential of a piece relative to its centre (a law by potential that is no polynomial: itself).
double primitive(const LawSpec& spec, const SmoothFunction& function, const LawGraph& graph,
                 int piece, double r);

} // namespace hvi::solver
