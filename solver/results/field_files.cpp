// The VTU and PVD files of one `fields` item; see field_files.hpp.
#include "solver/results/field_files.hpp"

#include "solver/common/hash.hpp"
#include "solver/common/read_file.hpp"
#include "solver/linear/vector_stream.hpp"
#include "solver/plan/result_files.hpp"

#include <fmt/format.h>

#include <utility>

namespace hvi::solver {
namespace {

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
                       std::string stem, Durability durability, int processes)
    : grids_(problem, d, contact, spec.fields), units_(std::move(units)),
      folder_(std::move(folder)), stem_(std::move(stem)), durability_(durability) {
  if (processes > 1) pieces_.emplace(d.space, processes);
}

void FieldFiles::note(const std::string& name, std::uint64_t hash, int part, double t,
                      std::vector<std::string>& written) {
  const auto inside = std::filesystem::path(name).filename().string();
  files_.push_back({{t, part, inside}, hash}); // the collection stands beside its files
  written.push_back(name);
}

void FieldFiles::write_vtu(const VtuGrid& grid, int part, const std::string& name, double t,
                           std::vector<std::string>& written) {
  const std::string bytes = vtu_bytes(grid, units_);
  write_atomically(folder_ / (name + ".vtu"), bytes, durability_);
  note(name + ".vtu", hash_of(bytes), part, t, written);
}

void FieldFiles::write_pieces(const VtuGrid& grid, const std::string& name, double t,
                              std::vector<std::string>& written) {
  const auto hashes = pieces_->write(grid, units_, folder_, name, durability_);
  std::vector<std::string> beside; // as the file that names them sees them
  for (std::size_t p = 0; p < hashes.size(); ++p) {
    note(name_of_piece(name, p), hashes[p], -1, t, written);
    beside.push_back(files_.back().entry.file);
  }
  const std::string bytes = pvtu_bytes(grid, units_, beside);
  write_atomically(folder_ / (name + ".pvtu"), bytes, durability_);
  note(name + ".pvtu", hash_of(bytes), 0, t, written);
}

std::string FieldFiles::collection() const {
  std::vector<PvdEntry> entries;
  for (const Written& file : files_)
    if (file.entry.part >= 0) entries.push_back(file.entry);
  return pvd_bytes(entries);
}

void FieldFiles::write(const Snapshot& snapshot, std::vector<std::string>& written) {
  int number = 0;
  for (const FieldGrid& one : grids_.fill(snapshot)) {
    const bool body = one.name.empty();
    const std::string name = fmt::format("{}_{:05}", series_stem(stem_, one.name), snapshot.step());
    if (body && pieces_)
      write_pieces(one.grid, name, snapshot.t(), written);
    else
      write_vtu(one.grid, body ? 0 : ++number, name, snapshot.t(), written);
  }
  write_atomically(folder_ / (stem_ + ".pvd"), collection());
  if (!std::exchange(collected_, true)) written.push_back(stem_ + ".pvd");
}

void FieldFiles::write_collection() const {
  if (resumed_ && !files_.empty()) write_atomically(folder_ / (stem_ + ".pvd"), collection());
}

void FieldFiles::save(std::ostream& out) const {
  StateWriter w(out);
  w.put(static_cast<std::uint64_t>(files_.size()));
  for (const Written& file : files_) {
    w.put(file.entry.time);
    w.put(file.entry.part);
    put_text(w, file.entry.file);
    w.put(file.hash);
  }
}

void FieldFiles::restore(std::istream& in) {
  StateReader r(in, {});
  files_.clear();
  for (auto left = r.get<std::uint64_t>(); left > 0; --left) {
    const double time = r.get<double>();
    const int part = r.get<int>();
    std::string name = get_text(r);
    files_.push_back({{time, part, std::move(name)}, r.get<std::uint64_t>()});
  }
  const auto beside = (folder_ / stem_).parent_path();
  for (const Written& file : files_) {
    const auto path = beside / std::filesystem::path(file.entry.file).filename();
    if (const auto wrong = what_is_wrong(path, file.hash); !wrong.empty())
      r.fail("counts on the file `" + path.string() + "`, which " + wrong);
  }
  resumed_ = true, collected_ = !files_.empty();
}

} // namespace hvi::solver
