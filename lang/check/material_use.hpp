// What sums and products make of tensors times strains: see MaterialUse.
#pragma once

#include "lang/check/model.hpp"

#include <map>
#include <vector>

namespace hvi::lang {

/// by * the sum of these, where `by` is of place, time and states only.
std::vector<MaterialUse> scaled(std::vector<MaterialUse> uses, const Symbol& by);
/// The derivatives of these; none where constants of a tensor have one.
std::vector<MaterialUse> derivatives(std::vector<MaterialUse> uses, solver::Slot by,
                                     const std::vector<solver::TensorSpec>& tensors);
/// The sum of both; none where one of them was written in some other way.
std::vector<MaterialUse> joined(std::vector<MaterialUse> left,
                                const std::vector<MaterialUse>& right);
/// Of `left : right`. A tensor without major symmetry stands before the strain of the unknown.
std::vector<MaterialUse> contracted(const Field& left, const Field& right,
                                    const std::vector<solver::TensorSpec>& tensors);
/// Kernels that are sums of materials, by memory, and the memories of `of` that they make.
using KernelMaterials = std::map<int, std::vector<MaterialUse>>;
std::vector<MaterialUse> memories_of(const Field& of, const KernelMaterials& kernels,
                                     const std::vector<solver::TensorSpec>& tensors);
/// eps of the sum of these, functions times numbers.
std::vector<MaterialUse> strains_of(const Field& functions);

} // namespace hvi::lang
