// Model to plan.
#include "lang/lower/lower.hpp"

#include "lang/check/loads.hpp"
#include "lang/lower/at_rest.hpp"
#include "lang/lower/common_points.hpp"
#include "lang/lower/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Effect;
using solver::FormTerm;
using solver::Group;
using solver::LoadTerm;

namespace {

using slot::n_derivatives;

/// What a form acting on this field is called.
Effect effect_of(int field) {
  if (field == solver::field_of_u(2)) return Effect::inertia;
  if (field == solver::field_of_u(1)) return Effect::viscosity;
  return field == solver::field_of_u(0) ? Effect::elasticity : Effect::memory;
}

class Lowering {
public:
  explicit Lowering(Model& model) : model_(model) {}

  solver::Plan run() {
    plan_.problem.title = model_.title;
    plan_.problem.mesh = model_.mesh;
    for (const ModelPart& part : model_.parts)
      plan_.problem.parts.push_back({part.name, origin(part.span), part.region});
    plan_.problem.space = model_.space;
    plan_.problem.time = model_.time;
    plan_.options = model_.options;
    plan_.report = model_.report;
    for (const ModelLaw& law : model_.laws) plan_.problem.laws.push_back(law.spec);
    for (const ModelState& state : model_.states) plan_.problem.states.push_back(state.spec);
    for (const ModelHistory& h : model_.histories) {
      solver::KernelSpec kernel{h.name, origin(h.span), h.kernel, h.series};
      plan_.problem.histories.push_back({kernel.origin, kernel});
    }
    for (const ModelTerm& term : model_.terms) lower_term(term);
    revive_needed_laws();
    rename_report();
    give_common_points(plan_.problem);
    keep_used_tensors();
    plan_.problem.effects = effects(model_, plan_.problem);
    return std::move(plan_);
  }

private:
  solver::Origin origin(const Span& span) { return model_.origin(span); }

  /// Leaves out memory fields that nothing uses any more and laws that were dropped: the report's
  /// expressions and the forms get the new numbers; the multiplier of a dropped law is 0.
  void rename_report() {
    std::vector<int> fresh(plan_.problem.histories.size(), -1);
    auto use = [&](int field) {
      if (solver::is_memory(field)) fresh[solver::memory_of(field)] = 0;
    };
    for (const FormTerm& form : plan_.problem.forms) use(form.field);
    for (const solver::LawTerm& term : plan_.problem.law_terms) {
      use(term.field);
      for (const auto& row : term.seen)
        for (const solver::SeenField& seen : row) use(seen.field);
      for_each_field_read(law_of(term), use);
    }
    const auto use_all = [&](const Symbol& e) {
      for (solver::Slot s : solver::slots_of(e))
        if (slot::is_field(s)) use(slot::field_of(s));
    };
    for_each_report_expression(use_all);
    for (const solver::StateTerm& state : plan_.problem.states) use_all(state.rate);
    std::vector<solver::HistoryTerm> kept;
    std::vector<std::pair<solver::Slot, Symbol>> rename, unused; // unused: by laws that are dropped
    for (std::size_t m = 0; m < fresh.size(); ++m) {
      if (fresh[m] < 0) {
        for (int k = 0; k < n_derivatives; ++k)
          unused.emplace_back(slot::field(solver::field_of_memory(static_cast<int>(m)), k), 0.0);
        continue;
      }
      fresh[m] = static_cast<int>(kept.size());
      kept.push_back(plan_.problem.histories[m]);
      for (int k = 0; k < n_derivatives; ++k)
        rename.emplace_back(slot::field(solver::field_of_memory(static_cast<int>(m)), k),
                            Symbol::variable(slot::field(solver::field_of_memory(fresh[m]), k)));
    }
    for (FormTerm& form : plan_.problem.forms)
      if (solver::is_memory(form.field))
        form.field = solver::field_of_memory(fresh[solver::memory_of(form.field)]);
    const auto renew = [&](int& field) {
      if (solver::is_memory(field))
        field = solver::field_of_memory(fresh[solver::memory_of(field)]);
    };
    for (solver::LawTerm& term : plan_.problem.law_terms) {
      renew(term.field);
      for (auto& row : term.seen)
        for (solver::SeenField& seen : row) renew(seen.field);
    }
    plan_.problem.histories = std::move(kept);
    for (std::size_t a = 0; a < applications_.size(); ++a)
      for (int k = 0; k < slot::most_arguments; ++k)
        rename.emplace_back(slot::multiplier(static_cast<int>(a), k),
                            applications_[a] < 0
                                ? Symbol(0.0)
                                : Symbol::variable(slot::multiplier(applications_[a], k)));
    for (solver::LawSpec& law : plan_.problem.laws)
      for (Symbol& reading : law.readings)
        reading = substitute(substitute(reading, unused), rename);
    for_each_report_expression([&](Symbol& e) { e = substitute(e, rename); });
    for (solver::StateTerm& state : plan_.problem.states)
      state.rate = substitute(state.rate, rename);
  }

