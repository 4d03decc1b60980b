#include "lang/check/pictures.hpp"

#include "lang/check/tensor_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

std::vector<const ast::Expr*> shown_by(const ast::PictureItem& item) {
  std::vector<const ast::Expr*> out{&item.field};
  for (const ast::Expr& e : item.more) out.push_back(&e);
  return out;
}

} // namespace

/// Does this name a superpotential or a kernel?
bool Pictures::is_graph(const ast::Expr& e) const {
  const auto* name = std::get_if<ast::Reference>(&e.node);
  const int index = name ? names_.find(name->name) : -1;
  if (index < 0) return false;
  const ast::Statement& statement = *names_[index].statement;
  return std::holds_alternative<ast::Superpotential>(statement) ||
         std::holds_alternative<ast::Kernel>(statement);
}

namespace {

using Variables = std::function<double(solver::Slot)>;

/// Some times, of the run and before it, at which a kernel may be looked at.
std::vector<Variables> times_within(const std::vector<double>& grid) {
  std::vector<Variables> out;
  if (grid.empty()) return out;
  const double end = grid.back(), length = end - grid.front();
  for (const double share : {0.5, 0.25, 0.9})
    out.emplace_back([=](solver::Slot s) {
      return s == slot::lag ? share * length : s == slot::t ? end : 0.0;
    });
  return out;
}

/// A factor of time with the sign of the kernel that it is of: memories of K and -K are one. Of a
/// tensor the first entry that is not zero tells.
Symbol as_declared(const Symbol& factor, const Field& kernel, const std::vector<Variables>& times) {
  const auto first =
      std::ranges::find_if(kernel.components, [](const Symbol& c) { return !c.is(0.0); });
  if (first == kernel.components.end()) return factor;
  for (const Variables& at : times) {
    const double both = solver::evaluate(*first, at) * solver::evaluate(factor, at);
    if (std::isfinite(both) && both != 0.0) return both < 0.0 ? -factor : factor;
  }
  return factor;
}

/// A number that changes in time alone is drawn itself; memories know its factor of time only.
bool is_of_time(const Field& kernel) {
  return kernel.rank == 0 && std::ranges::all_of(kernel.components[0].slots(), [](solver::Slot s) {
           return s == slot::t || s == slot::lag;
         });
}

} // namespace

/// One graph of a picture: a law of the inequality, or the kernel of a memory.
bool Pictures::graph(const ast::Expr& e, solver::GraphsSpec& out) {
  const std::string& name = std::get<ast::Reference>(e.node).name;
  const int declaration = names_.find(name);
  const auto& statement = *names_[declaration].statement;
  bool found = false;
  if (std::holds_alternative<ast::Superpotential>(statement)) {
    for (const bool of_vector : {false, true})
      if (const auto law = laws_.made(declaration, of_vector)) {
        out.graphs.push_back({name, model_.laws[static_cast<std::size_t>(*law)].spec});
        found = true;
      }
    if (!found && !model_.lacks_terms)
      mistakes_.error("E0450", e.span,
                      fmt::format("no term of the inequality has the law `{}`", name),
                      "a picture shows laws that act, with the values that they have there");
    return found;
  }
  for (const ModelHistory& history : model_.histories)
    if (history.name == name || std::ranges::find(history.also, name) != history.also.end()) {
      const auto declared = memories_.kernel_field(e, Scope{});
      const bool itself = declared && is_of_time(*declared);
      const auto times = times_within(model_.time.grid);
      const Symbol drawn = itself     ? declared->components[0]
                           : declared ? as_declared(history.kernel, *declared, times)
                                      : history.kernel;
      const std::string tensor =
          declared && !itself ? tensor_beside(*declared, drawn, times) : std::string();
      out.graphs.push_back(
          {name,
           solver::KernelSpec{itself ? name : tensor, model_.origin(history.span), drawn, {}}});
      found = true;
    }
  if (!found && !model_.lacks_terms)
    mistakes_.error("E0450", e.span,
                    fmt::format("no memory of the inequality has the kernel `{}`", name),
                    "a picture shows kernels that act");
  return found;
}

