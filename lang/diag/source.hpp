// Script texts and places in them. First stage of the pipeline: everything later speaks of a text
// only through a Span, and only the renderer turns spans back into lines and columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::lang {

/// Index of a file in its SourceMap. no_file marks things without a place (a command line flag).
inline constexpr int no_file = -1;

/// The largest script accepted, in bytes. A script is written by hand; 4 MiB is a mistake.
inline constexpr std::size_t max_script_bytes = std::size_t{4} << 20;

/// Half-open range [begin, end) of bytes in one file.
struct Span {
  int file = no_file;
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  [[nodiscard]] bool valid() const { return file >= 0; }
  [[nodiscard]] std::uint32_t length() const { return end - begin; }
  friend bool operator==(const Span&, const Span&) = default;
};

/// The smallest span that covers both (an invalid one is ignored).
[[nodiscard]] Span join(const Span& first, const Span& second);

/// The empty place just behind a span: where something is missing.
[[nodiscard]] Span after(const Span& span);

/// Line and column of a byte, both from 1; the column counts characters (code points), not bytes.
struct Position {
  int line = 1;
  int column = 1;
  friend bool operator==(const Position&, const Position&) = default;
};

/// One text with its line table. A leading byte-order mark is dropped, so offsets start behind it.
class SourceFile {
public:
  SourceFile(int id, std::string path, std::string text);

  [[nodiscard]] int id() const { return id_; }
  /// The path as the user gave it; "stdlib/friction.hvi" for embedded modules.
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string_view text() const { return text_; }
  [[nodiscard]] std::string_view text(const Span& span) const;

  [[nodiscard]] int n_lines() const { return static_cast<int>(line_begin_.size()); }
  /// Text of a line (from 1) without its line end; empty when there is no such line.
  [[nodiscard]] std::string_view line(int number) const;
  /// Byte offset at which a line starts.
  [[nodiscard]] std::uint32_t line_begin(int number) const;
  /// Position of a byte offset; offsets behind the end give the position of the end.
  [[nodiscard]] Position position(std::uint32_t offset) const;

private:
  int id_;
  std::string path_;
  std::string text_;
  std::vector<std::uint32_t> line_begin_;
};

/// All texts of one run: the script, its imports and the modules of the library they name.
/// References to files stay valid while files are added.
class SourceMap {
public:
  /// Adds a text and returns its id.
  int add(std::string path, std::string text);
  [[nodiscard]] int n_files() const { return static_cast<int>(files_.size()); }
  [[nodiscard]] const SourceFile& file(int id) const { return files_.at(std::size_t(id)); }
  [[nodiscard]] Position begin(const Span& span) const;
  [[nodiscard]] Position end(const Span& span) const;
  [[nodiscard]] std::string_view text(const Span& span) const;

private:
  std::deque<SourceFile> files_;
};

/// Reads a whole file; nothing when it cannot be read (missing, a folder, no permission).
/// A file above the limit is cut to limit + 1 bytes, which the lexer then reports as too large.
[[nodiscard]] std::optional<std::string> read_text(const std::string& path,
                                                   std::size_t limit = max_script_bytes);

} // namespace hvi::lang
