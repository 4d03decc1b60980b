// The numbers of H(J) over a part of space and a range of times (known_constants.hpp).
#include "solver/common/numbers.hpp"
#include "solver/law/descent.hpp"
#include "solver/law/jumps.hpp"
#include "solver/law/known_constants.hpp"
#include "solver/law/supremum.hpp"
#include "solver/law/switches.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace hvi::solver {

namespace {

constexpr double slope_rounding = 1e-12; ///< of a slope: pieces meant to meet
constexpr std::size_t most_graphs = 80;

bool is_place(Slot s) { return s >= slot::x(0) && s <= slot::x(2); }

/// A part of space for searches over some of its coordinates.
class Part {
public:
  Part(const LawDomain& domain) : domain_(domain) {
    for (const auto& simplex : domain.part) {
      Box box{simplex.corners[0], simplex.corners[0]};
      for (int k = 1; k < simplex.n; ++k)
        for (std::size_t i = 0; i < 3; ++i) {
          box.low[i] = std::min(box.low[i], simplex.corners[k][i]);
          box.high[i] = std::max(box.high[i], simplex.corners[k][i]);
        }
      boxes_.push_back(box);
      for (std::size_t i = 0; i < 3; ++i) {
        whole_.low[i] = std::min(whole_.low[i], box.low[i]);
        whole_.high[i] = std::max(whole_.high[i], box.high[i]);
      }
    }
  }

  /// The space of these variables; `first`: the place of the first one in a box.
  SearchSpace space(const std::vector<Slot>& variables, std::size_t first) const {
    SearchSpace out;
    SearchBox all{};
    std::vector<std::pair<std::size_t, std::size_t>> places; // place in the box, coordinate
    for (std::size_t k = 0; k < variables.size(); ++k) {
      const Slot s = variables[k];
      if (is_place(s)) {
        const auto i = static_cast<std::size_t>(s - slot::x(0));
        all[first + k] = {whole_.low[i], whole_.high[i]};
        places.emplace_back(first + k, i);
        out.constrained |= 1U << (first + k);
      } else {
        all[first + k] = {domain_.t_low, domain_.t_high};
      }
    }
    out.boxes.push_back(all);
    if (places.empty()) return out;
    out.meets = [this, places](const SearchBox& box) {
      return std::any_of(boxes_.begin(), boxes_.end(), [&](const Box& b) {
        return std::all_of(places.begin(), places.end(), [&](const auto& p) {
          return b.low[p.second] <= box[p.first].high && b.high[p.second] >= box[p.first].low;
        });
      });
    };
    out.pull = [this, places](SearchPoint& p) { pull(places, p); };
    return out;
  }

  const Box& whole() const { return whole_; }

private:
  /// Moves a point to one of the nearest simplex.
  void pull(const std::vector<std::pair<std::size_t, std::size_t>>& places, SearchPoint& p) const {
    double best = infinity;
    std::size_t nearest = 0;
    for (std::size_t s = 0; s < boxes_.size(); ++s) {
      double away = 0.0;
      for (const auto& [k, i] : places)
        away = std::max({away, boxes_[s].low[i] - p[k], p[k] - boxes_[s].high[i]});
      if (away < best) best = away, nearest = s;
    }
    const auto& simplex = domain_.part[nearest];
    // Corners weighed by their nearness: some point of the simplex, the corner itself at a corner.
    std::array<double, 4> weight{};
    double sum = 0.0;
    for (int c = 0; c < simplex.n; ++c) {
      double away = 0.0, size = 0.0;
      for (const auto& [k, i] : places) {
        away = std::max(away, std::abs(simplex.corners[c][i] - p[k]));
        size = std::max(size, boxes_[nearest].high[i] - boxes_[nearest].low[i]);
      }
      weight[c] = std::max(0.0, size - away);
      sum += weight[c];
    }
    if (!(sum > 0.0)) weight[0] = sum = 1.0;
    for (const auto& [k, i] : places) {
      p[k] = 0.0;
      for (int c = 0; c < simplex.n; ++c) p[k] += weight[c] / sum * simplex.corners[c][i];
    }
  }

  const LawDomain& domain_;
  std::vector<Box> boxes_;
  Box whole_{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
};

class OverRange {
public:
  OverRange(const Law& law, const LawDomain& domain, ProofEffort effort)
      : law_(law), domain_(domain), part_(domain), effort_(effort),
        slope_(law.spec().by_slope ? expose_kinks(law.spec().expression)
                                   : derivative(expose_kinks(law.spec().expression), slot::r)) {}

