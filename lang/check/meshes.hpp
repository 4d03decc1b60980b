// The mesh that a script declares: which one is meant, with what sizes, put together of which
// pieces.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/mesh_groups.hpp"
#include "solver/mesh/geo_constants.hpp"

#include <span>
#include <string>
#include <vector>

namespace hvi::lang {

/// What the arguments of `rectangle`, `gmsh`, `disk`, ... are called, in their order; none: there
/// is no such mesh.
std::vector<std::string> mesh_arguments(const std::string& name);

class Meshes {
public:
  Meshes(const Context& context, MeshGroups& groups)
      : options_(context.options), mistakes_(context.mistakes), names_(context.names),
        model_(context.model), evaluator_(context.evaluator), groups_(groups) {}

  Value mesh(const ast::Mesh& mesh);
  /// A script has one mesh.
  void report_second(const Span& span);

private:
  bool mesh_of_call(const ast::Mesh& mesh, const ast::Call& call, const std::string& callee);
  bool coordinates(const ast::Expr* written, int dim, const std::string& what,
                   const std::string& wrong, solver::Point& out);
  bool move_to(const ast::Expr* written, int dim, solver::Point& at);
  bool adapted_cells(const ast::Expr* written, solver::MeshSpec& spec);
  bool axisymmetric(const ast::Expr* written, int dim, solver::MeshSpec& spec);
  bool box_of_mesh(std::span<const ast::Expr* const> sizes, const ast::Expr* origin,
                   const ast::Expr* at, solver::MeshSpec& spec);
  bool cells_of_mesh(const ast::Expr& cells, const ast::Expr* pattern, int dim,
                     solver::MeshSpec& spec);
  bool grading_of_mesh(const ast::Expr* written, int dim, solver::MeshSpec& spec);
  bool structured_mesh(const ast::Mesh& mesh, const ast::Call& call, const std::string& name);
  bool constants_of_geometry(ast::Call& call, const std::vector<std::string>& names,
                             solver::GeoConstants& out);
  bool file_mesh(const ast::Mesh& m, const ast::Call& written);
  bool split_along(const ast::Expr* written, solver::MeshSpec& spec);
  bool geometry_mesh(const ast::Mesh& mesh, const ast::Call& call, const std::string& name);
  Value mesh_of_pieces(const ast::Mesh& mesh);
  bool add_piece(const ast::Expr& name);
  bool fits(const solver::MeshSpec& before, int dim_before, const Span& span);

  const CheckOptions& options_;
  Mistakes& mistakes_;
  Names& names_;
  Model& model_;
  Evaluator& evaluator_;
  MeshGroups& groups_;
  bool making_pieces_ = false;
};

} // namespace hvi::lang
