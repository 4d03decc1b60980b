// Script texts, line tables and positions, see source.hpp.
#include "lang/diag/source.hpp"

#include "lang/diag/utf8.hpp"
#include "solver/common/read_file.hpp"

#include <algorithm>

namespace hvi::lang {

Span join(const Span& first, const Span& second) {
  if (!first.valid()) return second;
  if (!second.valid()) return first;
  return {first.file, std::min(first.begin, second.begin), std::max(first.end, second.end)};
}

Span after(const Span& span) { return {span.file, span.end, span.end}; }

SourceFile::SourceFile(int id, std::string path, std::string text)
    : id_(id), path_(std::move(path)), text_(std::move(text)) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text_.starts_with(byte_order_mark)) text_.erase(0, byte_order_mark.size());
  line_begin_.push_back(0);
  for (std::size_t i = text_.find('\n'); i != std::string::npos; i = text_.find('\n', i + 1))
    line_begin_.push_back(static_cast<std::uint32_t>(i + 1));
}

std::string_view SourceFile::text(const Span& span) const {
  const std::size_t begin = std::min<std::size_t>(span.begin, text_.size());
  return text().substr(begin, span.end > begin ? span.end - begin : 0);
}

std::string_view SourceFile::line(int number) const {
  if (number < 1 || number > n_lines()) return {};
  const std::size_t begin = line_begin(number);
  const std::size_t end = number < n_lines() ? line_begin(number + 1) - 1 : text_.size();
  std::string_view result = text().substr(begin, end - begin);
  if (result.ends_with('\r')) result.remove_suffix(1);
  return result;
}

std::uint32_t SourceFile::line_begin(int number) const {
  return line_begin_[static_cast<std::size_t>(number - 1)];
}

Position SourceFile::position(std::uint32_t offset) const {
  offset = std::min(offset, static_cast<std::uint32_t>(text_.size()));
  const auto next = std::upper_bound(line_begin_.begin(), line_begin_.end(), offset);
  const auto number = static_cast<int>(next - line_begin_.begin());
  // A span may end between CR and LF; the column stays within the visible line.
  const std::size_t column =
      std::min<std::size_t>(offset - line_begin(number), line(number).size());
  return {number, 1 + static_cast<int>(utf8::count(line(number).substr(0, column)))};
}

int SourceMap::add(std::string path, std::string text) {
  const int id = n_files();
  files_.emplace_back(id, std::move(path), std::move(text));
  return id;
}

Position SourceMap::begin(const Span& span) const { return file(span.file).position(span.begin); }

Position SourceMap::end(const Span& span) const { return file(span.file).position(span.end); }

std::string_view SourceMap::text(const Span& span) const { return file(span.file).text(span); }

std::optional<std::string> read_text(const std::string& path, std::size_t limit) {
  return solver::read_file(path, limit + 1);
}

} // namespace hvi::lang
