# The CMake package `binpick`: the rooms that are of use without a simulator, each a component.
#
#   cmake --install build/release --prefix PREFIX --component recognition   # or all, without it
#   find_package(binpick COMPONENTS recognition)  ->  binpick::recognition, binpick::models
#
# A component needs those of the rooms it depends on; `models` brings the package's own files.
# Headers keep their path from the repository's root, in include/binpick: "models/geometry.h".
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(binpick_package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/binpick)

# binpick_install_room(NAME): library, headers and exported target binpick::NAME.
function(binpick_install_room name)
  set_target_properties(binpick_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS binpick_${name} EXPORT binpick_${name}_targets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${name})
  file(GLOB headers CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${name}/*.h)
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/binpick/${name}
          COMPONENT ${name})
  install(EXPORT binpick_${name}_targets NAMESPACE binpick:: FILE binpick_${name}_targets.cmake
          DESTINATION ${binpick_package_directory} COMPONENT ${name})
endfunction()

binpick_install_room(models)
binpick_install_room(recognition)
binpick_install_room(control)

# The arm, the gripper and the objects; programs find them through BINPICK_MODELS.
install(DIRECTORY ${CMAKE_SOURCE_DIR}/models DESTINATION ${CMAKE_INSTALL_DATADIR}/binpick
        COMPONENT models
        PATTERN "*.h" EXCLUDE PATTERN "*.cpp" EXCLUDE PATTERN "CMakeLists.txt" EXCLUDE)

configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/binpickConfig.cmake.in ${CMAKE_BINARY_DIR}/package/binpickConfig.cmake
  INSTALL_DESTINATION ${binpick_package_directory} PATH_VARS CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/binpickConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/binpickConfig.cmake
              ${CMAKE_BINARY_DIR}/package/binpickConfigVersion.cmake
        DESTINATION ${binpick_package_directory} COMPONENT models)
