// Which cell holds a point: a tree of bounding boxes over the cells, halved at the median centre.
#include "solver/mesh/box_tree.hpp"
#include "solver/mesh/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace hvi::solver {
namespace {

constexpr std::int32_t leaf_size = 8;
constexpr std::size_t few_points = 16; // a tree costs as much as going through all cells for each
constexpr double cell_slack = 1e-9;    // of barycentric coordinates, and of the boxes of the cells

/// A point with barycentric coordinates above -cell_slack is at most 3 cell_slack diameters
/// outside.
Box wide_box_of(const Mesh& mesh, std::int32_t cell) {
  Box box = box_of(mesh, cell);
  double size = 0;
  for (int a = 0; a < mesh.dim; ++a) size += box.high[a] - box.low[a];
  const double margin = 4 * cell_slack * size;
  for (int a = 0; a < 3; ++a) {
    box.low[a] -= margin;
    box.high[a] += margin;
  }
  return box;
}

bool holds(const Box& box, const Point& p) {
  for (int a = 0; a < 3; ++a)
    if (!(box.low[a] <= p[a] && p[a] <= box.high[a])) return false;
  return true;
}

/// Does a cell lie beside a point along an axis, by more than the margin?
bool beside(const Mesh& mesh, std::int32_t cell, const Point& p, double margin) {
  const auto& c = mesh.cells[cell];
  for (int a = 0; a < mesh.dim; ++a) {
    double low = mesh.nodes[c[0]][a], high = low;
    for (int i = 1; i <= mesh.dim; ++i) {
      const double x = mesh.nodes[c[i]][a];
      low = std::min(low, x), high = std::max(high, x);
    }
    if (low - p[a] > margin || p[a] - high > margin) return true;
  }
  return false;
}

double det(const Point& a, const Point& b, const Point& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

} // namespace

/// lambda_i = measure of the cell with corner i replaced by p, over the measure of the cell.
std::array<double, 4> barycentric_of(const Mesh& mesh, std::int32_t cell, const Point& p) {
  const auto& c = mesh.cells[cell];
  std::array<Point, 4> r{}; // corners seen from p: the differences stay exact near a corner
  for (int i = 0; i <= mesh.dim; ++i)
    for (int a = 0; a < 3; ++a) r[i][a] = mesh.nodes[c[i]][a] - p[a];
  std::array<double, 4> part{};
  if (mesh.dim == 1) {
    part = {r[1][0], -r[0][0], 0, 0};
  } else if (mesh.dim == 2) {
    for (int i = 0; i < 3; ++i) {
      const Point &u = r[(i + 1) % 3], &v = r[(i + 2) % 3];
      part[i] = u[0] * v[1] - u[1] * v[0];
    }
  } else {
    part = {det(r[1], r[2], r[3]), -det(r[0], r[2], r[3]), det(r[0], r[1], r[3]),
            -det(r[0], r[1], r[2])};
  }
  const double whole = part[0] + part[1] + part[2] + part[3];
  for (double& x : part) x /= whole;
  return part;
}

CellLocator::CellLocator(const Mesh& mesh, std::size_t points)
    : mesh_(&mesh), order_(mesh.cells.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  if (points <= few_points && !order_.empty()) {
    constexpr double far = std::numeric_limits<double>::infinity();
    nodes_ = {
        {Box{{-far, -far, -far}, {far, far, far}}, 0, static_cast<std::int32_t>(order_.size())}};
    Box whole{mesh.nodes.front(), mesh.nodes.front()};
    for (const Point& x : mesh.nodes) include(whole, {x, x});
    for (int a = 0; a < 3; ++a) widest_margin_ += 5 * cell_slack * (whole.high[a] - whole.low[a]);
    return;
  }
  std::vector<Point> centres(mesh.cells.size(), Point{});
  for (std::size_t i = 0; i < mesh.cells.size(); ++i)
    for (int k = 0; k <= mesh.dim; ++k)
      for (int a = 0; a < 3; ++a) centres[i][a] += mesh.nodes[mesh.cells[i][k]][a];
  if (order_.empty()) return;
  nodes_.reserve(mesh.cells.size() / 2 + 2);
  nodes_.emplace_back();
  build(0, 0, static_cast<std::int32_t>(order_.size()), centres);
}

void CellLocator::build(std::int32_t node, std::int32_t first, std::int32_t past,
                        const std::vector<Point>& centres) {
  if (past - first <= leaf_size) {
    Box box = wide_box_of(*mesh_, order_[first]);
    for (auto i = first + 1; i < past; ++i) include(box, wide_box_of(*mesh_, order_[i]));
    nodes_[node] = {box, first, past - first};
    return;
  }
  Box spread{centres[order_[first]], centres[order_[first]]};
  for (auto i = first; i < past; ++i) include(spread, {centres[order_[i]], centres[order_[i]]});
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (spread.high[a] - spread.low[a] > spread.high[axis] - spread.low[axis]) axis = a;
  const auto middle = first + (past - first) / 2;
  std::nth_element(
      order_.begin() + first, order_.begin() + middle, order_.begin() + past,
      [&](std::int32_t i, std::int32_t j) { return centres[i][axis] < centres[j][axis]; });
  const auto child = static_cast<std::int32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  build(child, first, middle, centres);
  build(child + 1, middle, past, centres);
  Box box = nodes_[child].box;
  include(box, nodes_[child + 1].box);
  nodes_[node] = {box, child, 0};
}

int CellLocator::find(const Point& p, std::array<double, 4>& barycentric,
                      std::size_t* looked_at) const {
  if (nodes_.empty()) return -1;
  std::size_t compared = 0;
  int best = -1;
  int best_piece = 0;
  double best_depth = -cell_slack;    // depth: the smallest barycentric coordinate
  std::array<std::int32_t, 64> stack; // the tree is balanced: depth below 32
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    ++compared;
    if (!holds(node.box, p)) continue;
    if (node.count == 0) {
      stack[top++] = node.first;
      stack[top++] = node.first + 1;
      continue;
    }
    const bool many = node.count > leaf_size;
    compared += static_cast<std::size_t>(node.count);
    for (auto i = node.first; i < node.first + node.count; ++i) {
      if (many && (beside(*mesh_, order_[i], p, widest_margin_) ||
                   !holds(wide_box_of(*mesh_, order_[i]), p)))
        continue;
      const auto lambda = barycentric_of(*mesh_, order_[i], p);
      const double depth = *std::min_element(lambda.begin(), lambda.begin() + mesh_->dim + 1);
      if (!(depth > -cell_slack)) continue;
      const int piece = mesh_->piece_of_cell(order_[i]);
      const bool deeper = depth > best_depth || (depth == best_depth && order_[i] < best);
      if (best < 0 || piece < best_piece || (piece == best_piece && deeper)) {
        best_piece = piece;
        best = order_[i];
        best_depth = depth;
        barycentric = lambda;
      }
    }
  }
  if (looked_at != nullptr) *looked_at += compared;
  return best;
}

} // namespace hvi::solver
