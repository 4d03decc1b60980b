// Catalogue of diagnostics, classes E07 (solve) and E09 (our own mistakes).
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr std::array<CatalogueEntry, 0> entries{};

} // namespace

std::span<const CatalogueEntry> catalogue_solve() { return entries; }

} // namespace hvi::lang