  const solver::LawSpec& law_of(const solver::LawTerm& term) const {
    return plan_.problem.laws[static_cast<std::size_t>(term.law)];
  }

  template <class F>
  static void for_each_field_read(const solver::LawSpec& law, F f) {
    for (const Symbol& reading : law.readings)
      for (const solver::Slot s : reading.slots())
        if (slot::is_field(s)) f(slot::field_of(s));
  }

  template <class F>
  void for_each_report_expression(F f) {
    for (solver::Probe& probe : plan_.report.probes) f(probe.expression);
    for (solver::FieldsSpec& fields : plan_.report.fields)
      for (solver::FieldSpec& field : fields.fields) for_each_entry(field, f);
    for (solver::PictureSpec& picture : plan_.report.pictures) for_each_entry(picture.field, f);
    for (solver::LineSpec& line : plan_.report.lines)
      for (solver::FieldSpec& field : line.fields) for_each_entry(field, f);
  }

  void lower_term(const ModelTerm& term) {
    std::map<int, FormTerm> forms;
    LoadTerm load, of_states;
    const Symbol integrand = term.factor * term.integrand.scalar();
    for (const solver::Slot s_test : solver::slots_of(integrand)) {
      if (!slot::is_test(s_test)) continue;
      const int test = s_test - slot::test(0);
      const Symbol against = derivative(integrand, s_test);
      if (against.is(0.0)) continue;
      if (term.right && !is_affine(against)) {
        of_states.entries.push_back({test, value_of_load(term, test, against)});
        continue;
      }
      Symbol rest = against;
      std::vector<std::pair<solver::Slot, Symbol>> at_rest;
      for (solver::Slot s : solver::slots_of(against)) {
        if (!slot::is_field(s)) continue;
        at_rest.emplace_back(s, Symbol(0.0));
        const Symbol coefficient = derivative(against, s);
        if (coefficient.is(0.0)) continue;
        FormTerm& form = forms[slot::field_of(s)];
        form.entries.push_back(
            {test, slot::derivative_of(s), term.right ? -coefficient : coefficient});
      }
      rest = substitute(against, at_rest);
      if (rest.is(0.0)) continue;
      const bool reads_states = rest.depends_on_any(slot::first_state, slot::first_probe);
      (reads_states ? of_states : load).entries.push_back({test, term.right ? rest : -rest});
    }
    for (auto& [field, form] : forms) {
      form.origin = origin(term.span);
      form.part = term.part;
      form.field = field;
      form.rule = term.rule_given || term.integrand.laws.empty() ? term.rule : solver::Rule::exact;
      form.effect = effect_of(field);
      form.tensor = tensor_of(term, field);
      plan_.problem.forms.push_back(std::move(form));
    }
    lower_load(term, std::move(load), plan_.problem.loads);
    lower_load(term, std::move(of_states), plan_.problem.state_loads);
    for (const LawUse& use : term.integrand.laws) lower_law(term, use);
  }

