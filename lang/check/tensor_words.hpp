// The numbers of a tensor in a few words, for a label.
#pragma once

#include "lang/check/value.hpp"

#include <functional>
#include <string>

namespace hvi::lang {

/// "isotropic(λ = 40.38, μ = 26.92)", or its entries by their places, "(xxxx = 94.2, ..)", of a
/// kernel that is `factor` times a tensor that neither t nor the lag changes; "" where it is none.
/// `variables`: values of t and the lag, some of them, at which neither is zero.
std::string tensor_beside(const Field& kernel, const Symbol& factor,
                          const std::vector<std::function<double(solver::Slot)>>& variables);

} // namespace hvi::lang
