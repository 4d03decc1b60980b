// How much memory this process may still take, and the refusal of what needs more. Asked before
// something large is allocated: a system that hands out pages only when they are touched would end
// the process in the middle of it, without a word.
#pragma once

#include "solver/common/failure.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace hvi::solver {

struct MemoryRoom {
  double bytes = 0.0; ///< that may be taken beyond what is held; infinite: nothing is known
  std::string from;   ///< what sets the limit
};

/// The least of: the limits of address space and data of this process less what it has, those of
/// its control groups less what they use, and what the machine has available (MemAvailable; swap
/// does not count).
MemoryRoom memory_room();

/// What the control groups from `folder` up to `top` leave: version 2 (memory.max, memory.current)
/// or 1 (memory.limit_in_bytes, memory.usage_in_bytes); files in the page cache count as free.
std::optional<double> control_group_room(std::filesystem::path folder,
                                         const std::filesystem::path& top);

/// What this process holds now, and the most it has held: its resident set.
double memory_held();
double memory_peak();

/// "1.25 GB".
std::string bytes_text(double bytes);

/// Throws Failure(too_large) where `bytes` more than what is held do not fit: `what` names them
/// ("the factor of 555003 unknowns"). Small amounts are not checked: a check takes as long as a
/// small run.
inline constexpr double little_memory = 32e6;
void require_memory(double bytes, const std::string& what);

} // namespace hvi::solver
