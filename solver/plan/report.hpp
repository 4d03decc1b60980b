// What is asked of a solution: values, tables, field files, pictures.
#pragma once

#include "solver/plan/problem.hpp"

#include <variant>

namespace hvi::solver {

/// An expression of position, t, normal, fields (slot::field) and multipliers (slot::multiplier).
struct Probe {
  enum class Kind { at_point, integral, norm_v, combination, largest, smallest, reaction };
  std::string name;
  Origin origin;
  Kind kind = Kind::at_point;
  Expr expression;      ///< norm_v: unused, the norm of an unknown in its space; combination: of
                        ///< slot::probe, slot::t
  Point point{};        ///< at_point
  bool on_pair = false; ///< at_point: values of fields are jumps, at a point of a pair
  /// integral, largest, smallest, reaction; on_pair: of this pair, or of the one with the point;
  /// else at_point: the cell is one of this part, or any.
  int part = -1;
  Rule rule = Rule::exact;    ///< integral; with a multiplier, the law's own rule
  std::optional<double> time; ///< the value at this time, by the interpolant
  int unknown = 0;            ///< norm_v, reaction: of which one
  int component = 0;          ///< reaction: of the unknown's
  bool may_be_free = false;   ///< reaction: laws that hold the part were left out
  std::string unit{};         ///< "MPa", "1"; told beside the values; "": nobody knows
};

struct TableSpec {
  Origin origin;
  std::vector<int> probes;
  int every = 1;
  bool from_start = false; ///< the first row is that of the initial time
  std::string file;        ///< "" : the default
};

/// A field written to VTU. One component: scalar; dim: vector; dim*dim (axisymmetric: 9): tensor.
/// Nodal fields depend on values of u only; others are cell averages; a multiplier lives on the
/// contact part's nodes.
struct FieldSpec {
  std::string name;
  Origin origin;
  std::vector<Expr> components;
  std::string unit{}; ///< as of a probe
  /// Of a 2 x 2 matrix in plane strain: zz, xz, yz, which files have; empty: not known.
  std::vector<Expr> across{};
};
/// visit(entry) for all entries of a field, those that only its files have, too.
template <class Visit>
void for_each_entry(FieldSpec& field, const Visit& visit) {
  for (Expr& entry : field.components) visit(entry);
  for (Expr& entry : field.across) visit(entry);
}

struct FieldsSpec {
  Origin origin;
  std::vector<FieldSpec> fields;
  int every = 1;
  bool from_start = false; ///< the first files are those of the initial time
  std::string file;
};
struct PictureSpec {
  Origin origin;
  FieldSpec field;
  std::optional<double> time;
  std::string file;
  double deformed = 0.0; ///< so many times the displacement is added to the places
  /// So many pictures, this one and those behind it, stand side by side in its file; 0: it stands
  /// beside one before; -1: no picture is drawn, its values at the nodes are asked for.
  int in_row = 1;
};
/// Expressions at places of equal distances on a segment, at the last step or at a time.
struct LineSpec {
  Origin origin;
  std::vector<FieldSpec> fields;
  Point from{}, to{};
  int points = 2;
  std::optional<double> time;
  std::string file;
};
/// Columns of the tables against another one, or against t.
struct PlotSpec {
  Origin origin;
  std::vector<std::string> columns;
  std::string against;
  std::string file;
};

/// A law or a kernel as a graph; nothing of it is computed.
struct GraphSpec {
  std::string name;
  std::variant<LawSpec, KernelSpec> of;
};
/// Graphs side by side.
struct GraphsSpec {
  Origin origin;
  std::vector<GraphSpec> graphs;
  std::string file;
};

struct ReportSpec {
  std::vector<Probe> probes;
  std::vector<TableSpec> tables;
  std::vector<FieldsSpec> fields;
  std::vector<PictureSpec> pictures;
  std::vector<LineSpec> lines;
  std::vector<PlotSpec> plots;
  std::vector<GraphsSpec> graphs;
  std::string unit_of_time{}, unit_of_length{}, unit_of_energy{};
};

} // namespace hvi::solver
