# One folder is one static library; what it stands on is in Floors.cmake.
include(Floors)
include(Precompiled)

# hvi_module(solver output LINKS ZLIB::ZLIB): library hvi_solver_output from solver/output/*.cpp
function(hvi_module family name)
  cmake_parse_arguments(ARG "" "" "LINKS" ${ARGN})
  hvi_stands_on(floors ${family}_${name})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${family}/${name}/*.cpp)
  set(target hvi_${family}_${name})
  if(sources)
    add_library(${target} STATIC ${sources})
    target_link_libraries(${target} PUBLIC hvi_options hvi_headers ${floors} ${ARG_LINKS})
    hvi_harden(${target})
    hvi_precompile(${target} ${family})
    set_property(GLOBAL APPEND PROPERTY hvi_${family}_libraries ${target})
  else()
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE hvi_options hvi_headers ${floors} ${ARG_LINKS})
  endif()
endfunction()

# hvi_tests(FOLDER LABEL target...): one GoogleTest program from FOLDER/*.cpp, one ctest case per test
function(hvi_tests folder label)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  if(NOT sources)
    message(FATAL_ERROR "There are no tests in ${CMAKE_CURRENT_SOURCE_DIR}/${folder}")
  endif()
  string(REPLACE "/" "_" program "test_${folder}")
  add_executable(${program} ${sources})
  target_link_libraries(${program} PRIVATE ${ARGN} GTest::gtest GTest::gtest_main GTest::gmock)
  hvi_precompile(${program} tests)
  target_compile_definitions(${program} PRIVATE HVI_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/tmp) # of this build: another one may be tested at once
  gtest_discover_tests(${program} TEST_PREFIX "${folder}:" DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS "${label}" ENVIRONMENT "TEST_TMPDIR=${CMAKE_BINARY_DIR}/tmp;TMPDIR=${CMAKE_BINARY_DIR}/tmp")
endfunction()
