// Pictures of a report: fields of the body, graphs of laws and kernels.
#pragma once

#include "lang/check/context.hpp"
#include "lang/check/laws.hpp"
#include "lang/check/memories.hpp"
#include "lang/check/output_fields.hpp"
#include "lang/check/results.hpp"

#include <optional>
#include <vector>

namespace hvi::lang {

class Pictures {
public:
  Pictures(const Context& context, Memories& memories, Laws& laws, Results& results,
           OutputFields& fields)
      : mistakes_(context.mistakes), names_(context.names), model_(context.model),
        unknowns_(context.unknowns), evaluator_(context.evaluator), memories_(memories),
        laws_(laws), results_(results), fields_(fields) {}

  /// A field of the body; of several fields, or times, one picture beside the other.
  void read(const ast::PictureItem& item);

private:
  bool is_graph(const ast::Expr& e) const;
  bool graph(const ast::Expr& e, solver::GraphsSpec& out);
  void graphs(const ast::PictureItem& item);
  bool picture_times(const ast::PictureItem& item, std::vector<std::optional<double>>& out);
  bool picture_factor(const ast::PictureItem& item, double& out);
  bool is_inside_cells(const solver::FieldSpec& field) const;

  Mistakes& mistakes_;
  const Names& names_;
  Model& model_;
  const Unknowns& unknowns_;
  Evaluator& evaluator_;
  Memories& memories_;
  Laws& laws_;
  Results& results_;
  OutputFields& fields_;
};

} // namespace hvi::lang
