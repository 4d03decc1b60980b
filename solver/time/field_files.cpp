// The VTU and PVD files of one `fields` item; see field_files.hpp.
#include "solver/time/field_files.hpp"

#include "solver/time/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {
namespace {

std::string safe_name(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
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
  int number = 0;
  for (const FieldGrid& one : grids_.fill(snapshot)) {
    const bool body = one.name.empty();
    write_vtu(one.grid, body ? 0 : ++number,
              fmt::format("{}_{}{:05}.vtu", stem_, body ? "" : safe_name(one.name) + "_",
                          snapshot.step()),
              snapshot.t(), written);
  }
  write_atomically(folder_ / (stem_ + ".pvd"), pvd_bytes(entries_));
}

void FieldFiles::write_collection() const {
  if (resumed_ && !entries_.empty())
    write_atomically(folder_ / (stem_ + ".pvd"), pvd_bytes(entries_));
}

} // namespace hvi::solver