  /// What a load reads of the solution is an algebraic state: those that are the same, one.
  Symbol value_of_load(const ModelTerm& term, int test, const Symbol& value) {
    auto& states = plan_.problem.states;
    const bool of_value = slot::is_value(test);
    const std::string name = fmt::format("load of {}{}", of_value ? "" : "the gradient of ",
                                         name_of(slot::unknown_of(test)));
    const auto known = std::ranges::find_if(states, [&](const solver::StateTerm& state) {
      return state.algebraic && state.part == term.part && state.name == name &&
             state.rate == value;
    });
    const auto i = static_cast<int>(known - states.begin());
    if (known == states.end()) {
      solver::StateTerm state;
      state.origin = origin(term.span);
      state.name = name;
      state.part = term.part;
      state.rate = value;
      state.initial = 0.0;
      state.algebraic = true;
      states.push_back(std::move(state));
    }
    return Symbol::variable(slot::state(i));
  }

  std::string name_of(int unknown) const {
    return solver::unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].name;
  }

  void lower_load(const ModelTerm& term, LoadTerm load, std::vector<LoadTerm>& loads) {
    if (load.entries.empty()) return;
    load.origin = origin(term.span);
    load.part = term.part;
    load.rule = term.rule_given || term.integrand.laws.empty() ? term.rule : solver::Rule::exact;
    load.effect =
        model_.parts[term.part].kind == Group::Kind::cells ? Effect::body_force : Effect::traction;
    loads.push_back(std::move(load));
  }

  /// The tensor that a term acts with on a field, where it was written with one alone.
  static std::optional<FormTerm::Tensor> tensor_of(const ModelTerm& term, int field) {
    const auto of_field = [&](const MaterialUse& use) { return use.of == field; };
    const auto& uses = term.integrand.materials;
    if (std::ranges::count_if(uses, of_field) != 1) return std::nullopt;
    const MaterialUse& use = *std::ranges::find_if(uses, of_field);
    if (!use.tensor || !use.tested) return std::nullopt;
    const Symbol factor = term.factor * use.factor;
    return FormTerm::Tensor{*use.tensor, term.right ? -factor : factor, use.unknown};
  }

  void keep_used_tensors() {
    std::vector<int> fresh(model_.tensors.size(), -1);
    for (FormTerm& form : plan_.problem.forms) {
      if (!form.tensor) continue;
      int& index = fresh[static_cast<std::size_t>(form.tensor->index)];
      if (index < 0) {
        index = static_cast<int>(plan_.problem.tensors.size());
        plan_.problem.tensors.push_back(
            model_.tensors[static_cast<std::size_t>(form.tensor->index)]);
      }
      form.tensor->index = index;
    }
  }

  /// A law that sees c times a memory sees that of the kernel c q.
  int field_of_law(const LawUse& use) {
    if (!solver::is_memory(use.field) || use.of_memory == 1.0) return use.field;
    auto& histories = plan_.problem.histories;
    histories.push_back(histories[static_cast<std::size_t>(solver::memory_of(use.field))]);
    auto& kernel = histories.back().kernel;
    kernel.expression = Symbol(use.of_memory) * kernel.expression;
    kernel.series.reset(); // found again in the expression
    return solver::field_of_memory(static_cast<int>(histories.size()) - 1);
  }

  void lower_law(const ModelTerm& term, const LawUse& use) {
    const Symbol factor = term.factor * use.factor;
    applications_.push_back(-1);
    if (factor.is(0.0) || model_.laws[use.law].spec.expression.is(0.0)) {
      dropped_.push_back({&term, &use, applications_.size() - 1});
      for (solver::Probe& probe : plan_.report.probes)
        if (probe.part == term.part) probe.may_be_free = true;
      return;
    }
    add_law(term, use, factor, applications_.size() - 1);
  }

