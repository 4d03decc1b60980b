# Headers from outside that most files include, compiled once for each family: a file of ours takes two thirds of the time with them. Every
# file still includes what it uses: a build with CMAKE_DISABLE_PRECOMPILE_HEADERS shows the one that does not.
set(common <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <numeric> <optional> <ranges>
  <span> <string> <string_view> <unordered_map> <utility> <variant> <vector> <fmt/format.h> <Eigen/Core> <Eigen/SparseCore>)
set(hvi_precompiled_hot ${common})
set(hvi_precompiled_cold ${common} <nlohmann/json.hpp>)
set(hvi_precompiled_tests ${common} <gtest/gtest.h>)

# hvi_precompile(TARGET hot|cold|tests): the first target of a family compiles its headers, the others reuse them. What is cold is compiled
# with -O1 in a release, in three quarters of the time, and so are tests.
function(hvi_precompile target family)
  set(host hvi_precompiled_${family})
  if(NOT TARGET ${host})
    set(source ${CMAKE_BINARY_DIR}/${host}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "")
    add_library(${host} OBJECT ${source})
    target_link_libraries(${host} PRIVATE hvi_options hvi_headers nlohmann_json::nlohmann_json)
    if(family STREQUAL "tests")
      target_link_libraries(${host} PRIVATE GTest::gtest GTest::gmock)
    else()
      hvi_harden(${host})
    endif()
    hvi_optimise(${host} ${family})
    target_precompile_headers(${host} PRIVATE ${hvi_precompiled_${family}})
  endif()
  hvi_optimise(${target} ${family})
  target_precompile_headers(${target} REUSE_FROM ${host})
endfunction()

function(hvi_optimise target family)
  if(family MATCHES "cold|tests")
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()
