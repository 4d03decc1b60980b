// The file a run can go on from; see checkpoint.hpp. Called by the loop in run.cpp.
#include "solver/time/checkpoint.hpp"

#include "solver/common/hash.hpp"
#include "solver/common/read_file.hpp"
#include "solver/kernel/table.hpp"
#include "solver/output/file.hpp"
#include "solver/plan/fields.hpp"

#define XXH_INLINE_ALL
#include <fmt/format.h>

#include <xxhash.h>

#include <cstring>
#include <memory>
#include <type_traits>
#include <unordered_map>

namespace hvi::solver {
namespace {

constexpr std::uint32_t format_version = 24;
constexpr std::array<char, 8> magic{'h', 'v', 'i', '-', 's', 't', 'e', 'p'};

struct Header {
  std::array<char, 8> magic_word = magic;
  std::uint32_t version = format_version;
  std::uint32_t byte_order = 0x01020304;
  std::uint64_t fingerprint = 0, size = 0, state_hash = 0, header_hash = 0;
};

/// Of all before the hash itself.
std::uint64_t header_hash(const Header& header) {
  return hash_of({reinterpret_cast<const char*>(&header), offsetof(Header, header_hash)});
}

/// A hash that grows piece by piece.
class Hash {
public:
  Hash() { XXH3_64bits_reset(&state_); }
  void add(const void* bytes, std::size_t size) { XXH3_64bits_update(&state_, bytes, size); }
  void add(std::string_view text) {
    add_number(text.size());
    add(text.data(), text.size());
  }
  template <class T>
  void add_number(T value) {
    add(&value, sizeof value);
  }
  template <class T>
  void add_all(const std::vector<T>& values) {
    add_number(values.size());
    add(values.data(), values.size() * sizeof(T));
  }
  std::uint64_t value() const { return XXH3_64bits_digest(&state_); }

private:
  XXH3_state_t state_{};
};

/// Adds every field of a plan, and whatever it is made of.
class PlanHash {
public:
  explicit PlanHash(Hash& hash) : hash_(hash) {}

  template <class T>
  void add(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
      hash_.add_number(value);
    else
      std::apply([&](const auto&... field) { (add(field), ...); }, fields_of(value));
  }
  void add(const std::string& text) { hash_.add(text); }
  void add(const Expr& expression) { hash_.add_number(hash_of_tree(expression)); }
  template <class T>
  void add(const std::vector<T>& all) {
    hash_.add_number(all.size());
    for (const T& one : all) add(one);
  }
  template <class T, std::size_t N>
  void add(const std::array<T, N>& all) {
    for (const T& one : all) add(one);
  }
  template <class T>
  void add(const std::optional<T>& value) {
    hash_.add_number(value.has_value());
    if (value) add(*value);
  }
  template <class A, class B>
  void add(const std::pair<A, B>& both) {
    add(both.first), add(both.second);
  }
  template <class... T>
  void add(const std::variant<T...>& value) {
    hash_.add_number(value.index());
    std::visit([&](const auto& one) { add(one); }, value);
  }
  void add(const std::shared_ptr<const Plan>& plan) {
    hash_.add_number(plan != nullptr);
    if (plan) add(*plan);
  }

private:
  /// Of a tree, whichever of its parts it shares with itself: first of the parts. Trees are deeper
  /// than a stack of calls.
  std::uint64_t hash_of_tree(const Expr& root) {
    std::vector<const Expr*> todo{&root};
    while (!todo.empty()) {
      const Expr& e = *todo.back();
      const std::size_t waiting = todo.size();
      for (const Expr& part : e.args())
        if (!known_.contains(part.id())) todo.push_back(&part);
      if (todo.size() > waiting) continue;
      known_.emplace(e.id(), hash_of_node(e));
      todo.pop_back();
    }
    return known_.at(root.id());
  }

  /// Of tables the values.
  std::uint64_t hash_of_node(const Expr& e) const {
    Hash own;
    own.add_number(e.op());
    if (e.op() == Op::constant) own.add_number(e.value());
    if (e.op() == Op::slot) own.add_number(e.slot());
    if (const auto& table = e.table()) {
      own.add_number(table->interpolation());
      own.add_all(table->abscissae());
      for (const double x : table->abscissae()) own.add_number(table->value(x));
    }
    for (const Expr& part : e.args()) own.add_number(known_.at(part.id()));
    return own.value();
  }

