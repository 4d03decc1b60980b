// The hypotheses of a script as text and as JSON (check_report.hpp).
#include "lang/cli/check_report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hvi::lang {

namespace {

using Json = nlohmann::ordered_json;
using solver::Answer;

const char* word(Answer answer) {
  switch (answer) {
  case Answer::holds:
    return "holds";
  case Answer::fails:
    return "FAILS";
  case Answer::open:
    break;
  }
  return "open";
}

const char* tint(Answer answer) {
  return answer == Answer::holds ? "\033[32m" : answer == Answer::fails ? "\033[31m" : "\033[33m";
}

std::string number(std::optional<double> value) {
  if (!value) return "";
  return std::isnan(*value) ? "not found" : fmt::format("{:.6g}", *value);
}

/// How a number was found: "proved", "proved between 1 and 2", "sampled"; "" where it is not told.
std::string provenance(const std::optional<solver::Bracket>& known) {
  if (!known) return "";
  const std::string said(word(known->how()));
  if (known->how() != solver::Provenance::between) return said;
  return fmt::format("{} {:.6g} and {:.6g}", said, known->low, known->high);
}

/// Words of a text on lines of at most `width`, each begun by `indent` spaces.
std::string folded(const std::string& text, std::size_t indent, std::size_t width) {
  std::string out, line;
  std::size_t from = 0;
  const auto flush = [&] {
    if (!line.empty()) out += std::string(indent, ' ') + line + "\n";
    line.clear();
  };
  while (from < text.size()) {
    const std::size_t to = std::min(text.find(' ', from), text.size());
    const std::string next = text.substr(from, to - from);
    if (!line.empty() && indent + line.size() + 1 + next.size() > width) flush();
    line += (line.empty() ? "" : " ") + next;
    from = to + 1;
  }
  flush();
  return out;
}

} // namespace

std::string hypotheses_text(const Script& script, const solver::HypothesisReport& report,
                            bool colour) {
  std::string out;
  std::string last;
  std::size_t what_width = 0;
  for (const auto& h : report.hypotheses) what_width = std::max(what_width, h.what.size());
  for (const auto& h : report.hypotheses) {
    const int line = line_of(script, h.origin);
    const std::string answer =
        colour ? fmt::format("{}{}\033[0m", tint(h.answer), word(h.answer)) : word(h.answer);
    out += fmt::format("{:<6} {:<{}}  {:>12}  {}{}{}\n", h.name == last ? "" : h.name, h.what,
                       what_width, number(h.value), answer,
                       line > 0 ? fmt::format("  line {}", line) : "",
                       h.known ? "  " + provenance(h.known) : "");
    if (!h.note.empty()) out += folded(h.note, 9, 100);
    last = h.name;
  }
  out += "discrete problem, this mesh:  " + report.discrete_verdict + "\n";
  out += "continuous problem, estimate: " + report.continuous_verdict + "\n";
  return out;
}

nlohmann::ordered_json hypotheses_json(const Script& script,
                                       const solver::HypothesisReport& report) {
  const auto value = [](double v) -> Json {
    if (std::isnan(v)) return nullptr;
    if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
    return v;
  };
  const auto found = [&](const solver::Bracket& b) -> Json {
    return {{"how", word(b.how())}, {"low", value(b.low)}, {"high", value(b.high)}};
  };
  Json hypotheses = Json::array();
  for (const auto& h : report.hypotheses) {
    Json row = {{"name", h.name}, {"bound", h.what}};
    row["value"] = h.value ? value(*h.value) : Json(nullptr);
    row["holds"] = h.answer == Answer::open ? Json(nullptr) : Json(h.answer == Answer::holds);
    row["line"] = line_of(script, h.origin);
    row["note"] = h.note;
    if (h.known) row["provenance"] = found(*h.known);
    hypotheses.push_back(row);
  }
  const auto& c = report.constants;
  const auto& m = report.margins;
  Json tau = Json::object();
  for (const auto& [what, bound] : report.tau_0) tau[what] = value(bound);
  Json out = {{"schema", "hvi-check/1"}, {"script", script.path}, {"hypotheses", hypotheses}};
  out["constants"] = {{"m_1", value(c.m_1)},
                      {"m_2", value(c.m_2)},
                      {"m_A", value(c.m_A)},
                      {"m_B", value(c.m_B)},
                      {"c_E", value(c.c_E)},
                      {"c_q", value(c.c_q)},
                      {"lipschitz_q", value(c.lipschitz_q)},
                      {"c_J", value(c.c_J)},
                      {"m_J", value(c.m_J)},
                      {"m_nu", value(c.m_nu)},
                      {"m_tau", value(c.m_tau)},
                      {"norm_M2",
                       {{"normal", value(c.norm_normal)},
                        {"tangential", value(c.norm_tangential)},
                        {"full", value(c.norm_full)},
                        {"script", value(c.norm_script)}}},
                      {"margin", value(m.paper)},
                      {"margin_max", value(m.largest)},
                      {"margin_split", value(m.split)},
                      {"margin_against_B", value(m.against_b)},
                      {"margin_rates", value(m.rate_split)},
                      {"margin_rates_against_A", value(m.rate_against_a)},
                      {"step_margin", value(m.step)},
                      {"worst_step", report.worst_step},
                      {"usable", value(report.usable)},
                      {"longest_step", value(c.longest_step)},
                      {"tau_0", tau}};
  out["provenance"] = {{"m_J", found(c.m_J_known)}, {"c_J", found(c.c_J_known)}};
  out["verdict"] = {
      {"discrete", {{"holds", report.discrete}, {"says", report.discrete_verdict}}},
      {"continuous", {{"holds", report.continuous}, {"says", report.continuous_verdict}}}};
  return out;
}

} // namespace hvi::lang
