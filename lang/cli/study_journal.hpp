// The rows that an interrupted study has finished: a line of JSON each, in its folder.
#pragma once

#include "lang/study.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace hvi::lang {

class StudyJournal {
public:
  explicit StudyJournal(std::filesystem::path file) : file_(std::move(file)) {}
  std::string name() const { return file_.filename().string(); }

  /// Fills in the rows that were finished, if nothing that decides them has changed: `deciding` is
  /// all of it, as text. A line whose checksum does not fit is as if it were not there.
  void read(const std::string& deciding, std::vector<StudyRow>& rows);
  bool has(const StudyRow& row) const;
  void keep(const StudyRow& row);

private:
  std::filesystem::path file_;
  std::string fingerprint_;
  std::vector<std::map<std::string, std::string>> done_;
  bool warned_ = false; ///< of a journal that cannot be written
};

} // namespace hvi::lang
