// The file a run can go on from; see checkpoint.hpp. Called by the loop in run.cpp.
#include "solver/time/checkpoint.hpp"

#include "solver/common/hash.hpp"
#include "solver/common/read_file.hpp"
#include "solver/kernel/table.hpp"
#include "solver/output/file.hpp"

#define XXH_INLINE_ALL
#include <fmt/format.h>

#include <xxhash.h>

#include <cstring>
#include <set>

namespace hvi::solver {
namespace {

constexpr std::uint32_t format_version = 21;
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

/// The values of tables: an expression's text holds only their names.
class TableVisitor {
public:
  explicit TableVisitor(Hash& hash) : hash_(hash) {}
  void visit(const Expr& e) {
    if (!seen_.insert(e.id()).second) return;
    if (e.op() == Op::table || e.op() == Op::table_slope) {
      const Table& table = *e.table();
      hash_.add_number(static_cast<int>(table.interpolation()));
      hash_.add_all(table.abscissae());
      for (const double x : table.abscissae()) hash_.add_number(table.value(x));
    }
    for (const Expr& a : e.args()) visit(a);
  }
  void visit(const std::vector<Expr>& all) {
    for (const Expr& e : all) visit(e);
  }
  void visit(const RegionSpec& region) {
    visit(region.predicate);
    for (const auto& child : region.children) visit(child);
  }

private:
  Hash& hash_;
  std::set<const void*> seen_;
};

void add_tables(const Plan& plan, Hash& hash) {
  TableVisitor tables(hash);
  for (const auto& part : plan.problem.parts) tables.visit(part.region);
  for (const auto& d : plan.problem.space.dirichlet) tables.visit(d.value);
  for (const auto& form : plan.problem.forms)
    for (const auto& entry : form.entries) tables.visit(entry.coefficient);
  for (const auto& load : plan.problem.loads)
    for (const auto& entry : load.entries) tables.visit(entry.value);
  for (const auto& history : plan.problem.histories) tables.visit(history.kernel.expression);
  for (const auto& law : plan.problem.laws) {
    tables.visit(law.expression);
    tables.visit(law.readings);
  }
  for (const auto& term : plan.problem.law_terms) {
    tables.visit(term.factor);
    for (const auto& row : term.rows) {
      tables.visit(row.offset);
      for (const auto& c : row.u) tables.visit(c);
    }
  }
  for (const auto& state : plan.problem.states) {
    tables.visit(state.rate);
    tables.visit(state.initial);
  }
  tables.visit(plan.problem.time.initial);
  for (const auto& probe : plan.report.probes) tables.visit(probe.expression);
  for (const auto& fields : plan.report.fields)
    for (const auto& field : fields.fields) tables.visit(field.components);
  for (const auto& picture : plan.report.pictures) tables.visit(picture.field.components);
  for (const auto& line : plan.report.lines)
    for (const auto& field : line.fields) tables.visit(field.components);
}

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

} // namespace

std::uint64_t fingerprint(const Plan& plan, const Mesh& mesh) {
  Hash hash;
  Plan same = plan; // what may differ between two places or machines is left out
  same.problem.mesh.path.clear();
  same.options.threads = 1;
  same.options.solver = {};       // memory may choose it: saved state
  same.options.factor = {};       // a step that is not certified changes it: saved state
  same.problem.time.grid.clear(); // a run may go on beyond its end: the state knows the steps taken
  for (auto& history : same.problem.histories)
    history.route.reset(); // audits choose it: saved state
  hash.add(to_string(same));
  hash.add_number(plan.options.proportional_path);
  hash.add_number(plan.options.jumps_as_unknowns);
  hash.add_number(plan.options.reduced_precision);
  hash.add_number(plan.options.audit);
  add_tables(plan, hash);
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
  if (header.version != format_version || header.byte_order != Header{}.byte_order)
    refuse_checkpoint(path, fmt::format("has format {}, this program reads format {}",
                                        header.version, format_version));
  if (header.header_hash != header_hash(header) || header.size != bytes.size() - sizeof header ||
      header.state_hash != hash_of(std::string_view(bytes).substr(sizeof header)))
    refuse_checkpoint(path, "is damaged: its hash does not fit its content");
  if (header.fingerprint != fingerprint)
    refuse_checkpoint(path, "belongs to another problem: the script, its parameters or its mesh "
                            "have changed");
  return bytes.substr(sizeof header);
}

} // namespace hvi::solver