/// `picture layer, slip, C`: graphs of laws and kernels beside each other.
void Pictures::graphs(const ast::PictureItem& item) {
  solver::GraphsSpec spec;
  spec.origin = model_.origin(item.span);
  auto file = results_.picture_name(item.to);
  bool good = file.has_value();
  std::set<std::string> drawn;
  for (const ast::Expr* e : shown_by(item)) {
    if (!is_graph(*e)) {
      mistakes_.error("E0450", e->span,
                      "a field of the body does not stand beside a law or a kernel",
                      "laws and kernels have a picture, fields another one");
      good = false;
    } else if (!drawn.insert(std::get<ast::Reference>(e->node).name).second) {
      mistakes_.error("E0302", e->span,
                      fmt::format("`{}` is there twice", std::get<ast::Reference>(e->node).name));
      good = false;
    } else {
      good = graph(*e, spec) && good;
    }
  }
  const auto no_use = [&](const std::optional<ast::Expr>& word, const char* what) {
    if (word) mistakes_.error("E0450", word->span, fmt::format("{} of a law or a kernel", what));
    good = good && !word;
  };
  no_use(item.deformed, "a deformation");
  no_use(item.time, "a time");
  if (item.to && item.to->text.ends_with(".apng")) {
    mistakes_.error("E0412", item.to->span, "a graph does not move",
                    "a picture that stands still is a `.png` or an `.svg`");
    good = false;
  }
  if (!good) return;
  spec.file = *file;
  model_.report.graphs.push_back(std::move(spec));
}

/// `at t = 0.5`, or `at t = [0.2, 0.5]` for one picture beside the other; none: the end.
bool Pictures::picture_times(const ast::PictureItem& item,
                             std::vector<std::optional<double>>& out) {
  out.clear();
  if (!item.time) {
    out.emplace_back();
    return true;
  }
  if (const auto* list = std::get_if<ast::List>(&item.time->node))
    for (const ast::Expr& e : list->items) out.push_back(results_.report_time(e));
  else
    out.push_back(results_.report_time(*item.time));
  return std::ranges::all_of(out, [](const auto& t) { return t.has_value(); });
}

bool Pictures::picture_factor(const ast::PictureItem& item, double& out) {
  if (!item.deformed) return true;
  const auto factor =
      evaluator_.constant(*item.deformed, "how many times the displacement is drawn");
  if (!factor) return false;
  if (!model_.space.vector || unknowns_.components_of(0) != model_.dim) {
    mistakes_.error("E0306", item.deformed->span,
                    fmt::format("`{}` is no displacement by which the body could be deformed",
                                model_.space.unknown),
                    "leave out `deformed`");
    return false;
  }
  out = *factor;
  return true;
}

/// Does the field read a multiplier whose points lie inside the cells, with nothing between them?
bool Pictures::is_inside_cells(const solver::FieldSpec& field) const {
  std::vector<char> inside; // by application of a law
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      const auto kind = model_.parts[static_cast<std::size_t>(term.part)].kind;
      inside.push_back(kind == solver::Group::Kind::cells &&
                       (use.sees_gradient() || term.rule != solver::Rule::nodal));
    }
  return std::ranges::any_of(field.components, [&](const Symbol& component) {
    return std::ranges::any_of(component.slots(), [&](solver::Slot s) {
      return slot::is_multiplier(s) && inside[static_cast<std::size_t>(slot::term_of(s))] != 0;
    });
  });
}

void Pictures::read(const ast::PictureItem& item) {
  const auto all = shown_by(item);
  if (std::ranges::any_of(all, [&](const ast::Expr* e) { return is_graph(*e); }))
    return graphs(item);
  const auto file = results_.picture_name(item.to);
  std::vector<std::optional<solver::FieldSpec>> fields;
  fields.reserve(all.size());
  std::vector<solver::FieldSpec> side_by_side;
  for (const ast::Expr* e : all) {
    fields.push_back(fields_.output_field(*e));
    const auto& field = fields.back();
    if (field && is_inside_cells(*field)) {
      mistakes_.error(
          "E0306", e->span,
          fmt::format("`{}` lives at points inside the cells, and no picture knows what "
                      "is between them",
                      field->name),
          "write it with `fields` and open the VTU file");
      return;
    }
    if (field && fields_.is_new(*field, side_by_side)) side_by_side.push_back(*field);
  }
  std::vector<std::optional<double>> times;
  double deformed = 0.0;
  const bool timely = picture_times(item, times);
  if (item.to && item.to->text.ends_with(".apng") &&
      (item.time || !model_.has_time || all.size() > 1)) {
    mistakes_.error("E0412", item.to->span,
                    item.time          ? "a picture at one time does not move"
                    : !model_.has_time ? "a static problem does not move"
                                       : "pictures side by side do not move",
                    "a picture that stands still is a `.png` or an `.svg`");
    return;
  }
  if (!picture_factor(item, deformed) || !timely || !file) return;
  if (!std::ranges::all_of(fields, [](const auto& f) { return f.has_value(); })) return;
  int in_row = static_cast<int>(fields.size() * times.size());
  for (const auto& f : fields)
    for (const auto& time : times)
      model_.report.pictures.push_back(
          {model_.origin(item.span), *f, time, *file, deformed, std::exchange(in_row, 0)});
}

} // namespace hvi::lang
