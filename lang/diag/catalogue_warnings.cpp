// Catalogue of diagnostics, class W: warnings.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr std::array<CatalogueEntry, 0> entries{};

} // namespace

std::span<const CatalogueEntry> catalogue_warnings() { return entries; }

} // namespace hvi::lang
