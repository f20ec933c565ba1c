# An entry of a catalogue module is `<module>/<name>.cpp` or `<module>/<name>/<name>.cpp` that defines
# `extern const <Descriptor> <name>`, in namespace tumble::<module> or tumble::<name>. This writes the function that lists them all, so that adding one thing is adding
# one file, and so that a static library cannot drop an entry nobody names.
function(tumble_catalogue folder result)
  string(REGEX REPLACE "s$" "" noun ${folder})
  string(SUBSTRING ${noun} 0 1 first)
  string(TOUPPER ${first} first)
  string(SUBSTRING ${noun} 1 -1 rest)
  set(type ${first}${rest})
  set(module ${CMAKE_SOURCE_DIR}/tumble/${folder})
  file(GLOB candidates CONFIGURE_DEPENDS RELATIVE ${module} ${module}/*.cpp ${module}/*/*.cpp)
  set(declarations "")
  set(addresses "")
  foreach(candidate ${candidates})
    get_filename_component(stem ${candidate} NAME_WE)
    if(NOT candidate MATCHES "^(${stem}/)?${stem}\\.cpp$")
      continue()
    endif()
    file(STRINGS ${module}/${candidate} definition LIMIT_COUNT 1 REGEX "^extern const ${type} ${stem}( =|{)")
    if(definition STREQUAL "")
      continue()
    endif()
    set(space ${folder})
    if(candidate MATCHES "/")
      set(space ${stem})
    endif()
    string(APPEND declarations "namespace ${space} {\nextern const ${type} ${stem};\n}\n")
    string(APPEND addresses "      &${space}::${stem},\n")
  endforeach()
  set(output ${CMAKE_BINARY_DIR}/generated/tumble/${folder}/catalogue.cpp)
  file(CONFIGURE OUTPUT ${output} CONTENT [[// Generated from the files of tumble/@folder@.
#include "tumble/@folder@/@noun@.hpp"

namespace tumble {

@declarations@
const std::vector<const @type@*>& @noun@_catalogue() {
  static const std::vector<const @type@*> entries{
@addresses@  };
  return entries;
}

}  // namespace tumble
]] @ONLY)
  set(${result} ${output} PARENT_SCOPE)
endfunction()
