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
#include "solver/history/block_test.hpp"
#include "solver/history/fields.hpp"
#include "solver/history/horizon.hpp"
#include "solver/history/past_weights.hpp"
#include "solver/history/routes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace hvi::solver {

namespace {

constexpr std::uint32_t tree_magic = 0x54524532;

/// Steps [index * 2^level, (index + 1) * 2^level) * leaf: raw values or moments.
struct Node {
  int level = 0; ///< -1: raw
  std::int64_t index = 0;
  TimeBlock block;
  double next_test = 0;
  double error = 0;
  std::vector<double> times;  ///< of raw steps
  std::vector<double> fields; ///< raw values (order 1: also the one before), or moments
  bool raw() const { return level < 0; }
};

/// What all nodes but the open one contribute to the memory at coming times.
struct Ahead {
  std::vector<double> times, fields; ///< a field for each time
  void clear() { times.clear(), fields.clear(); }
};

class TreeHistory final : public History {
public:
  TreeHistory(const PreparedKernel& kernel, std::size_t n, const HistoryOptions& options,
              std::string why)
      : kernel_(kernel), moments_(moment_count(options.tolerance)), n_(n), order_(options.order),
        leaf_(2 * static_cast<std::size_t>(moments_.count())), options_(options),
        why_(std::move(why)), accepted_(options.shortest_step), test_(kernel_, moments_, options) {}

  void start(double t0, std::span<const double> u0) override {
    accepted_.start(t0);
    nodes_.clear();
    ahead_.clear();
    weights_.reset();
    steps_ = 0;
    if (options_.horizon > 0) test_.extend(t0, options_.horizon);
    if (order_ == 1) check_field(kernel_, n_, u0.size());
    open_node(t0, u0);
  }

  void rhs(double t_new, std::span<double> out) override {
    check_field(kernel_, n_, out.size());
    check_step(kernel_, accepted_.now(), t_new);
    look_ahead(t_new);
    const auto known = std::find(ahead_.times.begin(), ahead_.times.end(), t_new);
    const bool is_known = known != ahead_.times.end();
    if (is_known) {
      const auto column = static_cast<std::size_t>(known - ahead_.times.begin());
      std::copy_n(ahead_.fields.data() + column * n_, n_, out.begin());
    } else {
      std::fill(out.begin(), out.end(), 0.0);
    }
    collect_weights(t_new, is_known ? nodes_.size() - 1 : 0);
    for (const Combination& part : parts_) reads_ += static_cast<std::int64_t>(part.weights.size());
    add_combinations(parts_, out);
  }

  double w0(double t_new) override {
    check_step(kernel_, accepted_.now(), t_new);
    const Moments m = current(t_new);
    return order_ == 0 ? m.zero : m.zero - m.one;
  }

  void commit(double t_new, std::span<const double> u_new) override {
    check_field(kernel_, n_, u_new.size());
    check_step(kernel_, accepted_.now(), t_new);
    accepted_.accept(t_new);
    ++steps_;
    Node& last = nodes_.back();
    last.times.push_back(t_new);
    last.block.b = t_new;
    last.fields.insert(last.fields.end(), u_new.begin(), u_new.end());
    const bool full = last.times.size() == leaf_ + 1;
    if (full) open_node(t_new, u_new);
    watch_horizon(t_new);
    forget(t_new);
    if (full) { // until then the nodes stay as `ahead_` has read them
      ahead_.clear();
      compress(t_new);
    }
  }

  const HorizonEnd* ended() const override { return ended_ ? &*ended_ : nullptr; }

