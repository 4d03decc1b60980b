// Catalogue of diagnostics, class E05: hypotheses.
#include "lang/diag/catalogue.hpp"

#include <array>

namespace hvi::lang {
namespace {

constexpr auto hypotheses_entries = std::to_array<CatalogueEntry>({
    {"E0501", "not locally Lipschitz",
     R"(
A superpotential is locally Lipschitz: it does not jump and its slope is finite. Jumps of the
slope are welcome; they are filled in.)",
     R"(
superpotential j(r) = | r < 0 -> 0 | otherwise -> 1 + r)",
     R"(
superpotential j(r) = | r < 0 -> 0 | otherwise -> r)"},
    {"E0502", "kernel not integrable",
     R"(
The memory integral does not exist, or the kernel is not a sum of products of time and place.)",
     R"(
kernel C(lag) = lag^(-1.5) * B)",
     R"(
kernel C(lag) = lag^(-0.5) * B)"},
    {"E0503", "kernel looks into the future",
     R"(
A kernel of two arguments is q(t, s) with s <= t, in this order.)",
     R"(
kernel q(s, t) = exp(s - t))",
     R"(
kernel q(t, s) = exp(s - t))"},
    {"E0504", "tensor not elliptic",
     R"(
The tensor is not positive definite on symmetric matrices.)",
     R"(
tensor B = isotropic(young = 70, poisson = 0.5))",
     R"(
tensor B = isotropic(young = 70, poisson = 0.4999))"},
});

} // namespace

std::span<const CatalogueEntry> catalogue_hypotheses() { return hypotheses_entries; }

} // namespace hvi::lang
