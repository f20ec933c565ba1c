# What `cmake --install` installs: the program, the libraries that were built, the public headers, and a package so that
# find_package(tumble) gives tumble::tumble. Headers in rooms that are not listed here are internal.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/tumble)
set(public_rooms math/stability math/noise math/spectrum math/regression)

file(GLOB headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} tumble/*.hpp tumble/*/*.hpp)
foreach(room ${public_rooms})
  file(GLOB headers_in_room CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} tumble/${room}/*.hpp)
  list(APPEND headers ${headers_in_room})
endforeach()
foreach(header ${headers})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/generated/tumble/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tumble)

if(TUMBLE_PROGRAM)
  install(TARGETS tumble_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

# One export set a kind, so that who wants one needs not what the other is linked with.
function(tumble_install_library target kind)
  install(TARGETS ${target} EXPORT tumble_${kind}
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT tumble_${kind} FILE tumble-${kind}.cmake NAMESPACE tumble:: DESTINATION ${package})
endfunction()
tumble_install_library(tumble static)
if(TUMBLE_SHARED)
  tumble_install_library(tumble_shared shared)
endif()

configure_package_config_file(cmake/tumbleConfig.cmake.in ${PROJECT_BINARY_DIR}/tumbleConfig.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tumbleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tumbleConfig.cmake ${PROJECT_BINARY_DIR}/tumbleConfigVersion.cmake cmake/hdf5.cmake
        DESTINATION ${package})
install(FILES LICENSE NOTICE.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