  HistoryReport report() const override {
    HistoryReport r;
    r.route = "tree";
    r.why = why_;
    for (const Node& node : nodes_) {
      r.fields += n_ == 0 ? 0 : static_cast<std::int64_t>(node.fields.size() / n_);
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
    w.put(static_cast<std::uint64_t>(n_));
    w.put(order_);
    w.put(static_cast<std::uint64_t>(leaf_));
    accepted_.save(w);
    w.put(test_.horizon());
    w.put(ahead_.times);
    w.put(ahead_.fields);
    w.put(static_cast<std::uint64_t>(nodes_.size()));
    for (const Node& node : nodes_) {
      w.put(node.level);
      w.put(node.index);
      w.put(node.block);
      w.put(node.next_test);
      w.put(node.error);
      w.put(node.times);
      w.put(node.fields);
    }
  }

  void restore(std::istream& in) override {
    StateReader r(in, kernel_.spec.origin);
    r.expect(tree_magic, "route");
    r.expect(static_cast<std::uint64_t>(n_), "number of unknowns");
    r.expect(order_, "order");
    r.expect(static_cast<std::uint64_t>(leaf_), "tolerance");
    accepted_.restore(r);
    weights_.reset();
    steps_ = accepted_.count();
    // Blocks are made for twice the time that has passed, or for the planned end.
    const double planned = options_.horizon, elapsed = accepted_.now() - accepted_.start_time();
    if (const double horizon = r.get_between(0.0, 4 * std::max(elapsed, planned)); horizon > 0) {
      test_.extend(accepted_.start_time(), horizon);
    }
    ahead_.times = r.get_numbers();
    ahead_.fields = r.get_numbers();
    if (ahead_.fields.size() != ahead_.times.size() * n_) r.fail("is inconsistent");
    const auto count = r.get<std::uint64_t>();
    nodes_.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      nodes_.push_back(restored_node(r));
    }
    if (nodes_.empty() || !nodes_.back().raw()) r.fail("is inconsistent");
  }

private:
  Node restored_node(StateReader& r) const {
    Node node;
    node.level = r.get_between(-1, 62);
    node.index = r.get_between<std::int64_t>(0, steps_);
    node.block.a = r.get_between(accepted_.start_time(), accepted_.now());
    node.block.b = r.get_between(node.block.a, accepted_.now());
    node.next_test = r.get_finite();
    node.error = r.get_finite();
    node.times = r.get_numbers();
    node.fields = r.get_numbers();
    bool good = node.fields.size() == fields_in(node) * n_;
    if (node.raw())
      good = good && !node.times.empty() && node.times.size() <= leaf_ + 1 &&
             std::is_sorted(node.times.begin(), node.times.end()) &&
             node.times.front() >= accepted_.start_time() && node.times.back() <= accepted_.now() &&
             steps_to_end(node) <= steps_;
    if (!good) r.fail("is inconsistent");
    return node;
  }

  /// Three moments for two digits: the fewest fields over the kernels tried (singular, aging,
  /// oscillating); 8 moments at 1e-8 keep up to twice as many blocks.
  static int moment_count(double tolerance) {
    return std::clamp(static_cast<int>(std::ceil(-1.5 * std::log10(tolerance) - 1e-9)), 4, 16);
  }

  std::size_t fields_in(const Node& node) const {
    if (!node.raw()) return static_cast<std::size_t>(moments_.count());
    return node.times.empty() ? 0 : node.times.size() - (order_ == 1 ? 0 : 1);
  }

  Moments current(double t_new) { return near_(kernel_, t_new, 0, accepted_.step_to(t_new)); }

  void open_node(double t, std::span<const double> u) {
    Node node;
    node.level = -1;
    node.index = steps_ / static_cast<std::int64_t>(leaf_);
    node.block = {t, t};
    node.times.push_back(t);
    if (order_ == 1) node.fields.assign(u.begin(), u.end());
    nodes_.push_back(std::move(node));
  }

  /// Number of accepted steps up to the end of a raw node.
  std::int64_t steps_to_end(const Node& node) const {
    return node.index * static_cast<std::int64_t>(leaf_) +
           static_cast<std::int64_t>(node.times.size()) - 1;
  }

