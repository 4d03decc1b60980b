# cmake --install: program, library with its headers (find_package(hvi), target hvi::solver), standard library, man page and
# completions; cpack -G DEB makes a package of them.
include(CMakePackageConfigHelpers)

install(TARGETS hvi-run RUNTIME DESTINATION bin)
install(TARGETS hvi_gmsh hvi_mumps hvi_draw LIBRARY DESTINATION lib/hvi)
get_property(libraries GLOBAL PROPERTY hvi_solver_libraries)
install(TARGETS hvi_solver ${libraries} hvi_options hvi_headers hvi_suitesparse EXPORT hvi
  ARCHIVE DESTINATION lib/hvi)
install(EXPORT hvi NAMESPACE hvi:: FILE hviTargets.cmake DESTINATION lib/cmake/hvi)
configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/hviConfig.cmake.in ${CMAKE_BINARY_DIR}/hviConfig.cmake
  INSTALL_DESTINATION lib/cmake/hvi)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/hviConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/hviConfig.cmake ${CMAKE_BINARY_DIR}/hviConfigVersion.cmake DESTINATION lib/cmake/hvi)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/solver DESTINATION include/hvi FILES_MATCHING PATTERN "*.hpp" PATTERN gmsh EXCLUDE
  PATTERN mumps EXCLUDE)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/stdlib DESTINATION share/hvi)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION share/doc/hvi)

find_package(Python3 QUIET COMPONENTS Interpreter)
if(Python3_FOUND)
  install(CODE "execute_process(COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tools/editor_files $<TARGET_FILE:hvi-run>
    ${CMAKE_BINARY_DIR}/editor COMMAND_ERROR_IS_FATAL ANY)")
  install(FILES ${CMAKE_BINARY_DIR}/editor/hvi-run.1 DESTINATION share/man/man1)
  install(FILES ${CMAKE_BINARY_DIR}/editor/hvi-run.bash DESTINATION share/bash-completion/completions RENAME hvi-run)
  install(FILES ${CMAKE_BINARY_DIR}/editor/hvi.tmLanguage.json DESTINATION share/hvi)
endif()

set(CPACK_PACKAGE_NAME hvi)
set(CPACK_PACKAGE_CONTACT "the authors of hvi-run")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Solver and script language for history-dependent hemivariational inequalities")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS gnuplot-nox)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
include(CPack)
