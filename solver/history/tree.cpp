// The moment tree: the fields of recent steps are stored themselves ("raw"), older ones as blocks
// of Chebyshev moments of u, which are merged in pairs as they age. The kernel need only be smooth
// away from lag 0. Where the coming times are known, all nodes but the newest, which still grows
// (the "open" one), are read once for as many steps as it will hold.
//
// Moments and merging are the upward pass of W. Fong, E. Darve, The black-box fast multipole
// method, J. Comput. Phys. 228 (2009) 8712-8725, in one dimension. Another way to sum a memory in
// blocks of growing length, for kernels with a known Laplace transform: A. Schaedle, M.
// Lopez-Fernandez, C. Lubich, Fast and oblivious convolution quadrature, SIAM J. Sci. Comput. 28
// (2006) 421-438.
#include "solver/common/stream.hpp"
#include "solver/history/fields.hpp"
#include "solver/history/horizon.hpp"
#include "solver/history/node_weights.hpp"
#include "solver/history/routes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace hvi::solver {

namespace {

constexpr std::uint32_t tree_magic = 0x54524532;

/// What all nodes but the open one contribute to the memory at coming times.
struct Ahead {
  std::vector<double> times, fields; ///< a field for each time
  void clear() { times.clear(), fields.clear(); }
  bool knows(double t) const { return std::ranges::find(times, t) != times.end(); }
};

/// Three moments for two digits: the fewest fields over the kernels tried (singular, aging,
/// oscillating); 8 moments at 1e-8 keep up to twice as many blocks.
int moment_count(double tolerance) {
  return std::clamp(static_cast<int>(std::ceil(-1.5 * std::log10(tolerance) - 1e-9)), 4, 16);
}

class TreeHistory final : public History {
public:
  TreeHistory(const PreparedKernel& kernel, std::size_t n, const HistoryOptions& options,
              std::string why)
      : kernel_(kernel),
        moments_(moment_count(options.tolerance)), shape_{n, options.order, moments_.count()},
        options_(options), why_(std::move(why)), accepted_(options.shortest_step),
        test_(kernel_, moments_, options), tree_(shape_),
        weights_(kernel_, moments_, options.order) {}

  void start(double t0, std::span<const double> u0) override {
    accepted_.start(t0);
    ahead_.clear();
    weights_.reset();
    if (options_.horizon > 0) test_.extend(t0, options_.horizon);
    if (shape_.order == 1) check_field(kernel_, shape_.n, u0.size());
    tree_.start(t0, u0);
  }

  void rhs(double t_new, std::span<double> out) override {
    check_field(kernel_, shape_.n, out.size());
    check_step(kernel_, accepted_.now(), t_new);
    look_ahead(t_new);
    const auto known = std::find(ahead_.times.begin(), ahead_.times.end(), t_new);
    const bool is_known = known != ahead_.times.end();
    if (is_known) {
      const auto column = static_cast<std::size_t>(known - ahead_.times.begin());
      std::copy_n(ahead_.fields.data() + column * shape_.n, shape_.n, out.begin());
    } else {
      std::fill(out.begin(), out.end(), 0.0);
    }
    const std::size_t first = is_known ? tree_.nodes().size() - 1 : 0;
    const auto weights = weights_.of_nodes(tree_, accepted_, first, t_new);
    std::vector<Combination> parts;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      parts.push_back({weights[i], tree_.nodes()[first + i].fields.data()});
      reads_ += static_cast<std::int64_t>(weights[i].size());
    }
    add_combinations(parts, out);
  }

  double w0(double t_new) override {
    check_step(kernel_, accepted_.now(), t_new);
    const Moments m = weights_.current(accepted_, t_new);
    return shape_.order == 0 ? m.zero : m.zero - m.one;
  }

  void commit(double t_new, std::span<const double> u_new) override {
    check_field(kernel_, shape_.n, u_new.size());
    check_step(kernel_, accepted_.now(), t_new);
    accepted_.accept(t_new);
    const bool full = tree_.accept(t_new, u_new);
    watch_horizon(t_new);
    if (const double reach = kernel_.traits.max_lag; reach > 0) tree_.forget(t_new, reach);
    if (full) { // until then the nodes stay as `ahead_` has read them
      ahead_.clear();
      tree_.compress(moments_, test_, accepted_.start_time(), t_new);
    }
  }

  const HorizonEnd* ended() const override { return ended_ ? &*ended_ : nullptr; }

