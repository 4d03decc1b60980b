// The VTU and PVD files of one `fields` item; see field_files.hpp.
#include "solver/results/field_files.hpp"

#include "solver/common/hash.hpp"
#include "solver/common/read_file.hpp"
#include "solver/linear/vector_stream.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {
namespace {

std::string safe_name(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

/// "" when the file holds the bytes it was written with.
std::string what_is_wrong(const std::filesystem::path& path, std::uint64_t hash) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return "is gone";
  const auto bytes = read_file(path);
  if (!bytes) return "cannot be read";
  if (bytes->empty()) return "is empty";
  return hash_of(*bytes) == hash ? "" : "was changed since";
}

} // namespace

FieldFiles::FieldFiles(const Problem& problem, const Discretisation& d, const Contact& contact,
                       const FieldsSpec& spec, VtuUnits units, std::filesystem::path folder,
                       std::string stem, Durability durability)
    : grids_(problem, d, contact, spec.fields), units_(std::move(units)),
      folder_(std::move(folder)), stem_(std::move(stem)), durability_(durability) {}

void FieldFiles::write_vtu(const VtuGrid& grid, int part, const std::string& name, double t,
                           std::vector<std::string>& written) {
  const std::string bytes = vtu_bytes(grid, units_);
  write_atomically(folder_ / name, bytes, durability_);
  const auto inside = std::filesystem::path(name).filename().string();
  entries_.push_back({t, part, inside}); // the collection stands beside its files
  hashes_.push_back(hash_of(bytes));
  written.push_back(name);
}

void FieldFiles::write(const Snapshot& snapshot, std::vector<std::string>& written) {
  const bool first = entries_.empty();
  int number = 0;
  for (const FieldGrid& one : grids_.fill(snapshot)) {
    const bool body = one.name.empty();
    write_vtu(one.grid, body ? 0 : ++number,
              fmt::format("{}_{}{:05}.vtu", stem_, body ? "" : safe_name(one.name) + "_",
                          snapshot.step()),
              snapshot.t(), written);
  }
  const std::string collection = stem_ + ".pvd";
  write_atomically(folder_ / collection, pvd_bytes(entries_));
  if (first) written.push_back(collection);
}

void FieldFiles::write_collection() const {
  if (resumed_ && !entries_.empty())
    write_atomically(folder_ / (stem_ + ".pvd"), pvd_bytes(entries_));
}

void FieldFiles::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(static_cast<std::uint64_t>(entries_.size()));
  for (const auto& entry : entries_) {
    w.put(entry.time);
    w.put(entry.part);
    put_text(w, entry.file);
  }
  w.put(hashes_);
}

void FieldFiles::restore(std::istream& in) {
  StateReader r(in, {});
  entries_.clear();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
    const double time = r.get<double>();
    const int part = r.get<int>();
    entries_.push_back({time, part, get_text(r)});
  }
  hashes_ = r.get_vector<std::uint64_t>();
  if (hashes_.size() != entries_.size()) r.fail("names files without their content");
  const auto beside = (folder_ / stem_).parent_path();
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto path = beside / std::filesystem::path(entries_[i].file).filename();
    if (const auto wrong = what_is_wrong(path, hashes_[i]); !wrong.empty())
      r.fail("counts on the file `" + path.string() + "`, which " + wrong);
  }
  resumed_ = true;
}

} // namespace hvi::solver
