// Catalogue of diagnostics, class E03: names, types and shapes.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto entries = std::to_array<CatalogueEntry>({
    {"E0301", "unknown name",
     R"(
A name is used that nothing declares: no statement of this file or of its imports, no parameter of
the enclosing kernel, superpotential or fn, and nothing built in. The help line proposes the
declared name that is spelt most alike.)",
     R"(
param young = 70
tensor B = isotropic(young = yuong, poisson = 0.3))",
     R"(
param young = 70
tensor B = isotropic(young = young, poisson = 0.3))"},
});

} // namespace

std::span<const CatalogueEntry> catalogue_names() { return entries; }

} // namespace hvi::lang
