// The file a run can be resumed from: header, hashes, and the state as bytes.
#pragma once

#include "solver/plan/plan.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace hvi::solver {

/// A checkpoint that cannot be used, and why.
[[noreturn]] void refuse_checkpoint(const std::filesystem::path& path, const std::string& why);

/// A hash of everything that decides the numbers of a run: forms, laws, kernels, loads, tables,
/// options, report, mesh. Neither paths nor the number of threads are in it, nor the time grid: a
/// state can be continued when its steps are the first ones of the grid (restarts.cpp).
std::uint64_t fingerprint(const Plan& plan, const Mesh& mesh);

/// Where the checkpoint of a run stands.
std::filesystem::path checkpoint_path(const std::string& folder, const std::string& name);

/// Header (magic, format version, fingerprint, size, hash of the state) and state; synced to the
/// disk before they replace the old file. Throws Failure(output).
void write_checkpoint(const std::filesystem::path& path, std::uint64_t fingerprint,
                      std::string_view state);
/// The state again. Throws Failure(bad_checkpoint) when any bit of the file is not what was
/// written, or when it belongs to another problem.
std::string read_checkpoint(const std::filesystem::path& path, std::uint64_t fingerprint);

} // namespace hvi::solver
