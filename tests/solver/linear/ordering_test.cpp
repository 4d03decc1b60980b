// Orders and elimination trees against an elimination of the pattern done by hand, entry by entry.
#include "matrices.hpp"
#include "solver/linear/ordering.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace hvi::solver::test {
namespace {

/// Do two unknowns have the same neighbours?
bool alike(const SparseMatrix& k, Long a, Long b) {
  std::vector<Eigen::Index> of_a, of_b;
  for (SparseMatrix::InnerIterator it(k, static_cast<int>(a)); it; ++it) of_a.push_back(it.col());
  for (SparseMatrix::InnerIterator it(k, static_cast<int>(b)); it; ++it) of_b.push_back(it.col());
  return of_a == of_b;
}

/// The lower triangle of the factor's pattern, columns by position: each elimination couples what
/// the column reaches. The entries are those of K and of `above`, of which a row stands for the
/// unknowns behind it that are like it and on its side of `interior`.
std::vector<std::vector<char>> eliminate(const SparseMatrix& k, const ContactLastOrder& found,
                                         std::size_t interior) {
  const auto& order = found.permutation;
  const auto n = order.size();
  std::vector<std::vector<char>> filled(n, std::vector<char>(n, 0));
  std::vector<std::size_t> position(n);
  for (std::size_t j = 0; j < n; ++j) position[static_cast<std::size_t>(order[j])] = j;
  for (std::size_t j = 0; j < n; ++j) // stored zeros are entries, too
    for (SparseMatrix::InnerIterator it(k, static_cast<int>(order[j])); it; ++it)
      if (const auto i = position[static_cast<std::size_t>(it.col())]; i >= j) filled[j][i] = 1;
  for (std::size_t j = 0; j < n; ++j)
    for (Long e = found.above.start[j]; e < found.above.start[j + 1]; ++e) {
      const auto row = static_cast<std::size_t>(found.above.row[static_cast<std::size_t>(e)]);
      for (std::size_t i = row; i < j; ++i) {
        const bool stands_for = order[i] == order[row] + static_cast<Long>(i - row) &&
                                alike(k, order[i], order[row]) &&
                                (i < interior) == (row < interior);
        if (!stands_for) break;
        filled[i][j] = 1;
      }
    }
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t a = j + 1; a < n; ++a)
      for (std::size_t b = a; b < n && filled[j][a] != 0; ++b)
        if (filled[j][b] != 0) filled[a][b] = 1;
  return filled;
}

void check(const SparseMatrix& k, const std::vector<int>& contact) {
  SCOPED_TRACE("unknowns " + std::to_string(k.rows()) + ", contact " +
               std::to_string(contact.size()));
  CholmodSession session;
  const auto found = order_contact_last(k, contact, session);
  auto sorted = found.permutation;
  std::ranges::sort(sorted);
  std::vector<Long> all(static_cast<std::size_t>(k.rows()));
  std::iota(all.begin(), all.end(), 0);
  ASSERT_EQ(sorted, all);
  EXPECT_TRUE(std::equal(contact.rbegin(), contact.rend(), found.permutation.rbegin()));
  const auto filled = eliminate(k, found, all.size() - contact.size());
  double nonzeros = 0, flops = 0;
  for (std::size_t j = 0; j < filled.size(); ++j) {
    const auto count = std::ranges::count(filled[j], 1);
    const auto next =
        std::find(filled[j].begin() + static_cast<std::ptrdiff_t>(j) + 1, filled[j].end(), 1);
    const Long parent = next == filled[j].end() ? -1 : next - filled[j].begin();
    EXPECT_EQ(found.count[j], count) << j;
    EXPECT_EQ(found.parent[j], parent) << j;
    nonzeros += static_cast<double>(count);
    flops += static_cast<double>(count * count);
  }
  EXPECT_EQ(found.nonzeros, nonzeros);
  EXPECT_EQ(found.flops, flops);
}

/// Every other of the unknowns, behind each other in K or not.
std::vector<int> some(Eigen::Index n, int step, int from) {
  std::vector<int> out;
  for (int i = from; i < n; i += step) out.push_back(i);
  return out;
}

TEST(Ordering, CountsAndTreeAreThoseOfAnElimination) {
  const auto body = slab(4);
  check(body.k, body.contact); // vertices of two unknowns
  check(body.k, {});
  auto normals = some(static_cast<Eigen::Index>(body.contact.size()), 2, 1);
  for (int& c : normals) c = body.contact[static_cast<std::size_t>(c)];
  check(body.k, normals); // of one and of two
  const auto solid = cube(2);
  check(solid.k, solid.contact); // of three
  check(grid_laplacian(7), {});
  for (unsigned seed = 0; seed < 20; ++seed) check(random_definite(40, 0.06, seed), {}); // a forest
}

TEST(Ordering, ContactThatIsNotConnectedStaysLast) {
  const auto one = slab(3), other = slab(2);
  const auto both = side_by_side(one.k, other.k);
  auto contact = one.contact;
  for (const int c : other.contact) contact.push_back(c + static_cast<int>(one.k.rows()));
  check(both, contact);
  std::ranges::reverse(contact); // against the order of the unknowns
  check(both, contact);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto k = random_definite(40, 0.05, seed);
    auto scattered = some(40, 3, static_cast<int>(seed % 3));
    std::mt19937 random(seed);
    std::shuffle(scattered.begin(), scattered.end(), random);
    check(k, scattered);
  }
  check(grid_laplacian(4), some(16, 1, 0)); // nothing but contact
}

TEST(Ordering, AStoreHandsOutTheSameOrder) {
  const auto body = slab(4);
  CholmodSession session;
  OrderStore store;
  const auto first = store.order(body.k, body.contact, session);
  EXPECT_EQ(store.reused(), 0);
  const auto again = store.order(body.k, body.contact, session);
  EXPECT_EQ(store.reused(), 1);
  EXPECT_EQ(first.permutation, again.permutation);
  EXPECT_EQ(first.above.row, again.above.row);
  store.order(body.k, {}, session);
  EXPECT_EQ(store.reused(), 1);
}

} // namespace
} // namespace hvi::solver::test