  KnownConstants constants() {
    look_at_graphs();
    const Expr curvature = derivative(slope_, slot::r);
    const Expr ratio = slope_ / (Expr(1.0) + abs(Expr::variable(slot::r)));
    out_.steepest_ascent = up_ ? Bracket::exactly(infinity) : supremum(curvature, 0.0).value;
    const double size = std::isfinite(out_.steepest_ascent.low) ? out_.steepest_ascent.low : 0.0;
    descend(supremum(-curvature, size));
    out_.c = larger(supremum(ratio, 0.0).value, supremum(-ratio, 0.0).value);
    if (out_.c.high >= unbounded_slope && out_.c.low >= unbounded_slope / (1.0 + reach_))
      out_.c = Bracket::exactly(infinity);
    return out_;
  }

  KnownConstants descent() {
    look_at_graphs();
    descend(supremum(-derivative(slope_, slot::r), slope_size_ / reach_));
    return out_;
  }

private:
  std::vector<Slot> others(const Expr& f) const {
    std::vector<Slot> out;
    for (const Slot s : slots_of(f))
      if (s != slot::r) out.push_back(s);
    return out;
  }

  /// sup f, at least 0, over argument, part and times.
  LargestValue supremum(const Expr& f, double size) const {
    const std::vector<Slot> variables = others(f);
    SupremumRange range;
    range.low = law_.spec().radial ? 0.0 : -infinity, range.high = infinity;
    range.scale = reach_;
    range.others = part_.space(variables, 1);
    const double noise = 64.0 * 0x1p-52 * size;
    return Supremum(f, variables)(range, {effort_.evaluations, effort_.digits, noise, 0.0});
  }

  void descend(const LargestValue& found) {
    out_.worst_at = found.at[0];
    const double size = std::isfinite(out_.steepest_ascent.low) ? out_.steepest_ascent.low : 0.0;
    out_.m = without_rounding(found.value, size);
    const JumpAnswer jumps = down_ ? JumpAnswer::down : downward_jumps();
    out_.jumps_down = jumps == JumpAnswer::down;
    if (out_.jumps_down)
      out_.m = Bracket::exactly(infinity), out_.worst_at = down_at_;
    else if (steep_at_)
      out_.m = Bracket::exactly(infinity), out_.worst_at = *steep_at_;
    else if (jumps == JumpAnswer::unknown)
      out_.m = Bracket::at_least(out_.m.low);
  }

  enum class JumpAnswer { none, down, unknown };

  /// Does the slope jump down anywhere? Switch by switch.
  JumpAnswer downward_jumps() {
    JumpAnswer answer = JumpAnswer::none;
    for (const Switch& s : find_switches({&slope_, 1})) {
      if (!may_jump(s)) continue;
      const JumpAnswer here = at_switch(s);
      if (here == JumpAnswer::down) return here;
      if (here == JumpAnswer::unknown) answer = here;
    }
    return answer;
  }

  JumpAnswer at_switch(const Switch& s) {
    if (s.kind != Switch::Kind::two_sided) return JumpAnswer::unknown; // a table's slope
    const Expr jump = jump_across(slope_, s.node);
    const Expr rise = derivative(s.function, slot::r);
    const double allowed = slope_rounding * slope_size_;
    if (!rise.depends_on(slot::r)) {
      const std::pair<Slot, Expr> zero{slot::r, Expr(0.0)};
      const Expr root = -substitute(s.function, {&zero, 1}) / rise;
      const std::pair<Slot, Expr> there{slot::r, root};
      const Expr drop = -substitute(jump, {&there, 1}) * Expr::make(Op::sign, {rise});
      const std::vector<Slot> variables = others(drop);
      const LargestValue found = LargestSearch(drop, variables)(
          part_.space(variables, 0), {effort_.evaluations, effort_.digits, allowed, 0.0});
      if (found.value.high <= allowed) return JumpAnswer::none;
      return found.value.low > allowed && confirmed(variables, found.at) ? JumpAnswer::down
                                                                         : JumpAnswer::unknown;
    }
    return along(s, -jump * Expr::make(Op::sign, {rise}), allowed);
  }

