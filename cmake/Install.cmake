# cmake --install: program, library with its headers (find_package(hvi), target hvi::solver), package for Python, standard library, man page,
# completions, type and icon of scripts. cpack -G DEB makes Debian packages of them: hvi-run, libhvi-dev, python3-hvi and, as it
# brings MPI, for the iterative solvers alone hvi-petsc.
include(CMakePackageConfigHelpers)

install(TARGETS hvi-run RUNTIME DESTINATION bin COMPONENT program)
install(TARGETS hvi_gmsh hvi_mumps hvi_draw LIBRARY DESTINATION lib/hvi COMPONENT program)
get_property(libraries GLOBAL PROPERTY hvi_solver_libraries)
install(TARGETS hvi_solver ${libraries} hvi_options hvi_headers hvi_suitesparse EXPORT hvi
  ARCHIVE DESTINATION lib/hvi COMPONENT library)
install(EXPORT hvi NAMESPACE hvi:: FILE hviTargets.cmake DESTINATION lib/cmake/hvi COMPONENT library)
configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/hviConfig.cmake.in ${CMAKE_BINARY_DIR}/hviConfig.cmake
  INSTALL_DESTINATION lib/cmake/hvi)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/hviConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/hviConfig.cmake ${CMAKE_BINARY_DIR}/hviConfigVersion.cmake DESTINATION lib/cmake/hvi
  COMPONENT library)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/solver DESTINATION include/hvi COMPONENT library FILES_MATCHING PATTERN "*.hpp"
  PATTERN gmsh EXCLUDE PATTERN mumps EXCLUDE PATTERN petsc EXCLUDE)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/stdlib DESTINATION share/hvi COMPONENT program)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/examples/ DESTINATION share/doc/hvi-run/examples COMPONENT program FILES_MATCHING
  PATTERN "*.hvi" PATTERN "*.msh" PATTERN "*.geo" PATTERN new EXCLUDE PATTERN cpp EXCLUDE PATTERN python EXCLUDE)
set(packages program hvi-run library libhvi-dev)
if(TARGET hvi_python)
  list(APPEND packages python python3-hvi)
  get_property(minor GLOBAL PROPERTY hvi_python_minor)
  install(TARGETS hvi_python LIBRARY DESTINATION lib/python3/dist-packages/hvi COMPONENT python)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/lang/python/hvi DESTINATION lib/python3/dist-packages COMPONENT python PATTERN "__pycache__" EXCLUDE)
  install(FILES ${CMAKE_SOURCE_DIR}/examples/python/slab.ipynb DESTINATION share/doc/python3-hvi/examples COMPONENT python)
endif()
if(TARGET hvi_petsc)
  list(APPEND packages petsc hvi-petsc)
  install(TARGETS hvi_petsc LIBRARY DESTINATION lib/hvi COMPONENT petsc)
endif()

find_package(Python3 QUIET COMPONENTS Interpreter)
if(Python3_FOUND)
  install(CODE "execute_process(COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tools/editor_files $<TARGET_FILE:hvi-run>
    ${CMAKE_BINARY_DIR}/editor COMMAND_ERROR_IS_FATAL ANY)" COMPONENT program)
  install(FILES ${CMAKE_BINARY_DIR}/editor/hvi-run.1.gz DESTINATION share/man/man1 COMPONENT program)
  install(FILES ${CMAKE_BINARY_DIR}/editor/hvi-run.bash DESTINATION share/bash-completion/completions RENAME hvi-run COMPONENT program)
  install(FILES ${CMAKE_BINARY_DIR}/editor/hvi.tmLanguage.json DESTINATION share/hvi COMPONENT program)
endif()
install(FILES ${CMAKE_SOURCE_DIR}/cmake/desktop/hvi.xml DESTINATION share/mime/packages COMPONENT program)
install(FILES ${CMAKE_SOURCE_DIR}/cmake/desktop/text-x-hvi.svg DESTINATION share/icons/hicolor/scalable/mimetypes COMPONENT program)

# What Debian wants beside each package: a licence, and a changelog, whose text is that of CHANGELOG.md.
file(READ ${CMAKE_SOURCE_DIR}/CHANGELOG.md changes)
string(REGEX MATCH "## ${PROJECT_VERSION}, ([-0-9]+)" release "${changes}")
set(day "${CMAKE_MATCH_1}")
if(NOT release)
  message(FATAL_ERROR "CHANGELOG.md has no heading \"## ${PROJECT_VERSION}, DAY\"")
endif()
execute_process(COMMAND date -u -R -d ${day} OUTPUT_VARIABLE released OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
set(maintainer "Authors of hvi-run <authors@hvi-run.invalid>")
while(packages)
  list(POP_FRONT packages component package)
  set(folder ${CMAKE_BINARY_DIR}/debian/${package})
  file(CONFIGURE OUTPUT ${folder}/changelog CONTENT
    "${package} (@PROJECT_VERSION@) unstable; urgency=low\n\n  * See CHANGELOG.md of the sources.\n\n -- @maintainer@  @released@\n" @ONLY)
  execute_process(COMMAND gzip -9nkf ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
  file(CONFIGURE OUTPUT ${folder}/copyright CONTENT
    "Files: *\nCopyright: Copyright (C) 2026 the hvi-run authors\nLicense: GPL-2.0-or-later\n\nOn Debian systems the licence is in /usr/share/common-licenses/GPL-2.\n" @ONLY)
  install(FILES ${folder}/changelog.gz ${folder}/copyright DESTINATION share/doc/${package} COMPONENT ${component})
endwhile()

set(CPACK_PACKAGE_NAME hvi)
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME hvi-run)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS gnuplot-nox)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "solver and language for hemivariational inequalities
Runs scripts that state a history-dependent hemivariational inequality, such
as contact of a viscoelastic body with friction, memory and laws that soften,
and solves it with a certificate for every time step.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libhvi-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "libeigen3-dev, libfmt-dev, libsuitesparse-dev, libopenblas-serial-dev, libmetis-dev, \
libboost-math-dev, nlohmann-json3-dev, zlib1g-dev, hvi-run (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "solver for hemivariational inequalities, for C++
The library behind hvi-run: headers, static library and files for CMake
(find_package(hvi)).")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-hvi)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
if(TARGET hvi_python)
  math(EXPR next "${minor} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${minor}), python3 (<< 3.${next}), python3-numpy, libopenblas0-pthread | libopenblas0-openmp, hvi-run (= ${PROJECT_VERSION})")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-scipy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pandas, python3-matplotlib")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "hemivariational inequalities from Python
The package hvi: runs scripts of hvi-run, with tables and fields as NumPy
arrays, step by step, in sweeps over processes, and finds parameters from
measured curves.")
set(CPACK_DEBIAN_PETSC_PACKAGE_NAME hvi-petsc)
set(CPACK_DEBIAN_PETSC_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PETSC_PACKAGE_DEPENDS "hvi-run (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PETSC_PACKAGE_RECOMMENDS "openmpi-bin")
set(CPACK_DEBIAN_PETSC_DESCRIPTION "iterative solvers for hvi-run, by PETSc
The module that hvi-run opens where a script or the command asks for an
iterative solver: for models of up to millions of unknowns in 3D, on one or,
by mpirun, on several processes.")
include(CPack)
