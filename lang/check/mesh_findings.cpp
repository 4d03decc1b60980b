// What is said of a mesh that was read from a file; see mesh_findings.hpp.
#include "lang/check/mesh_findings.hpp"

#include "solver/common/joined.hpp"
#include "solver/mesh/inspect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::lang {

namespace {

using solver::Group;
using solver::Mesh;
using solver::Piece;

constexpr std::size_t most_named = 6; ///< pieces and groups in one message

std::string place(const solver::Point& x, int dim) {
  std::string out = fmt::format("{:.6g}", x[0]);
  for (int a = 1; a < dim; ++a) out += fmt::format(", {:.6g}", x[a]);
  return "(" + out + ")";
}

const char* measure_word(int dim) { return dim == 1 ? "length" : dim == 2 ? "area" : "volume"; }

std::string counted(std::size_t n, const char* one, const char* many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

std::string named(const std::vector<std::string>& groups) {
  if (groups.empty()) return "";
  std::vector<std::string> first(
      groups.begin(),
      groups.begin() + static_cast<std::ptrdiff_t>(std::min(most_named, groups.size())));
  return fmt::format(" (groups: {}{})", solver::joined(first),
                     groups.size() > most_named ? ", ..." : "");
}

constexpr const char* to_merge =
    "gmsh merges nodes with `Coherence Mesh;` (gmsh.model.mesh.removeDuplicateNodes), parts that "
    "are to share their interface with BooleanFragments; a crack that is meant can stay";

} // namespace

std::vector<MeshFinding> straightened_cells(const Mesh& mesh, const solver::Straightening& lost) {
  if (lost.curved == 0) return {};
  const int dim = mesh.dim;
  double measure = 0.0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    measure += solver::cell_measure(mesh, static_cast<int>(c));
  const std::string change = dim == 1
                                 ? ""
                                 : fmt::format("; the {} changes by {:+.2g} %", measure_word(dim),
                                               100.0 * lost.gain / (measure - lost.gain));
  return {{"W0602",
           fmt::format("the cells of second order become straight: {} of {} edges have their "
                       "middle node elsewhere, by up to {:.3g} at {}, and up to {:.2g} % of an "
                       "edge{}",
                       lost.curved, lost.edges, lost.offset, place(lost.at, dim),
                       100.0 * lost.relative, change),
           "more cells follow a curved boundary better; P2 has its own nodes on straight edges"}};
}

std::vector<MeshFinding> misfits(const Mesh& mesh) {
  std::vector<MeshFinding> out;
  if (const auto seam = solver::find_seam(mesh)) {
    std::string what;
    if (seam->doubled > 0)
      what = fmt::format("{} where another node is already",
                         seam->doubled == 1 ? "a node stands"
                                            : fmt::format("{} nodes stand", seam->doubled));
    if (seam->hanging > 0)
      what += fmt::format("{}{} inside a side of a cell", what.empty() ? "" : ", and ",
                          seam->hanging == 1 ? "a node lies"
                                             : fmt::format("{} nodes lie", seam->hanging));
    out.push_back({"W0603",
                   fmt::format("the body is open at {}{}: {}, and no cell joins them",
                               place(seam->at, mesh.dim), named(seam->groups), what),
                   to_merge});
  }
  if (const auto overlap = solver::find_overlap(mesh))
    out.push_back({"W0604",
                   fmt::format("cells overlap: {} of the boundary reach into others, by up to "
                               "{:.3g} at {}",
                               overlap->cells, overlap->depth, place(overlap->at, mesh.dim)),
                   "where cells overlap the body is there twice, with twice the stiffness and the "
                   "load; BooleanFragments or BooleanUnion makes one body of two"});
  return out;
}

std::string describe_piece(const Piece& piece, int dim) {
  return fmt::format("{} of {} {:.4g} around {}", counted(piece.cells, "cell", "cells"),
                     measure_word(dim), piece.measure, place(piece.at, dim));
}

MeshFinding pieces(const std::vector<Piece>& all, const std::vector<std::string>& held, int dim) {
  std::string text = fmt::format("the body is in {} pieces that share no facet", all.size());
  for (std::size_t p = 0; p < std::min(all.size(), most_named); ++p)
    text += fmt::format("{} {}{}", p == 0 ? ":" : ";", describe_piece(all[p], dim),
                        held.empty() ? "" : ", " + held[p]);
  if (all.size() > most_named) text += fmt::format("; and {} more", all.size() - most_named);
  return {"W0605", text,
          "pieces that touch act on each other only where they share the nodes of a facet"};
}

} // namespace hvi::lang
