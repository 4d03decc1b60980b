// What the plan says about effects.
#include "lang/lower/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>

namespace hvi::lang {

using solver::Effect;
using solver::EffectNote;
using solver::Group;

bool rubs(const Model& model, const LawUse& use) {
  return model.laws[static_cast<std::size_t>(use.law)].spec.radial && !use.sees_gradient();
}

namespace {

using State = EffectNote::State;

struct Seen {
  bool on = false, dropped = false;
  Span span;
};

/// What a term without a law would be called if it did not fold to zero.
Effect effect_of(const Model& model, const ModelTerm& term) {
  if (term.integrand.acceleration) return Effect::inertia;
  if (term.integrand.rate) return Effect::viscosity;
  if (term.integrand.memory) return Effect::memory;
  if (term.integrand.trial != Degree::none) return Effect::elasticity;
  return model.parts[term.part].kind == Group::Kind::cells ? Effect::body_force : Effect::traction;
}

bool folded(const ModelTerm& term) { return (term.factor * term.integrand.scalar()).is(0.0); }

EffectNote note(Model& model, const char* name, const Seen& seen, const char* off_reason) {
  EffectNote out;
  out.name = name;
  out.state = seen.on ? State::on : seen.dropped ? State::dropped : State::off;
  if (seen.on || seen.dropped) out.origin = model.origin(seen.span);
  out.why = seen.on ? "" : seen.dropped ? "it folds to zero" : off_reason;
  return out;
}

/// The origin of the law's term in the plan: by it the run reports whether the law ever acted.
solver::Origin origin_of(Model& model, const solver::Problem& problem, const Span& span) {
  for (const solver::LawTerm& term : problem.law_terms) {
    if (model.origins[term.origin.id] == span) return term.origin;
  }
  return model.origin(span);
}

std::string on_what(const LawUse& use) {
  std::set<int> fields;
  for (const auto& row : use.seen)
    for (const solver::SeenField& seen : row) fields.insert(seen.field);
  if (fields.empty()) fields.insert(use.field);
  std::string out;
  for (const int field : fields) {
    if (field == solver::field_of_u(0) && fields.size() == 1) return "";
    out += out.empty() ? " on " : " and ";
    out += field == solver::field_of_u(0) ? "the unknown"
           : solver::is_memory(field)     ? "the memory"
                                          : "the rate";
  }
  return out;
}

using All = std::array<Seen, 9>;

/// What the forms and loads of the problem are, and those that were folded away.
All seen_in(const Model& model, const solver::Problem& problem) {
  All seen;
  const auto mark = [&](Effect effect, bool on, const Span& span) {
    Seen& s = seen[static_cast<std::size_t>(effect)];
    if (s.on) return;
    (on ? s.on : s.dropped) = true;
    s.span = span;
  };
  for (const solver::FormTerm& form : problem.forms)
    mark(form.effect, true, model.origins[form.origin.id]);
  for (const solver::LoadTerm* const load : all_loads(problem))
    mark(load->effect, true, model.origins[load->origin.id]);
  for (const ModelTerm& term : model.terms)
    if (term.integrand.laws.empty() && folded(term)) mark(effect_of(model, term), false, term.span);
  return seen;
}

EffectNote note_of_law(Model& model, const solver::Problem& problem, const ModelTerm& term,
                       const LawUse& use) {
  const solver::LawSpec& spec = model.laws[use.law].spec;
  const bool zero = (term.factor * use.factor).is(0.0), flat = spec.expression.is(0.0);
  EffectNote law;
  law.name = fmt::format("{}{} `{}` on `{}`", rubs(model, use) ? "friction" : "law", on_what(use),
                         use.name, model.parts[term.part].name);
  law.state = zero || flat ? State::dropped : State::on;
  law.origin = origin_of(model, problem, use.span);
  law.why = zero                     ? "its factor is zero"
            : flat                   ? "the superpotential is zero"
            : !spec.readings.empty() ? "reads the solution, found with each step"
                                     : "";
  return law;
}

void add_pairs(Model& model, const solver::Problem& problem, std::vector<EffectNote>& out) {
  for (std::size_t p = 0; p < model.parts.size(); ++p) {
    const auto on_it = [&](const solver::LawTerm& term) {
      return term.part == static_cast<int>(p);
    };
    if (model.parts[p].region.kind == solver::RegionSpec::Kind::pair &&
        std::ranges::any_of(problem.law_terms, on_it))
      out.push_back({fmt::format("pair `{}`", model.parts[p].name), State::on,
                     model.origin(model.parts[p].span),
                     "its sides are matched once, by the intersections of their facets; the "
                     "unknowns of both are contact unknowns"});
  }
}

EffectNote note_of_state(const solver::Problem& problem, std::size_t index) {
  const solver::StateTerm& state = problem.states[index];
  EffectNote one;
  one.name = fmt::format("state `{}` on `{}`", state.name, problem.parts[state.part].name);
  one.state = State::on;
  one.origin = state.origin;
  const auto slot = solver::slot::state(static_cast<solver::Slot>(index));
  const bool in_form = std::ranges::any_of(problem.forms, [&](const solver::FormTerm& form) {
    return std::ranges::any_of(form.entries, [&](const solver::FormTerm::Entry& entry) {
      return entry.coefficient.depends_on(slot);
    });
  });
  one.why = in_form ? "an ordinary differential equation at every point, solved with the step; it "
                      "changes the matrix: a factor in every pass"
                    : "an ordinary differential equation at every point, solved with the step";
  return one;
}

} // namespace

std::vector<EffectNote> effects(Model& model, const solver::Problem& problem) {
  const All seen = seen_in(model, problem);
  auto of = [&](Effect effect) -> const Seen& { return seen[static_cast<std::size_t>(effect)]; };
  std::vector<EffectNote> out;
  out.push_back(note(model, "inertia", of(Effect::inertia), "no term with the acceleration"));
  out.push_back(note(model, "viscosity", of(Effect::viscosity), "no term with the rate"));
  out.push_back(note(model, "elasticity", of(Effect::elasticity), "no term with the unknown"));
  out.push_back(note(model, "memory", of(Effect::memory), "no history term"));
  out.push_back(note(model, "body force", of(Effect::body_force), "no load on cells"));
  out.push_back(note(model, "traction", of(Effect::traction), "no load on the boundary"));
  bool any_normal = false, any_friction = false;
  for (const ModelTerm& term : model.terms)
    for (const LawUse& use : term.integrand.laws) {
      (rubs(model, use) ? any_friction : any_normal) = true;
      out.push_back(note_of_law(model, problem, term, use));
    }
  add_pairs(model, problem, out);
  if (!any_normal) out.push_back(note(model, "normal law", {}, "no superpotential of a scalar"));
  if (!any_friction) out.push_back(note(model, "friction", {}, "no superpotential of a vector"));
  for (std::size_t i = 0; i < problem.states.size(); ++i)
    if (!problem.states[i].algebraic) out.push_back(note_of_state(problem, i));
  for (const ModelNote& found : model.notes)
    out.push_back(
        {found.name, found.taken ? State::on : State::off, model.origin(found.span), found.what});
  return out;
}

} // namespace hvi::lang
