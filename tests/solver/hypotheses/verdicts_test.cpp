// From margins to verdicts: every combination of signs, and margins at the edge of what eigenvalues
// are found to.
#include "solver/hypotheses/verdicts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace hvi::solver {
namespace {

HypothesisReport judged(const VerdictFacts& facts, RateForm rate_form = RateForm::none,
                        Margins margins = {-1, -1, -1, -1, -1}) {
  HypothesisReport report;
  report.rate_form = rate_form;
  report.margins = margins;
  give_verdicts(facts, report);
  return report;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A static problem and one at each t need (H0) in one of its forms; the sharpest need that holds
/// is named. Margins count where there is no estimate.
TEST(Verdicts, OneFormOfH0IsEnough) {
  for (const bool is_static : {true, false})
    for (const bool estimated : {true, false})
      for (int signs = 0; signs < 8; ++signs) {
        const double whole = signs & 1 ? 0.1 : -0.1, split = signs & 2 ? 0.1 : -0.1,
                     against_b = signs & 4 ? 0.1 : -0.1;
        VerdictFacts facts;
        facts.is_static = is_static;
        Margins margins{};
        if (estimated)
          facts.whole = whole, facts.split = split, facts.against_b = against_b;
        else
          margins.largest = whole, margins.split = split, margins.against_b = against_b;
        const auto report = judged(facts, RateForm::none, margins);
        const std::string& said = report.continuous_verdict;
        SCOPED_TRACE(said);
        EXPECT_EQ(report.continuous, signs != 0);
        EXPECT_EQ(has(said, "B is coercive and (H0)"), (signs & 1) != 0);
        EXPECT_EQ(has(said, "the split condition holds"), (signs & 3) == 2);
        EXPECT_EQ(has(said, "its form against B holds"), signs == 4);
        EXPECT_EQ(has(said, "in every form"), signs == 0);
      }
}

/// With A coercive (H0) decides which theorem, not whether there is one.
TEST(Verdicts, EvolutionsNeedNoH0) {
  for (int signs = 0; signs < 8; ++signs) {
    VerdictFacts facts;
    facts.whole = signs & 1 ? 0.1 : -0.1, facts.split = signs & 2 ? 0.1 : -0.1,
    facts.against_b = signs & 4 ? 0.1 : -0.1;
    const auto in_v = judged(facts, RateForm::in_v), in_h = judged(facts, RateForm::in_h);
    EXPECT_TRUE(in_v.continuous && in_h.continuous);
    EXPECT_EQ(has(in_v.continuous_verdict, "the theorem applies"), (signs & 1) != 0);
    EXPECT_EQ(has(in_v.continuous_verdict, "the split condition"), (signs & 3) == 2);
    EXPECT_EQ(has(in_v.continuous_verdict, "its form against B"), signs == 4);
    EXPECT_EQ(has(in_v.continuous_verdict, "is not needed"), signs == 0);
    EXPECT_EQ(has(in_h.continuous_verdict, "(H0) fails"), signs == 0);
  }
}

/// Eigenvalues are found to a few digits less than numbers have: a margin below 1e-9 proves
/// nothing.
TEST(Verdicts, AMarginThatIsRoundingProvesNothing) {
  const auto unique = [](double margin) {
    VerdictFacts facts;
    facts.steps_margin = margin;
    return judged(facts).discrete;
  };
  EXPECT_TRUE(unique(1.0));
  EXPECT_TRUE(unique(1e-8));
  EXPECT_FALSE(unique(5e-10));
  EXPECT_FALSE(unique(0.0));
  EXPECT_FALSE(unique(-std::numeric_limits<double>::infinity()));
}

/// A kind of problem for which a theorem is claimed.
struct Kind {
  const char* name;
  VerdictFacts facts;
  RateForm rate_form;
  const char* due; ///< a part of whom the theorem is due to
  /// Of H(A), H(B), H(E), H(q), H(J), H(M), H(f), H(rho): what it needs.
  std::vector<std::string> needs;
  bool regular, first_order; ///< u in H1(0, T; V); the error O(h + k)
};

std::vector<Kind> kinds() {
  VerdictFacts plain;
  plain.whole = plain.split = plain.against_b = plain.rate_against_a = 0.1, plain.steps_margin = 1;
  const auto with = [&](auto change) {
    VerdictFacts facts = plain;
    change(facts);
    return facts;
  };
  return {
      {"static",
       with([](VerdictFacts& f) { f.is_static = true; }),
       RateForm::none,
       "",
       {"H(B)", "H(J)", "H(M)", "H(f)"},
       true,
       true},
      {"springs",
       with([](VerdictFacts& f) { f.is_static = f.semi_coercive = f.springs_hold = true; }),
       RateForm::none,
       "",
       {"H(J)", "H(f)"},
       true,
       true},
      {"at each t",
       plain,
       RateForm::none,
       "",
       {"H(B)", "H(E)", "H(J)", "H(M)", "H(f)"},
       false,
       false},
      {"with memory",
       with([](VerdictFacts& f) { f.has_memory = true; }),
       RateForm::none,
       "",
       {"H(B)", "H(E)", "H(J)", "H(M)", "H(f)"},
       false,
       false},
      {"in V",
       plain,
       RateForm::in_v,
       "",
       {"H(A)", "H(E)", "H(q)", "H(J)", "H(M)", "H(f)"},
       true,
       true},
      {"in H",
       plain,
       RateForm::in_h,
       "",
       {"H(B)", "H(E)", "H(q)", "H(J)", "H(M)", "H(f)"},
       false,
       false},
      {"on rates",
       with([](VerdictFacts& f) { f.has_rate_laws = true; }),
       RateForm::in_v,
       "Matei 2011",
       {"H(A)", "H(E)", "H(J)", "H(M)", "H(f)"},
       true,
       false},
      {"on memories",
       with([](VerdictFacts& f) { f.has_memory_laws = true; }),
       RateForm::in_v,
       "Patrulescu 2014",
       {"H(A)", "H(E)", "H(q)", "H(J)", "H(M)", "H(f)"},
       true,
       false},
      {"in motion",
       with([](VerdictFacts& f) { f.moves = true; }),
       RateForm::in_v,
       "Kulig 2013",
       {"H(rho)", "H(A)", "H(E)", "H(J)", "H(M)", "H(f)"},
       true,
       false},
  };
}

HypothesisReport judged(const Kind& kind, const std::string& failing = "") {
  HypothesisReport report;
  report.rate_form = kind.rate_form;
  report.margins = {-1, -1, -1, -1, -1};
  for (const char* name : {"H(A)", "H(B)", "H(E)", "H(q)", "H(J)", "H(M)", "H(f)", "H(rho)"}) {
    Hypothesis row;
    row.name = name;
    row.answer = name == failing ? Answer::fails : Answer::holds;
    report.hypotheses.push_back(row);
  }
  give_verdicts(kind.facts, report);
  return report;
}

const Hypothesis* claim(const HypothesisReport& report, const std::string& what) {
  for (const Hypothesis& row : report.hypotheses)
    if (row.name == "theorem" && row.what == what) return &row;
  return nullptr;
}

/// Each theorem is claimed where what it needs holds, not where one of that fails, and says to whom
/// it is due; what falls away of the paper's claims says why.
TEST(Verdicts, EveryTheoremNeedsItsHypothesesAndNoOthers) {
  for (const Kind& kind : kinds()) {
    SCOPED_TRACE(kind.name);
    const auto report = judged(kind);
    EXPECT_TRUE(report.continuous) << report.continuous_verdict;
    EXPECT_TRUE(has(report.continuous_verdict, kind.due)) << report.continuous_verdict;
    ASSERT_NE(claim(report, "one solution"), nullptr);
    EXPECT_EQ(claim(report, "one solution")->answer, Answer::holds);
    EXPECT_TRUE(has(claim(report, "one solution")->note, kind.due));
    const Hypothesis *regular = claim(report, "u in H1(0, T; V)"),
                     *order = claim(report, "error O(h + k) in V");
    ASSERT_EQ(regular == nullptr, kind.facts.is_static);
    if (regular != nullptr) {
      EXPECT_EQ(regular->answer == Answer::holds, kind.regular) << regular->note;
      EXPECT_EQ(regular->note.empty(), kind.regular) << regular->note;
      EXPECT_EQ(order->answer == Answer::holds, kind.first_order) << order->note;
      EXPECT_FALSE(order->note.empty()); // for whom, or why not
    }
    Kind sampled = kind; // constants of laws that are not proved prove nothing
    sampled.facts.proved = false;
    EXPECT_FALSE(judged(sampled).continuous || judged(sampled).discrete);
    for (const Hypothesis& row : report.hypotheses) {
      if (row.name == "theorem") continue;
      const bool needed = std::ranges::find(kind.needs, row.name) != kind.needs.end();
      const auto without = judged(kind, row.name);
      EXPECT_EQ(without.continuous, !needed) << row.name << ": " << without.continuous_verdict;
    }
  }
}

/// Laws on u' may not soften faster than A; the estimate on ever finer meshes counts where there is
/// one.
TEST(Verdicts, LawsOnRatesNeedAMargin) {
  for (const double of_mesh : {-0.1, 0.1})
    for (const std::optional<double>& finer : {std::optional<double>(), {0.0}, {0.1}}) {
      VerdictFacts facts;
      facts.has_rate_laws = true;
      facts.rate_against_a = finer;
      Margins margins{};
      margins.rate_against_a = of_mesh;
      const auto report = judged(facts, RateForm::in_v, margins);
      EXPECT_EQ(report.continuous, finer.value_or(of_mesh) > 0.0) << report.continuous_verdict;
    }
}

} // namespace
} // namespace hvi::solver
