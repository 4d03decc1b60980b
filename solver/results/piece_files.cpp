// See piece_files.hpp. Used by FieldFiles in the first process, and by all others.
#include "solver/results/piece_files.hpp"

#include "solver/common/hash.hpp"
#include "solver/linear/processes.hpp"
#include "solver/mesh/cell_parts.hpp"

#include <fmt/format.h>

#include <sstream>

namespace hvi::solver {
namespace {

struct Message {
  std::string path;
  Durability durability;
  VtuUnits units;
  VtuGrid grid;
};

std::string bytes_of(const Message& message) {
  std::ostringstream out;
  StateWriter w(out);
  put_text(w, message.path);
  w.put(message.durability);
  put_text(w, message.units.time);
  put_text(w, message.units.length);
  put_grid(w, message.grid);
  return std::move(out).str();
}

Message message_of(std::string_view bytes) {
  std::istringstream in{std::string(bytes)};
  StateReader r(in, {});
  Message out;
  out.path = get_text(r);
  out.durability = r.get<Durability>();
  out.units.time = get_text(r);
  out.units.length = get_text(r);
  out.grid = get_grid(r);
  return out;
}

/// What became of a piece.
struct Answer {
  std::uint64_t hash = 0;
  std::optional<Failure> failure;
};

std::string bytes_of(const Answer& answer) {
  std::ostringstream out;
  StateWriter w(out);
  w.put(answer.hash);
  w.put(std::uint8_t{answer.failure.has_value()});
  if (answer.failure) {
    w.put(answer.failure->kind);
    put_text(w, answer.failure->what());
    put_text(w, answer.failure->help);
  }
  return std::move(out).str();
}

/// The hash. Throws the failure.
std::uint64_t hash_in(const std::string& bytes) {
  std::istringstream in(bytes);
  StateReader r(in, {});
  const auto hash = r.get<std::uint64_t>();
  if (r.get<std::uint8_t>() == 0) return hash;
  const auto kind = r.get<FailureKind>();
  const std::string what = get_text(r), help = get_text(r);
  throw Failure(kind, {}, what, help);
}

} // namespace

std::string name_of_piece(const std::string& name, std::size_t process) {
  return fmt::format("{}_{}.vtu", name, process);
}

std::string write_piece(std::string_view message) {
  Answer out;
  try {
    const Message of = message_of(message);
    const std::string bytes = vtu_bytes(of.grid, of.units);
    write_atomically(of.path, bytes, of.durability);
    out.hash = hash_of(bytes);
  } catch (const Failure& failure) {
    out.failure = failure;
  }
  return bytes_of(out);
}

std::vector<std::uint64_t> PieceFiles::write(const VtuGrid& grid, const VtuUnits& units,
                                             const std::filesystem::path& folder,
                                             const std::string& name, Durability durability) {
  if (!pieces_) pieces_.emplace(grid, parts_of_cells(*space_.mesh, processes_), processes_);
  std::vector<std::string> messages;
  for (int p = 0; p < processes_; ++p) {
    const auto path = folder / name_of_piece(name, static_cast<std::size_t>(p));
    messages.push_back(
        bytes_of(Message{path.string(), durability, units, pieces_->piece(grid, p)}));
  }
  std::vector<std::uint64_t> out;
  for (const std::string& answer : deal_out(Errand::write_piece, messages, write_piece))
    out.push_back(hash_in(answer));
  return out;
}

} // namespace hvi::solver