  /// A switch that is not affine in the argument: the jump wherever its function may vanish.
  JumpAnswer along(const Switch& s, const Expr& drop, double allowed) const {
    std::vector<Slot> variables = others(drop);
    for (const Slot v : others(s.function))
      if (std::find(variables.begin(), variables.end(), v) == variables.end())
        variables.push_back(v);
    SupremumRange range;
    range.low = law_.spec().radial ? 0.0 : -infinity, range.high = infinity;
    range.scale = reach_;
    range.others = part_.space(variables, 1);
    range.others.constrained = ~0U;
    const IntervalTape function({&s.function, 1});
    const auto meets = range.others.meets;
    range.others.meets = [&, meets](const SearchBox& box) {
      if (meets && !meets(box)) return false;
      std::vector<Bounds> inputs, work;
      for (const Slot v : function.inputs()) {
        const auto k = std::find(variables.begin(), variables.end(), v) - variables.begin();
        inputs.push_back(v == slot::r ? box[0] : box[static_cast<std::size_t>(k) + 1]);
      }
      Bounds value;
      function(inputs, {&value, 1}, work);
      return !value.known || (value.low <= 0.0 && value.high >= 0.0);
    };
    const LargestValue found =
        Supremum(drop, variables)(range, {effort_.evaluations, effort_.digits, allowed, 0.0});
    return found.value.high <= allowed ? JumpAnswer::none : JumpAnswer::unknown;
  }

  /// Does the graph at the place and time that a search found jump down?
  bool confirmed(const std::vector<Slot>& variables, const SearchPoint& at) {
    Point x{};
    for (std::size_t i = 0; i < 3; ++i) x[i] = part_.whole().low[i];
    double t = domain_.t_low;
    for (std::size_t k = 0; k < variables.size(); ++k)
      (variables[k] == slot::t ? t : x[static_cast<std::size_t>(variables[k])]) = at[k];
    look_at(x, t);
    return down_;
  }

  void look_at(const Point& x, double t) {
    const LawGraph g = law_.graph(x, t);
    const GraphJumps jumps = jumps_of(g, law_.spec().radial, law_.slope(g, piece_of(g, 0.0), 0.0));
    if (jumps.down && !down_) down_ = true, down_at_ = jumps.down_at;
    up_ = up_ || jumps.up;
    slope_size_ = std::max(slope_size_, jumps.slope_scale);
    for (const double b : g.breaks) reach_ = std::max(reach_, std::abs(b));
    for (int i = 0; i < g.pieces() && !steep_at_; ++i) steep_at_ = law_.steep_fall(g, i);
  }

  /// A few graphs: sizes, and jumps that samples show.
  void look_at_graphs() {
    const std::size_t stride = std::max<std::size_t>(1, domain_.part.size() / (most_graphs / 5));
    for (std::size_t p = 0; p < domain_.part.size();
         p += law_.depends_on_x() ? stride : domain_.part.size())
      for (int k = 0; k <= 4; ++k) {
        if (k > 0 && !law_.depends_on_t()) break;
        look_at(domain_.part[p].corners[0],
                domain_.t_low + (domain_.t_high - domain_.t_low) * k / 4.0);
      }
    out_.clarke_regular = !(up_ && down_);
  }

  const Law& law_;
  const LawDomain& domain_;
  Part part_;
  ProofEffort effort_;
  Expr slope_;
  KnownConstants out_;
  double slope_size_ = 0.0, reach_ = 1.0, down_at_ = 0.0;
  std::optional<double> steep_at_; ///< where a graph falls infinitely steeply
  bool up_ = false, down_ = false;
};

} // namespace

KnownConstants known_constants(const Law& law, const LawDomain& domain, ProofEffort effort) {
  return OverRange(law, domain, effort).constants();
}

KnownConstants steepest_descent(const Law& law, const LawDomain& domain) {
  if (law.depends_on_x() || law.depends_on_t())
    return OverRange(law, domain, {1000, 1e-3}).descent();
  const LawGraph g = law.graph(domain.part.front().corners[0], domain.t_low);
  const bool radial = law.spec().radial;
  const GraphJumps jumps = jumps_of(g, radial, law.slope(g, piece_of(g, 0.0), 0.0));
  KnownConstants out;
  out.jumps_down = jumps.down;
  if (jumps.down) out.m = Bracket::exactly(infinity);
  for (int i = 0; i < g.pieces() && std::isfinite(out.m.value()); ++i) {
    if (law.steep_fall(g, i)) out.m = Bracket::exactly(infinity);
    const auto range = law.curvature_range(g, i, piece_low(g, i, radial), piece_high(g, i));
    const double here = std::max(0.0, -range.low);
    out.m = larger(out.m, range.exact ? Bracket::exactly(here) : Bracket::at_least(here));
  }
  return out;
}

} // namespace hvi::solver
