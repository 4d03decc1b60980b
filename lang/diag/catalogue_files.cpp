// Catalogue of diagnostics, class E06: meshes and files.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr std::array<CatalogueEntry, 0> entries{};

} // namespace

std::span<const CatalogueEntry> catalogue_files() { return entries; }

} // namespace hvi::lang
