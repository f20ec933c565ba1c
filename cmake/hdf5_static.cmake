# tumble::hdf5_static, for the program alone, where there is one. The shared HDF5 of Debian brings libcurl and thirty
# more for a driver that is not used here, which take longer to load at every start than all the rest of the program;
# the static one is not position independent, so that a shared library cannot take it.
function(tumble_find_hdf5_static)
  # FindHDF5 keeps one kind in the cache: what it found before is put back afterwards.
  get_cmake_property(names CACHE_VARIABLES)
  list(FILTER names INCLUDE REGEX "^HDF5_C_LIBRARY_")
  foreach(name ${names})
    set(before_${name} "${${name}}")
    unset(${name} CACHE)
  endforeach()
  set(HDF5_USE_STATIC_LIBRARIES ON)
  find_package(HDF5 QUIET COMPONENTS C)
  if(HDF5_FOUND)
    add_library(tumble::hdf5_static INTERFACE IMPORTED)
    target_link_libraries(tumble::hdf5_static INTERFACE ${HDF5_C_LIBRARIES})
  endif()
  foreach(name ${names})
    set(${name} "${before_${name}}" CACHE FILEPATH "found by FindHDF5" FORCE)
  endforeach()
endfunction()
tumble_find_hdf5_static()