  /// Weights of a raw node's fields at t, `ahead` steps after the next one.
  void raw_weights(const Node& node, double t, std::size_t ahead, std::vector<double>& weights) {
    const auto after = static_cast<std::size_t>(steps_ - steps_to_end(node)) + ahead;
    put_node_weights(weights_(kernel_, accepted_.common_step(t, ahead), t, node.times, after),
                     order_, weights);
  }

  /// parts_: for the nodes from `first` on their fields and their weights at t_new.
  void collect_weights(double t_new, std::size_t first) {
    lags_.clear();
    for (std::size_t i = first; i < nodes_.size(); ++i) {
      if (!nodes_[i].raw()) moments_.add_nodes(nodes_[i].block, t_new, lags_);
    }
    values_.resize(lags_.size());
    kernel_.function.evaluate(t_new, lags_, values_);
    node_weights_.resize(nodes_.size());
    parts_.clear();
    const double* values = values_.data();
    for (std::size_t i = first; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      auto& weights = node_weights_[i];
      if (node.raw()) {
        raw_weights(node, t_new, 0, weights);
      } else {
        weights.resize(static_cast<std::size_t>(moments_.count()));
        moments_.coefficients(values, weights.data());
        values += moments_.count();
      }
      parts_.push_back({weights, node.fields.data()});
    }
    if (order_ == 1) node_weights_.back().back() += current(t_new).one;
  }

  /// Fills `ahead_` for the planned times from t_new on until the open node is full. What is read
  /// depends on the saved state only, so a resumed run has the same bits.
  void look_ahead(double t_new) {
    const auto& known = ahead_.times;
    if (std::find(known.begin(), known.end(), t_new) != known.end()) return;
    const auto planned = options_.times;
    const auto first = std::lower_bound(planned.begin(), planned.end(), t_new);
    const std::size_t room = leaf_ + 1 - nodes_.back().times.size();
    const auto count = std::min(room, static_cast<std::size_t>(planned.end() - first));
    if (nodes_.size() < 2 || count < 2 || *first != t_new) return;
    ahead_.times.assign(first, first + static_cast<std::ptrdiff_t>(count));
    ahead_.fields.assign(count * n_, 0.0);
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      if (nodes_[i].raw()) {
        columns_.clear();
        std::vector<double> weights;
        for (std::size_t j = 0; j < count; ++j) {
          raw_weights(nodes_[i], ahead_.times[j], j, weights);
          columns_.insert(columns_.end(), weights.begin(), weights.end());
        }
      } else {
        moment_weights_ahead(nodes_[i]);
      }
      reads_ += static_cast<std::int64_t>(columns_.size() / count);
      add_columns(columns_, nodes_[i].fields.data(), columns_.size() / count, n_, ahead_.fields);
    }
  }

  /// columns_: weights of a node's moments at all times of `ahead_`.
  void moment_weights_ahead(const Node& node) {
    const auto moments = static_cast<std::size_t>(moments_.count());
    lags_.clear();
    times_.clear();
    for (const double t : ahead_.times) {
      moments_.add_nodes(node.block, t, lags_);
      times_.resize(lags_.size(), t);
    }
    values_.resize(lags_.size());
    kernel_.function.evaluate(times_, lags_, values_);
    columns_.resize(lags_.size());
    for (std::size_t at = 0; at < lags_.size(); at += moments)
      moments_.coefficients(&values_[at], &columns_[at]);
  }

  /// Beyond the horizon all blocks are asked again, for the longer time.
  void watch_horizon(double now) {
    const double elapsed = now - accepted_.start_time();
    if (test_.horizon() > 0 && elapsed <= test_.horizon() * (1 + 1e-9)) return;
    test_.extend(accepted_.start_time(), 2 * elapsed);
    double total = 0;
    for (Node& node : nodes_) {
      if (!node.raw()) node.error = test_.error(node.block, accepted_.start_time(), now);
      total += node.error;
    }
    if (total <= options_.tolerance) return;
    ended_ = HorizonEnd{
        kernel_.spec.origin,
        fmt::format("the memory `{}` was compressed for an earlier end time; continued to "
                    "{:.6g} it would be within {:.1e} only",
                    kernel_.spec.name, now, total),
        "run from the start with the longer end time"};
  }

