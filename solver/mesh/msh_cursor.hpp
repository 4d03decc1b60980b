// Reading position in the bytes of an MSH file: numbers in ascii or binary, either byte order, with
// an error that says where. Internal to read_msh.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hvi::solver {

class MshCursor {
public:
  MshCursor(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  /// From here on numbers are binary, with their bytes reversed if `swap`.
  void set_binary(bool swap) { binary_ = true, swap_ = swap; }
  bool binary() const { return binary_; }

  /// The next number as the format writes it: int (4 bytes), size_t (8 bytes), double. `what` names
  /// it in the error.
  std::int64_t integer(const char* what);
  std::int64_t size(const char* what);
  double real(const char* what);
  /// A count of items that take at least `ascii` or `binary` bytes each: never more than fit into
  /// the bytes left, so that a wrong count cannot make us allocate.
  std::size_t count(std::int64_t value, std::size_t ascii, std::size_t binary,
                    const char* what) const;

  /// Numbers that are text in binary files too.
  std::int64_t text_integer(const char* what);
  double text_real(const char* what);
  std::int32_t binary_integer(const char* what);

  /// White space is skipped first: a word; a quoted text.
  std::string_view word();
  std::string_view quoted(const char* what);
  void expect(std::string_view wanted);
  /// Ends the line: what follows is binary data.
  void end_line();
  bool at_end();
  /// Goes behind the next `wanted`.
  void skip_to(std::string_view wanted);

  /// "slab.msh: line 12" or "slab.msh: byte 1042".
  std::string where() const;
  [[noreturn]] void fail(const std::string& what) const;

private:
  void skip_space();
  template <typename T>
  T raw(const char* what);
  template <typename T>
  T parsed(const char* what, const char* kind);

  std::string_view bytes_;
  std::string name_;
  std::size_t pos_ = 0;
  bool binary_ = false, swap_ = false;
};

} // namespace hvi::solver
