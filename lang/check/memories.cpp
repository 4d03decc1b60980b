#include "lang/check/memories.hpp"

#include "lang/check/across.hpp"
#include "lang/check/builtins.hpp"
#include "solver/kernel/algebra.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

bool depends_on_memory_time(solver::Slot s) { return s == slot::t || s == slot::lag; }

/// Component i of a kernel as a sum of products of place and time.
std::optional<solver::Separated> separated(const Field& kernel, std::size_t i) {
  if (!kernel.series) return solver::split_separable(kernel.components[i], depends_on_memory_time);
  return solver::Separated{{kernel.series->of_place[i], kernel.series->sum}};
}

/// In plane strain: of each entry C_zzkl of a kernel an entry of it in the plane that is equal, -1
/// where it is zero; empty where one has none.
std::vector<int> entries_across(const Field& kernel) {
  std::vector<int> out;
  for (const Symbol& entry : kernel.across) {
    const auto same = std::ranges::find(kernel.components, entry);
    if (same == kernel.components.end() && !entry.is(0.0)) return {};
    out.push_back(entry.is(0.0) ? -1 : static_cast<int>(same - kernel.components.begin()));
  }
  return out;
}

/// The same with w in place of u.
Symbol of_memory(const Symbol& of_u, int m) {
  std::vector<std::pair<solver::Slot, Symbol>> rename;
  for (int k = 0; k < slot::n_derivatives; ++k)
    rename.emplace_back(slot::field(solver::field_of_u(0), k),
                        Symbol::variable(slot::field(solver::field_of_memory(m), k)));
  return substitute(of_u, rename);
}

bool changes_in_time(const std::vector<Symbol>& constants) {
  return std::ranges::any_of(constants, [](const Symbol& c) {
    return std::ranges::any_of(c.slots(), depends_on_memory_time);
  });
}

} // namespace

std::optional<Field> Memories::kernel_field(const ast::Expr& callee, const Scope& scope) {
  const auto* r = std::get_if<ast::Reference>(&callee.node);
  const int index = r ? names_.find(r->name) : -1;
  if (index < 0 || !std::holds_alternative<ast::Kernel>(*names_[index].statement)) {
    Value v = evaluator_.expr(callee, scope);
    if (!is_poison(v))
      mistakes_.error("E0306", callee.span,
                      fmt::format("`history` takes a kernel, not {}", describe(v)),
                      "declare it: `kernel C(lag) = ...`");
    return std::nullopt;
  }
  evaluator_.value_of(index, callee.span);
  const auto& kernel = std::get<ast::Kernel>(*names_[index].statement);
  Scope inner;
  inner.what = kernel.parameters.size() == 1 ? "a kernel of the lag" : "a kernel";
  inner.position = true;
  inner.lag = true;
  const Symbol lag = Symbol::variable(slot::lag), t = Symbol::variable(slot::t);
  if (kernel.parameters.size() == 1) {
    if (kernel.parameters[0].text == "t" || kernel.parameters[0].text == "lag" ||
        !is_reserved_builtin(kernel.parameters[0].text))
      inner.locals[kernel.parameters[0].text] = scalar_field(lag);
  } else {
    if (kernel.parameters[0].text == "s" && kernel.parameters[1].text == "t") {
      mistakes_.error("E0503", join(kernel.parameters[0].span, kernel.parameters[1].span),
                      "this kernel looks into the future: its arguments are (t, s) with s <= t",
                      "write `kernel q(t, s) = ...`");
      return std::nullopt;
    }
    inner.locals[kernel.parameters[0].text] = scalar_field(t);
    inner.locals[kernel.parameters[1].text] = scalar_field(t - lag);
  }
  auto f = evaluator_.field(kernel.value, inner);
  if (!f) return std::nullopt;
  if (f->rank != 0 && f->rank != 4) {
    mistakes_.error(
        "E0308", kernel.value.span,
        fmt::format("a kernel is a scalar or a fourth-order tensor, not {}", describe(*f)));
    return std::nullopt;
  }
  return f;
}

/// The memory of this kernel or of its negative, and which of them.
std::optional<std::pair<int, double>> Memories::known_history(const Symbol& kernel) const {
  const Symbol negative = -kernel;
  for (std::size_t i = 0; i < model_.histories.size(); ++i) {
    if (model_.histories[i].kernel == kernel) return std::pair(static_cast<int>(i), 1.0);
    if (model_.histories[i].kernel == negative) return std::pair(static_cast<int>(i), -1.0);
  }
  return std::nullopt;
}

void Memories::check_kernels_in_time() {
  const std::vector<double>& grid = model_.time.grid;
  const std::size_t stride = std::max<std::size_t>(1, grid.size() / 200);
  for (const ModelHistory& history : model_.histories) {
    if (!history.kernel.depends_on(slot::t)) continue;
    for (std::size_t n = stride; n < grid.size(); n += stride) {
      double lag = 0.0;
      const auto at = [&](solver::Slot s) { return s == slot::t ? grid[n] : lag; };
      const auto bad = [&](double share) {
        lag = share * (grid[n] - grid[0]);
        return !std::isfinite(solver::evaluate(history.kernel, at));
      };
      constexpr double beside_start = 1 - 1e-9;
      if (!bad(0.25) && !bad(0.5) && (!bad(1.0) || !bad(beside_start))) continue;
      mistakes_.error("E0502", history.span,
                      fmt::format("the kernel `{}` is {} at t = {}, s = {}", history.name,
                                  solver::evaluate(history.kernel, at), grid[n], grid[n] - lag),
                      "a kernel is finite for s < t");
      break;
    }
  }
}