  HistoryReport report() const override {
    HistoryReport r;
    r.route = "tree";
    r.why = why_;
    for (const TimeNode& node : tree_.nodes()) {
      r.fields += shape_.n == 0 ? 0 : static_cast<std::int64_t>(node.fields.size() / shape_.n);
      r.bytes += 8.0 * static_cast<double>(node.fields.size());
      r.error += node.error;
    }
    r.fields += static_cast<std::int64_t>(ahead_.times.size());
    r.bytes += 8.0 * static_cast<double>(ahead_.fields.size());
    r.verified = false; // the tests of the blocks are samples
    r.reads = reads_;
    return r;
  }

  void save(std::ostream& out) const override {
    StateWriter w(out);
    w.put(tree_magic);
    w.put(static_cast<std::uint64_t>(shape_.n));
    w.put(shape_.order);
    w.put(static_cast<std::uint64_t>(shape_.leaf()));
    accepted_.save(w);
    w.put(test_.horizon());
    w.put(ahead_.times);
    w.put(ahead_.fields);
    tree_.save(w);
  }

  void restore(std::istream& in) override {
    StateReader r(in, kernel_.spec.origin);
    r.expect(tree_magic, "route");
    r.expect(static_cast<std::uint64_t>(shape_.n), "number of unknowns");
    r.expect(shape_.order, "order");
    r.expect(static_cast<std::uint64_t>(shape_.leaf()), "tolerance");
    accepted_.restore(r);
    weights_.reset();
    // Blocks are made for twice the time that has passed, or for the planned end.
    const double planned = options_.horizon, elapsed = accepted_.now() - accepted_.start_time();
    if (const double horizon = r.get_between(0.0, 4 * std::max(elapsed, planned)); horizon > 0) {
      test_.extend(accepted_.start_time(), horizon);
    }
    ahead_.times = r.get_numbers();
    ahead_.fields = r.get_numbers();
    if (ahead_.fields.size() != ahead_.times.size() * shape_.n) r.fail("is inconsistent");
    tree_.restore(r, accepted_);
  }

private:
  /// Fills `ahead_` for the planned times from t_new on until the open node is full. What is read
  /// depends on the saved state only, so a resumed run has the same bits.
  void look_ahead(double t_new) {
    if (ahead_.knows(t_new)) return;
    const auto& nodes = tree_.nodes();
    const auto planned = options_.times;
    const auto first = std::lower_bound(planned.begin(), planned.end(), t_new);
    const std::size_t room = shape_.leaf() + 1 - nodes.back().times.size();
    const auto count = std::min(room, static_cast<std::size_t>(planned.end() - first));
    if (nodes.size() < 2 || count < 2 || *first != t_new) return;
    ahead_.times.assign(first, first + static_cast<std::ptrdiff_t>(count));
    ahead_.fields.assign(count * shape_.n, 0.0);
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      const auto columns = weights_.at_times(tree_, accepted_, nodes[i], ahead_.times);
      reads_ += static_cast<std::int64_t>(columns.size() / count);
      add_columns(columns, nodes[i].fields.data(), columns.size() / count, shape_.n, ahead_.fields);
    }
  }

  /// Beyond the horizon all blocks are asked again, for the longer time.
  void watch_horizon(double now) {
    const double elapsed = now - accepted_.start_time();
    if (test_.horizon() > 0 && elapsed <= test_.horizon() * (1 + 1e-9)) return;
    test_.extend(accepted_.start_time(), 2 * elapsed);
    const double total = tree_.errors(test_, accepted_.start_time(), now);
    if (total <= options_.tolerance) return;
    ended_ = HorizonEnd{
        kernel_.spec.origin,
        fmt::format("the memory `{}` was compressed for an earlier end time; continued to "
                    "{:.6g} it would be within {:.1e} only",
                    kernel_.spec.name, now, total),
        "run from the start with the longer end time"};
  }

  PreparedKernel kernel_;
  ChebyshevMoments moments_;
  TimeTree::Shape shape_;
  HistoryOptions options_;
  std::string why_;
  AcceptedSteps accepted_;
  BlockTest test_;
  TimeTree tree_;
  NodeWeights weights_;
  std::optional<HorizonEnd> ended_;
  Ahead ahead_;
  std::int64_t reads_ = 0;
};

} // namespace

std::unique_ptr<History> make_tree(const PreparedKernel& kernel, std::size_t n,
                                   const HistoryOptions& options, std::string why) {
  return std::make_unique<TreeHistory>(kernel, n, options, std::move(why));
}

} // namespace hvi::solver