  void forget(double now) {
    const double reach = kernel_.traits.max_lag;
    if (reach <= 0) return;
    const auto visible = std::find_if(nodes_.begin(), nodes_.end() - 1,
                                      [&](const Node& node) { return now - node.block.b < reach; });
    nodes_.erase(nodes_.begin(), visible);
  }

  /// One pass from old to new: raw nodes become moments, siblings merge, as the test allows. The
  /// last node is still being filled.
  void compress(double now) {
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      if (nodes_[i].raw() && now >= nodes_[i].next_test) to_moments(nodes_[i], now);
    }
    for (bool merged = true; merged;) {
      merged = false;
      for (std::size_t i = 0; i + 2 < nodes_.size() && !merged; ++i) merged = merge(i, now);
    }
  }

  /// A failed test is repeated when the block is noticeably further away.
  double later(const TimeBlock& block, double now) const {
    return now + std::max(0.25 * (block.b - block.a), 0.1 * (now - block.b));
  }

  void to_moments(Node& node, double now) {
    const auto error = test_.passes(node.block, accepted_.start_time(), now);
    if (!error) {
      node.next_test = later(node.block, now);
      return;
    }
    std::vector<double> fields(static_cast<std::size_t>(moments_.count()) * n_, 0.0);
    add_product(moments_.of_intervals(node.block, node.times, order_), node.fields.data(),
                fields.data(), n_);
    node.fields = std::move(fields);
    node.times.clear();
    node.times.shrink_to_fit();
    node.level = 0;
    node.error = *error;
    node.next_test = now;
  }

  bool merge(std::size_t i, double now) {
    Node &left = nodes_[i], &right = nodes_[i + 1];
    const bool siblings = !left.raw() && left.level == right.level && left.index % 2 == 0 &&
                          right.index == left.index + 1;
    if (!siblings || now < left.next_test) return false;
    const TimeBlock parent{left.block.a, right.block.b};
    const auto error = test_.passes(parent, accepted_.start_time(), now);
    if (!error) {
      left.next_test = later(parent, now);
      return false;
    }
    std::vector<double> fields(left.fields.size(), 0.0);
    add_product(moments_.to_parent(left.block, parent), left.fields.data(), fields.data(), n_);
    add_product(moments_.to_parent(right.block, parent), right.fields.data(), fields.data(), n_);
    left.fields = std::move(fields);
    left.block = parent;
    left.level += 1;
    left.index /= 2;
    left.error = *error;
    left.next_test = now;
    nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    return true;
  }

  PreparedKernel kernel_;
  ChebyshevMoments moments_;
  std::size_t n_;
  int order_;
  std::size_t leaf_; ///< steps of a leaf: twice the moments, so that it saves half
  HistoryOptions options_;
  std::string why_;
  AcceptedSteps accepted_;
  BlockTest test_;
  WeightCache near_;
  PastWeights weights_;
  std::optional<HorizonEnd> ended_;
  std::vector<Node> nodes_; ///< from old to new; the last one is raw and open
  std::int64_t steps_ = 0;
  Ahead ahead_;

  std::vector<double> lags_, times_, values_, columns_;
  std::vector<std::vector<double>> node_weights_;
  std::vector<Combination> parts_;
  std::int64_t reads_ = 0;
};

} // namespace

std::unique_ptr<History> make_tree(const PreparedKernel& kernel, std::size_t n,
                                   const HistoryOptions& options, std::string why) {
  return std::make_unique<TreeHistory>(kernel, n, options, std::move(why));
}

} // namespace hvi::solver