/// What `history` takes the memory of; nothing (reported) where that is wrong.
std::optional<Field> Memories::history_argument(const ast::Expr& e, const ast::Expr& argument,
                                                const Field& kernel, const Scope& scope) {
  auto of = evaluator_.field(argument, scope);
  if (!of) return std::nullopt;
  if (!find_->time) {
    mistakes_.error("E0412", e.span, "`history` needs a problem in time",
                    "add `for t in [0, T] by N steps from u = 0` to the find statement");
    return std::nullopt;
  }
  if (of->rate) {
    mistakes_.error(
        "E0403", argument.span, "the memory of the theory is of the unknown, not of its rate",
        "integrate by parts in time: int q(t - s) u'(s) ds = q(0)*u - q(t)*u0 + "
        "history(derivative of q, u); a kernel that is infinite at the lag 0 needs the rate as "
        "unknown, whose memory the displacement is (docs/how_to.md, a fractional viscosity)");
    return std::nullopt;
  }
  if (of->trial != Degree::linear || of->test != Degree::none) {
    mistakes_.error("E0403", argument.span,
                    fmt::format("`history` takes an expression linear in {}", unknowns_.names()));
    return std::nullopt;
  }
  if (std::ranges::any_of(of->components,
                          [](const Symbol& one) { return one.depends_on(slot::t); })) {
    mistakes_.error("E0309", argument.span,
                    "`t` inside `history` may mean the present, or the time of what is remembered",
                    "put a factor of the present before it, `t^2*history(q, u)`, and one of the "
                    "past into the kernel, `kernel q(t, s) = exp(-(t - s))*s^2`");
    return std::nullopt;
  }
  if (kernel.rank == 4 && (of->rank != 2 || of->rows != tensor_dim(model_))) {
    mistakes_.error(
        "E0308", argument.span,
        fmt::format("a kernel of fourth order acts on a strain, not on {}", describe(*of)),
        "write `history(C, eps(u))`");
    return std::nullopt;
  }
  return of;
}

/// K = sum_m c_m(t, lag) T_m(x): one memory field for each distinct c_m.
std::optional<Memories::KernelParts> Memories::parts_of_kernel(const Field& kernel,
                                                               const std::string& name) {
  // What is wrong with a kernel is said where it is declared.
  const Declaration& declared = names_[names_.find(name)];
  const Span span = std::get<ast::Kernel>(*declared.statement).value.span;
  KernelParts parts;
  for (std::size_t i = 0; i < kernel.components.size(); ++i) {
    const auto split = separated(kernel, i);
    if (!split) {
      mistakes_.error(
          "E0502", span,
          fmt::format("the kernel `{}` is not a sum of products of time and place", name),
          "write it as c(lag) * T with T of x only");
      return std::nullopt;
    }
    for (const auto& [of_x, of_time] : *split) {
      if (of_x.is(0.0) || of_time.is(0.0)) continue;
      auto known = known_history(of_time);
      if (!known) {
        model_.histories.push_back({name, span, of_time, {}, {}});
        if (kernel.series) model_.histories.back().series = kernel.series->series;
        known = {static_cast<int>(model_.histories.size()) - 1, 1.0};
      } else if (ModelHistory& shared = model_.histories[static_cast<std::size_t>(known->first)];
                 shared.name != name && std::ranges::find(shared.also, name) == shared.also.end()) {
        shared.also.push_back(name);
      }
      auto& t = parts[known->first];
      t.resize(kernel.components.size(), Symbol(0.0));
      t[i] = t[i] + Symbol(known->second) * of_x;
    }
  }
  return parts;
}

/// factor * C, split like the kernel that it is a part of: C keeps its place in each memory, or is
/// isotropic, so that lambda and mu may have times of their own.
bool Memories::split_material(const MaterialUse& use, KernelMaterials& out) {
  const solver::TensorSpec spec = model_.tensors[static_cast<std::size_t>(*use.tensor)];
  const bool by_constants = changes_in_time(spec.constants);
  if (by_constants && spec.kind != solver::TensorSpec::Kind::isotropic) return false;
  std::vector<Symbol> wholes{use.factor};
  if (by_constants) wholes = {use.factor * spec.constants[0], use.factor * spec.constants[1]};
  std::map<int, std::vector<Symbol>> parts;
  for (std::size_t i = 0; i < wholes.size(); ++i) {
    const auto split = solver::split_separable(wholes[i], depends_on_memory_time);
    if (!split) return false;
    for (const auto& [of_x, of_time] : *split) {
      const auto known = known_history(of_time);
      if (!known) return false;
      auto& part = parts[known->first];
      part.resize(wholes.size(), Symbol(0.0));
      part[i] = part[i] + Symbol(known->second) * of_x;
    }
  }
  for (auto& [m, part] : parts) {
    MaterialUse own;
    own.tensor =
        by_constants ? tensors_.add_tensor({{}, spec.origin, spec.kind, part}) : *use.tensor;
    if (!by_constants) own.factor = part[0];
    out[m].push_back(std::move(own));
  }
  return true;
}

