// Catalogue of diagnostics, class E04: problem structure and values.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr std::array<CatalogueEntry, 0> entries{};

} // namespace

std::span<const CatalogueEntry> catalogue_problem() { return entries; }

} // namespace hvi::lang
