// Pairs: `part seam = pair(upper.bottom, lower.top)`, and what is known on one: jump(u), mean(u),
// gap(seam).
//
// A jump is kept as the value of a field of its own until it is known where it stands: on a pair it
// becomes the value of the field itself, which there is its jump (solver/plan/problem.hpp). A mean
// is kept as the slot slot::mean of that field.
#include "lang/check/checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::RegionSpec;

namespace {

constexpr int first_jump = 128; ///< the jump of field k is field first_jump + k
constexpr int jump_of_test = 252;

using slot::field_of, slot::is_field, slot::is_test;
bool is_jump(solver::Slot s) { return is_field(s) && field_of(s) >= first_jump; }

solver::Slot jump_of(solver::Slot s) {
  if (is_test(s)) return slot::field(jump_of_test, s - slot::test(0));
  return s + first_jump * slot::field_stride;
}
/// Of a value.
solver::Slot mean_of(solver::Slot s) {
  const int own = is_test(s) ? s - slot::test(0) : slot::derivative_of(s);
  const int component = slot::component_of(own);
  return jump_of(s) + slot::mean(component) - slot::value(component);
}
solver::Slot without_jump(solver::Slot s) {
  if (field_of(s) == jump_of_test) return slot::test(s - slot::field(jump_of_test, 0));
  return s - first_jump * slot::field_stride;
}

struct Reads {
  bool jumps = false, values = false, gap = false;
};

Reads reads_of(const std::vector<Symbol>& components) {
  Reads out;
  for (const Symbol& component : components)
    for (const solver::Slot s : solver::slots_of(component)) {
      out.gap = out.gap || s == slot::gap;
      if (!is_field(s) && !is_test(s)) continue;
      (is_jump(s) ? out.jumps : out.values) = true;
    }
  return out;
}

void remove_jumps(std::vector<Symbol>& components) {
  for (Symbol& component : components) {
    std::vector<std::pair<solver::Slot, Symbol>> rename;
    for (const solver::Slot s : solver::slots_of(component))
      if (is_jump(s)) rename.emplace_back(s, Symbol::variable(without_jump(s)));
    if (!rename.empty()) component = substitute(component, rename);
  }
}

} // namespace

bool has_jumps(const Symbol& symbol) { return reads_of({symbol}).jumps; }
bool has_jumps_and_values(const Symbol& symbol) {
  const Reads reads = reads_of({symbol});
  return reads.jumps && reads.values;
}
bool has_means(const std::vector<Symbol>& on_pair) {
  return std::ranges::any_of(on_pair, [](const Symbol& component) {
    return std::ranges::any_of(solver::slots_of(component), [](solver::Slot s) {
      return slot::is_field_gradient(s) || (is_test(s) && !slot::is_value(s - slot::test(0)));
    });
  });
}

Symbol without_jumps(const Symbol& symbol) {
  std::vector<Symbol> one{symbol};
  remove_jumps(one);
  return one.front();
}

/// pair(first, second, reach = ..)
std::optional<RegionSpec> Checker::pair_region(const ast::Expr& path, const ast::Call& call) {
  const auto args = match(path, call, "pair", {"first", "second", "reach"}, 2);
  if (!args) return std::nullopt;
  auto first = side_of_pair(*(*args)[0]), second = side_of_pair(*(*args)[1]);
  RegionSpec spec;
  spec.kind = RegionSpec::Kind::pair;
  spec.origin = model_.origin(path.span);
  if ((*args)[2]) {
    const auto reach = constant(*(*args)[2], "the reach of a pair");
    if (!reach) return std::nullopt;
    if (!(*reach > 0.0)) {
      error("E0408", (*args)[2]->span, "the reach of a pair is positive");
      return std::nullopt;
    }
    spec.reach = *reach;
  }
  if (!first || !second) return std::nullopt;
  if (model_.dim == 1) {
    error("E0441", path.span, "a pair is of two sides in 2D or 3D");
    return std::nullopt;
  }
  spec.children = {std::move(*first), std::move(*second)};
  return spec;
}

/// A side, or sides put together: `upper.left + upper.bottom`, a part by its name.
std::optional<RegionSpec> Checker::side_of_pair(const ast::Expr& e) {
  std::optional<RegionSpec> out;
  const auto* sum = std::get_if<ast::Binary>(&e.node);
  if (sum && (sum->op == ast::BinaryOp::add || sum->op == ast::BinaryOp::subtract)) {
    auto left = side_of_pair(*sum->left), right = side_of_pair(*sum->right);
    if (!left || !right) return std::nullopt;
    out.emplace();
    out->kind =
        sum->op == ast::BinaryOp::add ? RegionSpec::Kind::unite : RegionSpec::Kind::subtract;
    out->origin = model_.origin(e.span);
    out->children = {std::move(*left), std::move(*right)};
    return out;
  }
  out = region_path(e);
  if (!out) return std::nullopt;
  const auto kind = kind_of(*out);
  if (out->kind != RegionSpec::Kind::pair && (!kind || *kind == Group::Kind::facets)) return out;
  error("E0441", e.span,
        out->kind == RegionSpec::Kind::pair ? "a pair is no side of a pair"
                                            : "a pair is of two parts of the boundary",
        "`pair(upper.bottom, lower.top)`");
  return std::nullopt;
}

