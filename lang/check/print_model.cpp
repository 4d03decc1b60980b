// The model as text, for `hvi-run dump --model` and golden tests.
#include "lang/check/model.hpp"

#include <fmt/format.h>

#include <iterator>

namespace hvi::lang {

namespace {

const char* word(solver::Rule rule) {
  switch (rule) {
  case solver::Rule::exact:
    return "exact";
  case solver::Rule::nodal:
    return "nodal";
  case solver::Rule::midpoint:
    return "midpoint";
  case solver::Rule::gauss:
    return "gauss";
  }
  return "";
}

const char* word(std::optional<solver::Group::Kind> kind) {
  if (!kind) return "of unknown kind";
  switch (*kind) {
  case solver::Group::Kind::cells:
    return "cells";
  case solver::Group::Kind::facets:
    return "boundary";
  case solver::Group::Kind::points:
    return "points";
  }
  return "";
}

std::string text_of(const ModelParam& p) {
  if (const auto* number = std::get_if<double>(&p.value)) return fmt::format("{}", *number);
  return std::get<std::string>(p.value);
}

std::string text_of(const LawUse& use, const Model& model) {
  std::string rows;
  for (const LawRow& row : use.rows) {
    std::string sum;
    for (std::size_t i = 0; i < row.u.size(); ++i) {
      if (row.u[i].is(0.0)) continue;
      const int of = static_cast<int>(i);
      const char component = "xyz"[solver::slot::component_of(of)];
      const std::string& u = model.unknowns[static_cast<std::size_t>(use.unknown)];
      const std::string what = solver::slot::is_value(of)
                                   ? fmt::format("{}_{}", u, component)
                                   : fmt::format("d{}_{}/d{}", u, component, "xyz"[of % 3]);
      sum += fmt::format("{}({}) {}", sum.empty() ? "" : " + ", to_string(row.u[i]), what);
    }
    if (!row.offset.is(0.0)) sum += fmt::format(" + ({})", to_string(row.offset));
    rows += fmt::format("\n      row {}", sum);
  }
  return fmt::format("\n    law {} ({}), factor {}{}", use.name,
                     model.laws[use.law].spec.radial ? "radial" : "scalar", to_string(use.factor),
                     rows);
}

} // namespace

std::string to_string(const Model& model) {
  std::string out =
      fmt::format("model in {}D{}\n", model.dim, model.mesh.axisymmetric ? ", axisymmetric" : "");
  for (const ModelParam& p : model.params)
    out += fmt::format("param {} = {}{}\n", p.name, text_of(p), p.overridden ? " (set)" : "");
  for (const ModelPart& p : model.parts) out += fmt::format("part {}: {}\n", p.name, word(p.kind));
  for (const solver::UnknownSpec& unknown : unknowns_of(model.space))
    out += fmt::format("space {}: {} P{}, {} conditions\n", unknown.space,
                       unknown.vector ? "vector" : "scalar", unknown.order,
                       model.space.dirichlet.size());
  for (const ModelLaw& law : model.laws)
    out += fmt::format("law {} ({}, by {}): {}\n", law.name, law.spec.radial ? "radial" : "scalar",
                       law.spec.by_slope ? "slope" : "potential", to_string(law.spec.expression));
  for (const ModelState& state : model.states)
    out += fmt::format("state {} on {}: {} from {} in [{}, {}]\n", state.spec.name,
                       model.parts[state.spec.part].name, to_string(state.spec.rate),
                       to_string(state.spec.initial), state.spec.low, state.spec.high);
  for (std::size_t i = 0; i < model.histories.size(); ++i)
    out += fmt::format("memory w{} of {}: {}\n", i, model.histories[i].name,
                       to_string(model.histories[i].kernel));
  for (const ModelTerm& term : model.terms) {
    out += fmt::format("{} over {} ({}), factor {}\n    {}", term.right ? "right" : "left",
                       model.parts[term.part].name, word(term.rule), to_string(term.factor),
                       to_string(term.integrand.scalar()));
    for (const LawUse& use : term.integrand.laws) out += text_of(use, model);
    out += "\n";
  }
  if (model.has_time && !model.time.grid.empty())
    out += fmt::format("time [{}, {}] in {} steps\n", model.time.grid.front(),
                       model.time.grid.back(), model.time.grid.size() - 1);
  for (const solver::Probe& p : model.report.probes)
    out += fmt::format("probe {}: {}\n", p.name.empty() ? "(inner)" : p.name,
                       p.kind == solver::Probe::Kind::norm_v ? "V norm" : to_string(p.expression));
  for (const Expectation& e : model.expectations)
    out += fmt::format("expect {}{} = {} within {}{}{}\n", e.probe,
                       e.time ? fmt::format(" at t = {}", *e.time) : "", e.value, e.tolerance,
                       e.relative ? " relative" : "", e.active ? "" : " (skipped)");
  return out;
}

} // namespace hvi::lang
