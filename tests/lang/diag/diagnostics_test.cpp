// The collector, suggestions and the catalogue.
#include "lang/diag/catalogue.hpp"
#include "lang/diag/diagnostic.hpp"
#include "lang/diag/failures.hpp"
#include "lang/diag/suggest.hpp"
#include "lang/diag/utf8.hpp"
#include "lang/diag/words.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace hvi::lang {
namespace {

TEST(Diagnostics, DropsTheSameCodeAtTheSamePlace) {
  Diagnostics diagnostics;
  diagnostics.add("E0201", {0, 3, 4}, "first");
  diagnostics.add("E0201", {0, 3, 4}, "second");
  diagnostics.add("E0202", {0, 3, 4}, "another code");
  diagnostics.add("E0201", {0, 3, 5}, "another place");
  EXPECT_EQ(diagnostics.size(), 3U);
  EXPECT_EQ(diagnostics.n_errors(), 3U);
  EXPECT_EQ(diagnostics.items().front().message, "first");
}

TEST(Diagnostics, TellsThoseWithoutAPlaceApartByText) {
  Diagnostics diagnostics;
  diagnostics.add("E0301", Span{}, "unknown parameter `a`");
  diagnostics.add("E0301", Span{}, "unknown parameter `b`");
  diagnostics.add("E0301", Span{}, "unknown parameter `b`");
  EXPECT_EQ(diagnostics.size(), 2U);
}

TEST(Diagnostics, QuoteWhatIsVeryLongByItsEnds) {
  Diagnostics diagnostics;
  std::string number = "1" + std::string(3'000'000, '0') + "7", accents;
  for (int i = 0; i < 400; ++i) accents += "\u00e9";
  diagnostics.add("E0105", {0, 1, 2}, "`" + number + "` is out of range, `" + accents + "` is not");
  const std::string& told = diagnostics.items().front().message;
  EXPECT_LT(told.size(), 600U);
  EXPECT_TRUE(told.starts_with("`1000")) << told;
  EXPECT_NE(told.find("...00000000000000000007` is out of range, `\u00e9"), std::string::npos);
  for (std::size_t at = 0; at < told.size(); at += utf8::decode(told, at).length)
    EXPECT_TRUE(utf8::decode(told, at).valid) << at;
  const std::string path = "`" + std::string(400, 'a') + "` is a folder";
  diagnostics.add("E0601", Span{}, path);
  EXPECT_EQ(diagnostics.items().back().message, path);
}

TEST(Diagnostics, WarningsAreNotErrors) {
  Diagnostics diagnostics;
  diagnostics.add("W0101", {0, 0, 1}, "unused");
  EXPECT_FALSE(diagnostics.has_errors());
  EXPECT_EQ(diagnostics.items().front().severity, Severity::warning);
}

TEST(Diagnostics, SortsByFileThenPlaceAndKeepsTheOrderOfEquals) {
  Diagnostics diagnostics;
  diagnostics.add("E0301", Span{}, "placeless");
  diagnostics.add("E0301", {1, 0, 1}, "second file");
  diagnostics.add("E0302", {0, 7, 9}, "late");
  diagnostics.add("E0301", {0, 7, 8}, "late too");
  diagnostics.add("E0301", {0, 2, 3}, "early");
  std::string order;
  for (const Diagnostic& d : diagnostics.sorted()) order += d.message + "; ";
  EXPECT_EQ(order, "early; late; late too; second file; placeless; ");
}

// Brute force: the same distance by its recursive definition.
std::size_t slow_distance(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty()) return a.size() + b.size();
  const std::string a1 = a.substr(1);
  const std::string b1 = b.substr(1);
  std::size_t best = std::min(slow_distance(a1, b), slow_distance(a, b1)) + 1;
  best = std::min(best, slow_distance(a1, b1) + (a[0] == b[0] ? 0 : 1));
  if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0])
    best = std::min(best, slow_distance(a.substr(2), b.substr(2)) + 1);
  return best;
}

TEST(Suggest, DistanceAgreesWithItsDefinition) {
  const std::vector<std::string> words{"", "a", "young", "yuong", "ab", "ba", "abc", "cab", "mu"};
  for (const auto& a : words)
    for (const auto& b : words)
      EXPECT_EQ(edit_distance(a, b), slow_distance(a, b)) << a << " " << b;
}

TEST(Suggest, FindsSlipsAndStaysQuietOtherwise) {
  const std::vector<std::string> names{"young", "poisson", "lambda", "mu", "N", "ground", "u"};
  EXPECT_EQ(suggest("yuong", names), "young");
  EXPECT_EQ(suggest("Ground", names), "ground");
  EXPECT_EQ(suggest("n", names), "N");
  EXPECT_EQ(suggest("um", names), "mu");
  EXPECT_EQ(suggest("posson", names), "poisson");
  EXPECT_EQ(suggest("w", names), std::nullopt);
  EXPECT_EQ(suggest("temperature", names), std::nullopt);
  EXPECT_EQ(did_you_mean("lamda", names), "did you mean `lambda`?");
  EXPECT_EQ(did_you_mean("ceiling", names), "");
}

TEST(Suggest, EqualityUpToCaseWinsOverEdits) {
  const std::vector<std::string> names{"slap", "SLAB", "slob"};
  EXPECT_EQ(suggest("slab", names), "SLAB");
}