  /// States live at the points of a law, and a bound is the multiplier of one: where the only one
  /// was dropped it stays, as a law without force.
  void revive_needed_laws() {
    const auto acts_on = [&](int part) {
      return std::ranges::any_of(plan_.problem.law_terms,
                                 [&](const auto& term) { return term.part == part; });
    };
    for (const solver::StateTerm& state : plan_.problem.states) {
      const bool in_body =
          model_.parts[static_cast<std::size_t>(state.part)].kind == Group::Kind::cells;
      if (!in_body && !acts_on(state.part))
        revive([&](const DroppedLaw& law) { return law.term->part == state.part; });
    }
    for (std::size_t l = 0; l < plan_.problem.law_terms.size(); ++l) {
      const int part = plan_.problem.law_terms[l].part;
      const std::string& bound = law_of(plan_.problem.law_terms[l]).coupled;
      const bool there = std::ranges::any_of(plan_.problem.law_terms, [&](const auto& term) {
        return term.part == part && term.name == bound;
      });
      if (!bound.empty() && !there)
        revive([&](const DroppedLaw& law) {
          return law.term->part == part && law.use->name == bound;
        });
    }
  }

  template <class Wanted>
  void revive(Wanted wanted) {
    const auto found = std::ranges::find_if(dropped_, wanted);
    if (found == dropped_.end()) return;
    solver::LawSpec without_force = model_.laws[static_cast<std::size_t>(found->use->law)].spec;
    without_force.expression = Symbol(0.0);
    without_force.coupled.clear();
    without_force.readings.clear();
    without_force.states.clear();
    add_law(*found->term, *found->use, Symbol(1.0), found->application);
    plan_.problem.law_terms.back().law = static_cast<int>(plan_.problem.laws.size());
    plan_.problem.laws.push_back(std::move(without_force));
    dropped_.erase(found);
  }

  void add_law(const ModelTerm& term, const LawUse& use, const Symbol& factor,
               std::size_t application) {
    applications_[application] = static_cast<int>(plan_.problem.law_terms.size());
    solver::LawTerm out;
    out.origin = origin(use.span);
    out.name = use.name;
    out.law = use.law;
    out.part = term.part;
    out.field = field_of_law(use);
    out.seen = use.seen;
    out.unknown = use.unknown;
    out.mean = use.mean;
    out.rule_of = use.rule_of;
    const bool by_gauss = term.rule == solver::Rule::exact ||
                          (use.sees_gradient() && term.rule == solver::Rule::nodal);
    out.rule = by_gauss ? solver::Rule::gauss : term.rule; // there are no gradients at nodes
    out.effect = rubs(model_, use) ? Effect::friction : Effect::normal_law;
    out.factor = factor;
    for (const LawRow& row : use.rows) {
      solver::LawTerm::Row r;
      r.u = row.u;
      r.offset = row.offset;
      out.rows.push_back(std::move(r));
    }
    plan_.problem.law_terms.push_back(std::move(out));
  }

  Model& model_;
  solver::Plan plan_;
  std::vector<int> applications_; ///< law term of the a-th j^0 of the script, -1 when dropped
  struct DroppedLaw {
    const ModelTerm* term;
    const LawUse* use;
    std::size_t application;
  };
  std::vector<DroppedLaw> dropped_;
};

} // namespace

solver::Plan lower(Model& model) {
  std::shared_ptr<const solver::Plan> start;
  if (model.starts_at_rest) {
    Model rest = at_rest(model);
    start = std::make_shared<const solver::Plan>(Lowering(rest).run());
    model.origins = std::move(rest.origins);
  }
  solver::Plan out = Lowering(model).run();
  out.start = std::move(start);
  return out;
}

} // namespace hvi::lang
