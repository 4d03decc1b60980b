// From margins to verdicts: every combination of signs, and margins at the edge of what eigenvalues
// are found to.
#include "solver/hypotheses/verdicts.hpp"

#include <gtest/gtest.h>

#include <limits>

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

} // namespace
} // namespace hvi::solver
