# What `cmake --install` installs: the program, the libraries that were built, the public headers, and a package so that
# find_package(tumble) gives tumble::tumble.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/tumble)

# The public headers are what tumble/tumble.hpp includes, and what these include.
function(tumble_public_headers result)
  set(todo tumble/tumble.hpp)
  set(headers "")
  while(todo)
    list(POP_FRONT todo header)
    if(header IN_LIST headers OR header STREQUAL "tumble/version.hpp")
      continue()
    endif()
    list(APPEND headers ${header})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
    file(STRINGS ${PROJECT_SOURCE_DIR}/${header} lines REGEX "^#include \"tumble/")
    foreach(line ${lines})
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included ${line})
      list(APPEND todo ${included})
    endforeach()
  endwhile()
  set(${result} ${headers} PARENT_SCOPE)
endfunction()

tumble_public_headers(headers)
foreach(header ${headers})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/generated/tumble/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tumble)

if(TUMBLE_PROGRAM)
  install(TARGETS tumble_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(DIRECTORY plans instruments controllers stations DESTINATION ${CMAKE_INSTALL_DATADIR}/tumble)
  # What the program says of itself to shells and to man.
  set(words ${PROJECT_BINARY_DIR}/share)
  file(MAKE_DIRECTORY ${words})
  foreach(kind bash zsh fish man)
    add_custom_command(OUTPUT ${words}/tumble.${kind} VERBATIM DEPENDS tumble_cli
                       COMMAND sh -c "\"$1\" completion $2 > \"$3\"" sh $<TARGET_FILE:tumble_cli> ${kind} ${words}/tumble.${kind})
    list(APPEND word_files ${words}/tumble.${kind})
  endforeach()
  add_custom_target(tumble_words ALL DEPENDS ${word_files})
  install(FILES ${words}/tumble.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME tumble)
  install(FILES ${words}/tumble.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _tumble)
  install(FILES ${words}/tumble.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
  install(FILES ${words}/tumble.man DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 RENAME tumble.1)
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
install(FILES ${PROJECT_BINARY_DIR}/tumbleConfig.cmake ${PROJECT_BINARY_DIR}/tumbleConfigVersion.cmake cmake/hdf5.cmake cmake/containers.cmake
        DESTINATION ${package})
install(FILES LICENSE NOTICE.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