bool Checker::is_pair(int part) const {
  return part >= 0 &&
         model_.parts[static_cast<std::size_t>(part)].region.kind == RegionSpec::Kind::pair;
}

/// True (reported) where the part is a pair.
bool Checker::refuse_pair(int part, const Span& span, const std::string& what) {
  if (!is_pair(part)) return false;
  error("E0441", span,
        fmt::format("{} on the pair `{}`", what, model_.parts[static_cast<std::size_t>(part)].name),
        "laws act on a pair; everything else on one of its sides");
  return true;
}

/// jump(u), jump(u'), jump(v), jump(history(q, u)), and the same of mean: of values.
Value Checker::jump_call(const ast::Expr& e, const ast::Call& c, const std::string& name,
                         const Scope& scope) {
  const auto args = match(e, c, name, {"u"}, 1);
  if (!args) return Poison{};
  auto f = field(*(*args)[0], scope);
  if (!f) return Poison{};
  const auto is_value = [](solver::Slot s) {
    return is_test(s) ? slot::is_value(s - slot::test(0))
                      : is_field(s) && !is_jump(s) && !slot::is_field_gradient(s);
  };
  std::vector<std::pair<solver::Slot, Symbol>> rename;
  bool good = f->rank <= 1 && !f->law_vector && f->laws.empty();
  for (const Symbol& component : f->components)
    for (const solver::Slot s : solver::slots_of(component)) {
      good = good && is_value(s);
      if (good) rename.emplace_back(s, Symbol::variable(name == "jump" ? jump_of(s) : mean_of(s)));
    }
  if (!good || rename.empty()) {
    error("E0441", (*args)[0]->span,
          fmt::format("a {} is that of the unknown, its rate, a memory or the test function", name),
          fmt::format("`{0}(u).nu`, `{0}(u').tau`, `{0}(history(q, u)).nu`", name));
    return Poison{};
  }
  for (Symbol& component : f->components) component = substitute(component, rename);
  f->materials.clear();
  return *f;
}

Value Checker::gap_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  const auto args = match(e, c, "gap", {"pair"}, 1);
  if (!args) return Poison{};
  const auto* name = std::get_if<ast::Reference>(&(*args)[0]->node);
  const auto part = name ? part_index({name->name, (*args)[0]->span}) : std::nullopt;
  if (name && !part) return Poison{};
  if (!part || !is_pair(*part)) {
    error("E0441", (*args)[0]->span, "a gap is that of a pair, by its name",
          "`part seam = pair(upper.bottom, lower.top)`, then `gap(seam)`");
    return Poison{};
  }
  if (scope.law || !(scope.test || scope.report)) {
    error(
        "E0441", e.span, fmt::format("a gap cannot be used in {}", scope.what),
        "it stands in the argument of a law: `wall^0(jump(u).nu - gap(seam); jump(v).nu)`, and in "
        "reports");
    return Poison{};
  }
  if (gap_part_ >= 0 && gap_part_ != *part) {
    error("E0441", e.span, "the gaps of two pairs in one place",
          "on a pair its own gap is known only");
    return Poison{};
  }
  gap_part_ = *part;
  return scalar_field(Symbol::variable(slot::gap));
}

/// Of an expression on a part (-1: unknown): on a pair jumps become values; jumps elsewhere, values
/// on a pair and gaps of others are reported.
bool Checker::take_jumps(const Span& span, std::vector<Symbol>& components, int part) {
  const Reads reads = reads_of(components);
  const std::string& u = name_of(0);
  if (!is_pair(part)) {
    if (!reads.jumps && !reads.gap) return true;
    if (part >= 0)
      error("E0441", span,
            fmt::format("{} on `{}`, which is no pair", reads.jumps ? "a jump or a mean" : "a gap",
                        model_.parts[static_cast<std::size_t>(part)].name),
            "jumps, means of both sides and gaps are known on a pair: `part seam = "
            "pair(upper.bottom, lower.top)`");
    return false;
  }
  const std::string& pair = model_.parts[static_cast<std::size_t>(part)].name;
  if (reads.values) {
    error("E0441", span, fmt::format("on the pair `{}` each side has its own `{}`", pair, u),
          fmt::format("write `jump({0})`, the first side's minus the second one's, or "
                      "`mean({0})`; a law on one side alone acts on that side",
                      u));
    return false;
  }
  if (reads.gap && gap_part_ != part) {
    error("E0441", span, fmt::format("the gap of another pair on `{}`", pair),
          fmt::format("write `gap({})`", pair));
    return false;
  }
  remove_jumps(components);
  return true;
}

/// Of a probe at a point: on the pair that has the point.
bool Checker::take_jumps_at_point(const Span& span, Symbol& expression, solver::Probe& probe) {
  const Reads reads = reads_of({expression});
  if (!reads.jumps && !reads.gap) return true;
  if (reads.values) {
    error("E0441", span, "a jump or a mean and a value of one side in one place",
          "ask for each by itself, and combine the columns");
    return false;
  }
  probe.on_pair = true;
  probe.part = reads.gap ? gap_part_ : -1;
  expression = without_jumps(expression);
  return true;
}

} // namespace hvi::lang