TEST(Catalogue, EntriesAreCompleteUniqueAndInTheirClass) {
  std::set<std::string_view> codes;
  const std::regex shape("[EWN]0[0-9]{3}");
  for (const CatalogueEntry& entry : catalogue()) {
    const std::string code(entry.code);
    EXPECT_TRUE(std::regex_match(code, shape)) << code;
    EXPECT_TRUE(codes.insert(entry.code).second) << code << " stands twice";
    EXPECT_NE(class_of(entry.code), "unknown") << code;
    EXPECT_FALSE(entry.title.empty()) << code;
    EXPECT_FALSE(entry.title.ends_with('.')) << code;
    EXPECT_GT(entry.explanation.size(), 40U) << code;
    EXPECT_EQ(entry.wrong.empty(), entry.right.empty()) << code;
  }
  for (const CatalogueEntry& entry : catalogue_lexical())
    EXPECT_TRUE(entry.code.starts_with("E01"));
  for (const CatalogueEntry& entry : catalogue_syntax()) EXPECT_TRUE(entry.code.starts_with("E02"));
}

TEST(Catalogue, EveryCodeInTheSourcesHasAnEntry) {
  namespace fs = std::filesystem;
  const std::regex code_in_quotes("\"([EWN]0[0-9]{3})\"");
  std::set<std::string> used;
  for (const auto& file : fs::recursive_directory_iterator(fs::path(HVI_SOURCE_DIR) / "lang")) {
    const std::string name = file.path().filename().string();
    const bool source_file = file.path().extension() == ".cpp" || file.path().extension() == ".hpp";
    if (!source_file || name.starts_with("catalogue_")) continue;
    std::stringstream text;
    text << std::ifstream(file.path()).rdbuf();
    const std::string source = text.str();
    for (std::sregex_iterator it(source.begin(), source.end(), code_in_quotes), end; it != end;
         ++it) {
      used.insert((*it)[1]);
      EXPECT_TRUE(find_entry((*it)[1].str()).has_value())
          << (*it)[1] << " is used in " << name << " and not in the catalogue";
    }
  }
  // And the entries of the phases that are complete are all in use.
  for (const CatalogueEntry& entry : catalogue_lexical())
    EXPECT_TRUE(used.contains(std::string(entry.code))) << entry.code << " is never reported";
  for (const CatalogueEntry& entry : catalogue_syntax())
    EXPECT_TRUE(used.contains(std::string(entry.code))) << entry.code << " is never reported";
}

TEST(Failures, OfTheMachineAndOfTheScriptEndInAnotherWay) {
  using K = solver::FailureKind;
  for (const FailureEnding& row : failure_endings)
    EXPECT_EQ(ending_of(row.kind).code, row.ending.code);
  EXPECT_STREQ(ending_of(K::limit).code, ending_of(K::too_large).code);
  EXPECT_EQ(ending_of(K::limit).exit, exit_script);
  EXPECT_EQ(ending_of(K::too_large).exit, exit_solve);
  EXPECT_EQ(ending_of(K::suspended).exit, exit_interrupted);
}

TEST(Words, HelpAFailureThatBringsNone) {
  Words words;
  const solver::Failure bare(solver::FailureKind::busy_folder, {}, "busy");
  const solver::Failure helped(solver::FailureKind::busy_folder, {}, "busy", "wait");
  EXPECT_EQ(words.help_for(bare), "");
  words.help = [](solver::FailureKind) { return std::string("by its kind"); };
  EXPECT_EQ(words.help_for(bare), "by its kind");
  EXPECT_EQ(words.help_for(helped), "wait");
}

TEST(Catalogue, ExplainsACodeInEitherCase) {
  const auto text = explain("e0217", {});
  ASSERT_TRUE(text.has_value());
  EXPECT_EQ(*text, "error[E0217]: semicolon (syntax)\n\n"
                   "Statements need no sign at their end. `;` stands only between the point and "
                   "the direction of\n`j^0(u; v)`.\n\n"
                   "Wrong:\n\n    param n = 4;\n\nRight:\n\n    param n = 4\n");
  EXPECT_FALSE(explain("E9999", {}).has_value());
}

TEST(Catalogue, CompletesAnEntryWithTheCallOfItsCaller) {
  const std::vector<ExampleCall> calls{{"E0320", "set m to 8", "set n to 8"}, {"E0217", "-", "-"}};
  const auto text = explain("E0320", calls);
  ASSERT_TRUE(text.has_value());
  EXPECT_TRUE(text->ends_with("Wrong:\n\n    set m to 8\n\nRight:\n\n    set n to 8\n")) << *text;
  EXPECT_EQ(*explain("E0217", calls), *explain("E0217", {})) << "an entry has its own example";
}

TEST(Catalogue, MarkdownHasASectionForEveryCode) {
  const std::string markdown = catalogue_markdown({});
  for (const CatalogueEntry& entry : catalogue())
    EXPECT_NE(markdown.find("\n### " + std::string(entry.code) + ": "), std::string::npos);
  EXPECT_TRUE(markdown.starts_with("# Diagnostics\n"));
  EXPECT_FALSE(markdown.ends_with("\n\n"));
}

} // namespace
} // namespace hvi::lang
