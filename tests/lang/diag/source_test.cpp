// Texts, spans and positions.
#include "lang/diag/source.hpp"
#include "lang/diag/utf8.hpp"

#include <gtest/gtest.h>

#include <string>

namespace hvi::lang {
namespace {

TEST(SourceFile, CountsCharactersNotBytes) {
  const SourceFile file(0, "a.hvi", "param n = 1 # größe λ x\nfn f() = 2\n");
  const auto x = static_cast<std::uint32_t>(file.text().find(" x\n") + 1);
  EXPECT_EQ(file.position(x), (Position{1, 23}));
  const auto f = static_cast<std::uint32_t>(file.text().find("f()"));
  EXPECT_EQ(file.position(f), (Position{2, 4}));
}

TEST(SourceFile, DropsAByteOrderMark) {
  const SourceFile file(0, "a.hvi", "\xEF\xBB\xBFparam n = 1");
  EXPECT_EQ(file.text(), "param n = 1");
  EXPECT_EQ(file.position(6), (Position{1, 7}));
}

TEST(SourceFile, KeepsCarriageReturnsOutOfLines) {
  const SourceFile file(0, "a.hvi", "one\r\ntwo\r\n");
  EXPECT_EQ(file.n_lines(), 3);
  EXPECT_EQ(file.line(1), "one");
  EXPECT_EQ(file.line(2), "two");
  EXPECT_EQ(file.line(3), "");
  EXPECT_EQ(file.position(4), (Position{1, 4})); // between CR and LF: the end of the visible line
  EXPECT_EQ(file.position(5), (Position{2, 1}));
}

TEST(SourceFile, PlacesBehindTheEndAreTheEnd) {
  const SourceFile file(0, "a.hvi", "abc");
  EXPECT_EQ(file.position(3), (Position{1, 4}));
  EXPECT_EQ(file.position(99), (Position{1, 4}));
  EXPECT_EQ(file.text({0, 2, 99}), "c");
  EXPECT_EQ(SourceFile(0, "e", "").position(0), (Position{1, 1}));
}

TEST(SourceMap, KeepsReferencesWhileItGrows) {
  SourceMap sources;
  const SourceFile& first = sources.file(sources.add("a.hvi", "alpha"));
  for (int i = 0; i < 100; ++i) sources.add("b.hvi", std::string(100, 'b'));
  EXPECT_EQ(first.path(), "a.hvi");
  EXPECT_EQ(sources.text({0, 0, 3}), "alp");
  EXPECT_EQ(sources.n_files(), 101);
}

TEST(Span, JoinsAndEnds) {
  const Span a{0, 4, 6};
  const Span b{0, 9, 12};
  EXPECT_EQ(join(a, b), (Span{0, 4, 12}));
  EXPECT_EQ(join(b, a), (Span{0, 4, 12}));
  EXPECT_EQ(join(Span{}, b), b);
  EXPECT_EQ(after(a), (Span{0, 6, 6}));
}

TEST(ReadText, MissingFilesAndFoldersGiveNothing) {
  EXPECT_FALSE(read_text("/nowhere/at/all.hvi").has_value());
  EXPECT_FALSE(read_text("/").has_value());
}

TEST(Utf8, RejectsBrokenSequences) {
  for (const std::string bytes :
       {"\xFF", "\xC0\xAF", "\xE2\x88", "\xED\xA0\x80", "\xF5\x80\x80\x80"})
    EXPECT_FALSE(utf8::decode(bytes, 0).valid) << testing::PrintToString(bytes);
  const auto minus = utf8::decode("\xE2\x88\x92", 0);
  EXPECT_TRUE(minus.valid);
  EXPECT_EQ(minus.code, char32_t{0x2212});
  EXPECT_EQ(minus.length, 3U);
}

TEST(Utf8, EncodesWhatItDecodes) {
  for (const char32_t code : {0x41U, 0xE9U, 0x3BBU, 0x2212U, 0x1F600U, 0x10FFFFU}) {
    const auto character = utf8::decode(utf8::encode(code), 0);
    EXPECT_TRUE(character.valid);
    EXPECT_EQ(character.code, code);
  }
}

} // namespace
} // namespace hvi::lang
