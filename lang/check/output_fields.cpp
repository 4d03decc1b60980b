#include "lang/check/output_fields.hpp"

#include "lang/check/across.hpp"
#include "lang/check/pairs.hpp"
#include "lang/check/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

/// Files are named by fields, and no system has names of more than 255 letters for them.
constexpr std::size_t longest_name = 100;

const char* word_of(ast::BinaryOp op) {
  switch (op) {
  case ast::BinaryOp::add:
    return "plus";
  case ast::BinaryOp::subtract:
    return "minus";
  case ast::BinaryOp::multiply:
    return "times";
  case ast::BinaryOp::divide:
    return "over";
  case ast::BinaryOp::contract:
    return "with";
  case ast::BinaryOp::power:
    return "to";
  }
  return "";
}

} // namespace

/// Is it a number, or a vector or a matrix of the space (reported elsewhere where there is none)?
bool OutputFields::fits(const Field& f) const {
  if (f.rank == 0 || model_.dim == 0) return true;
  if (f.rank == 1) return f.rows == model_.dim;
  return f.rows == f.columns && (f.rows == model_.dim || f.rows == tensor_dim(model_));
}

std::optional<solver::FieldSpec> OutputFields::output_field(const ast::Expr& e) {
  Scope scope = report_scope();
  auto f = evaluator_.field(e, scope);
  if (!f) return std::nullopt;
  for (const Symbol& c : f->components)
    if (has_jumps(c) || c.depends_on(slot::gap)) {
      mistakes_.error(
          "E0441", e.span, "a jump or a gap is written at points, not as a field",
          "probe it (`jump(u).nu at [..]`) or integrate it; `layer.xi` of a law on the pair is a "
          "field");
      return std::nullopt;
    }
  if (f->rank > 2 || f->law_vector) {
    mistakes_.error("E0306", e.span, fmt::format("{} cannot be written as a field", describe(*f)));
    return std::nullopt;
  }
  if (!fits(*f)) {
    mistakes_.error("E0306", e.span,
                    fmt::format("{} cannot be written as a field in {}D", describe(*f), model_.dim),
                    "write a part of it, `norm(..)` or `dot(.., [1, 0, 0])`; a law of `eps(u)` has "
                    "a matrix as its multiplier");
    return std::nullopt;
  }
  for (const Symbol& c : f->components)
    if (has_probes(c)) {
      mistakes_.error("E0306", e.span, "an integral is a number, not a field",
                      "put it into a `table`");
      return std::nullopt;
    }
  solver::FieldSpec spec;
  spec.origin = model_.origin(e.span);
  spec.components = f->components;
  spec.across = entries_across_plane(*f);
  spec.name = name_of(e, f->components);
  return spec;
}

/// A name for files and arrays: u, layer.xi, u_rate, mises_sigma, 2_times_u. What is another field
/// gets another one: max_u.x_2.
std::string OutputFields::name_of(const ast::Expr& e, const std::vector<Symbol>& components) {
  std::function<std::string(const ast::Expr&)> name = [&](const ast::Expr& part) -> std::string {
    if (const auto* r = std::get_if<ast::Reference>(&part.node)) return r->name;
    if (const auto* m = std::get_if<ast::Member>(&part.node))
      return name(*m->object) + "." + m->member.text;
    if (const auto* p = std::get_if<ast::Prime>(&part.node)) {
      const auto* inner = std::get_if<ast::Prime>(&p->operand->node);
      return inner ? name(*inner->operand) + "_acceleration" : name(*p->operand) + "_rate";
    }
    if (const auto* c = std::get_if<ast::Call>(&part.node))
      return c->arguments.empty() ? name(*c->callee)
                                  : name(*c->callee) + "_" + name(c->arguments[0].value);
    if (const auto* n = std::get_if<ast::Number>(&part.node)) return fmt::format("{}", n->value);
    if (const auto* q = std::get_if<ast::Quantity>(&part.node)) return name(*q->value);
    if (const auto* n = std::get_if<ast::Negate>(&part.node)) return "minus_" + name(*n->operand);
    if (const auto* b = std::get_if<ast::Binary>(&part.node))
      return fmt::format("{}_{}_{}", name(*b->left), word_of(b->op), name(*b->right));
    if (const auto* l = std::get_if<ast::List>(&part.node)) {
      std::string out;
      for (const ast::Expr& item : l->items) out += (out.empty() ? "" : "_") + name(item);
      return out;
    }
    return "field"; // cases, which have no short name
  };
  const std::string first = name(e).substr(0, longest_name);
  std::string out = first;
  for (int k = 2;; ++k) {
    const auto known = std::ranges::find(named_, out, [](const auto& one) { return one.first; });
    if (known == named_.end()) return named_.emplace_back(out, components).first;
    if (known->second == components) return out;
    out = fmt::format("{}_{}", first, k);
  }
}

/// Other fields have other names.
bool OutputFields::is_new(const solver::FieldSpec& field,
                          const std::vector<solver::FieldSpec>& before) {
  const auto same = std::ranges::find(before, field.name, &solver::FieldSpec::name);
  if (same == before.end()) return true;
  const auto place = [&](const solver::FieldSpec& of) {
    return model_.origins[static_cast<std::size_t>(of.origin.id)];
  };
  mistakes_.add(diagnose("E0302", place(field), fmt::format("`{}` is there twice", field.name))
                    .with_secondary(place(*same), "the first one"));
  return false;
}

void OutputFields::read(const ast::FieldsItem& item) {
  solver::FieldsSpec spec;
  spec.origin = model_.origin(item.span);
  if (item.every)
    if (auto n = evaluator_.positive_integer(*item.every, "`every`")) spec.every = *n;
  spec.from_start = results_.from_start(item.from_start);
  auto file = results_.fields_name(item.to);
  for (const ast::Expr& e : item.fields)
    if (auto f = output_field(e); f && is_new(*f, spec.fields))
      spec.fields.push_back(std::move(*f));
  if (!file) return;
  spec.file = *file;
  model_.report.fields.push_back(std::move(spec));
}

std::optional<solver::FieldSpec> OutputFields::drawn_field(const ast::Expr& e,
                                                           const std::string& what) {
  auto f = output_field(e);
  if (!f) return std::nullopt;
  const auto on_facets = [&](solver::Slot s) {
    if (!slot::is_state(s)) return slot::is_multiplier(s);
    const auto& state = model_.states[static_cast<std::size_t>(s - slot::first_state)];
    return model_.parts[static_cast<std::size_t>(state.spec.part)].kind !=
           solver::Group::Kind::cells;
  };
  for (const Symbol& component : f->components)
    if (std::ranges::any_of(component.slots(), on_facets)) {
      mistakes_.error("E0306", e.span,
                      fmt::format("`{}` lives at the points of a law: {} shows what every point of "
                                  "the body has",
                                  f->name, what),
                      "write it with `fields` and open the VTU file");
      return std::nullopt;
    }
  return f;
}

} // namespace hvi::lang