/// The materials of each memory of a kernel; none where one is no sum of such.
KernelMaterials Memories::materials_of_kernel(const Field& kernel, const KernelParts& parts) {
  KernelMaterials out;
  if (kernel.rank == 0) {
    for (const auto& [m, t] : parts) out[m] = {{.factor = t[0]}};
    return out;
  }
  if (kernel.series) {
    const auto known = known_history(kernel.series->sum);
    if (known) out[known->first] = scaled(kernel.series->materials, known->second);
  } else {
    for (const MaterialUse& use : kernel.materials)
      if (!use.tensor || !split_material(use, out)) return {};
  }
  const auto has_some = [&](const auto& part) { return out.contains(part.first); };
  return out.size() == parts.size() && std::ranges::all_of(parts, has_some) ? out
                                                                            : KernelMaterials();
}

/// In plane strain: sum_kl of the memories' C_zzkl times the strains that they hold. Empty where an
/// entry is no sum of products with their kernels.
std::vector<Symbol> Memories::across_of_memories(const Field& kernel,
                                                 const KernelParts& strains) const {
  Symbol sum = 0.0;
  for (std::size_t k = 0; k < kernel.across.size(); ++k) {
    const auto split = solver::split_separable(kernel.across[k], depends_on_memory_time);
    if (!split) return {};
    for (const auto& [of_x, of_time] : *split) {
      if (of_x.is(0.0) || of_time.is(0.0)) continue;
      const auto known = known_history(of_time);
      const auto strain = known ? strains.find(known->first) : strains.end();
      if (strain == strains.end()) return {};
      sum = sum + (known->second > 0 ? of_x : -of_x) * strain->second[k];
    }
  }
  return kernel.across.empty() ? std::vector<Symbol>{} : std::vector<Symbol>{sum};
}

/// In plane strain: entry zz of history(kernel, of), where the memories hold `memories`.
std::vector<Symbol> Memories::across_of_history(const Field& kernel, const Field& of,
                                                const KernelParts& parts,
                                                const KernelParts& memories) const {
  if (of.across.empty()) return {};
  Symbol sum = 0.0;
  if (kernel.rank == 0) {
    for (const auto& [m, t] : parts) sum = sum + t[0] * of_memory(of.across[0], m);
    return {sum};
  }
  if (!of.across[0].is(0.0)) return {}; // what C_zzzz would be needed for
  const auto entries = entries_across(kernel);
  if (entries.empty()) return across_of_memories(kernel, memories);
  for (const auto& [m, t] : parts)
    for (std::size_t k = 0; k < entries.size(); ++k)
      if (entries[k] >= 0) sum = sum + t[static_cast<std::size_t>(entries[k])] * memories.at(m)[k];
  return {sum};
}

Value Memories::history_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  auto args = evaluator_.match(e, c, "history", {"kernel", "of"}, 2);
  if (!args) return Poison{};
  const bool read = scope.law && find_ != nullptr;
  if (!scope.unknown && !read) {
    mistakes_.error("E0309", e.span, fmt::format("`history` cannot be used in {}", scope.what));
    return Poison{};
  }
  const auto kernel = kernel_field(*(*args)[0], scope);
  if (!kernel) return Poison{}; // `history(eps(u), C)` is one mistake
  Scope inside = scope;
  inside.unknown = true;
  inside.normal = scope.normal || read;
  const auto of = history_argument(e, *(*args)[1], *kernel, inside);
  if (!of) return Poison{};
  const auto parts = parts_of_kernel(*kernel, std::get<ast::Reference>((*args)[0]->node).name);
  if (!parts) return Poison{};
  Field out = *of;
  out.memory = true;
  for (Symbol& component : out.components) component = 0.0;
  const int n = static_cast<int>(of->components.size());
  KernelParts memories;
  for (const auto& [m, t] : *parts) {
    std::vector<Symbol>& w = memories[m];
    for (const Symbol& component : of->components) w.push_back(of_memory(component, m));
    for (int i = 0; i < n; ++i) {
      if (kernel->rank == 0) {
        out.components[i] = out.components[i] + t[0] * w[i];
        continue;
      }
      for (int k = 0; k < n; ++k) out.components[i] = out.components[i] + t[i * n + k] * w[k];
    }
  }
  out.across = across_of_history(*kernel, *of, *parts, memories);
  out.materials = memories_of(*of, materials_of_kernel(*kernel, *parts), model_.tensors);
  if (read) { // a law knows what it reads
    out.trial = Degree::none;
    out.read = true;
  }
  return out;
}

} // namespace hvi::lang