  Hash& hash_;
  std::unordered_map<const void*, std::uint64_t> known_;
};

void add_mesh(const Mesh& mesh, Hash& hash) {
  hash.add_number(mesh.dim);
  if (mesh.axisymmetric) hash.add_number(1);
  hash.add_all(mesh.nodes);
  hash.add_all(mesh.cells);
  hash.add_number(mesh.facets.size());
  for (const auto& facet : mesh.facets) {
    for (const auto node : facet.nodes) hash.add_number(node);
    hash.add_number(facet.cell);
    hash.add_number(facet.other);
  }
  for (const auto& [name, group] : mesh.groups) {
    hash.add(name);
    hash.add_number(static_cast<int>(group.kind));
    hash.add_all(group.entities);
  }
}

/// Without what may differ between two places or machines, or is saved with a state.
Plan decisive(Plan plan) {
  plan.problem.mesh.path.clear();
  plan.problem.mesh.allow_geo = false;
  plan.options.threads = 1;
  plan.options.solver = {}; // memory may choose it
  plan.options.factor = {}; // a step that is not certified changes it, and this
  plan.options.rows_refused = false;
  plan.problem.time.grid.clear(); // a run may go on beyond its end: the state knows the steps taken
  for (auto& history : plan.problem.histories) history.route.reset(); // audits choose it
  if (plan.start) plan.start = std::make_shared<const Plan>(decisive(*plan.start));
  return plan;
}

} // namespace

std::uint64_t fingerprint(const Plan& plan, const Mesh& mesh) {
  const Plan of = decisive(plan); // trees are known by where they are, as long as this lives
  Hash hash;
  PlanHash(hash).add(of);
  add_mesh(mesh, hash);
  return hash.value();
}

std::filesystem::path checkpoint_path(const std::string& folder, const std::string& name) {
  return std::filesystem::path(folder) / (name + ".checkpoint");
}

void write_checkpoint(const std::filesystem::path& path, std::uint64_t fingerprint,
                      std::string_view state) {
  Header header;
  header.fingerprint = fingerprint;
  header.size = state.size();
  header.state_hash = hash_of(state);
  header.header_hash = header_hash(header);
  std::string bytes(sizeof header, '\0');
  std::memcpy(bytes.data(), &header, sizeof header);
  bytes += state;
  write_atomically(path, bytes, Durability::synced);
}

void refuse_checkpoint(const std::filesystem::path& path, const std::string& why) {
  throw Failure(FailureKind::bad_checkpoint, {}, "the checkpoint `" + path.string() + "` " + why);
}

std::string read_checkpoint(const std::filesystem::path& path, std::uint64_t fingerprint) {
  const auto found = read_file(path);
  if (!found) refuse_checkpoint(path, "cannot be read");
  const std::string& bytes = *found;
  Header header;
  if (bytes.size() < sizeof header) refuse_checkpoint(path, "ends too early");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic_word != magic) refuse_checkpoint(path, "is no checkpoint");
  if (header.byte_order == __builtin_bswap32(Header{}.byte_order))
    refuse_checkpoint(path, "was written on a machine with another order of bytes");
  if (header.byte_order != Header{}.byte_order)
    refuse_checkpoint(path, "is damaged: it has no order of bytes");
  if (header.version != format_version)
    refuse_checkpoint(path, fmt::format("has format {}, this program reads format {}",
                                        header.version, format_version));
  if (header.header_hash != header_hash(header) || header.size != bytes.size() - sizeof header ||
      header.state_hash != hash_of(std::string_view(bytes).substr(sizeof header)))
    refuse_checkpoint(path, "is damaged: its hash does not fit its content");
  if (header.fingerprint != fingerprint)
    refuse_checkpoint(path, "belongs to another problem: the script, its parameters, its mesh or "
                            "how it is to be solved have changed");
  return bytes.substr(sizeof header);
}

} // namespace hvi::solver
