// Catalogue of diagnostics, class E05: hypotheses of the theory.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr std::array<CatalogueEntry, 0> entries{};

} // namespace

std::span<const CatalogueEntry> catalogue_hypotheses() { return entries; }

} // namespace hvi::lang
