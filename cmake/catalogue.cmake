# An entry of a catalogue module is `<module>/<name>.cpp` or `<module>/<name>/<name>.cpp` that defines
# `extern const <Descriptor> <name>`, in namespace tumble::<module>::<name> or tumble::<name>. This writes the function that lists
# them all, so that adding one thing is adding one file, and so that a static library cannot drop an entry nobody names.
#
# Further arguments are entries that stand elsewhere, each as `<space>::<name>`. The list with them is written to a file
# of its own: a program that compiles it together with these entries finds them in its catalogue, and nobody else does.
# A folder below a module, exchange/exports, is a catalogue like any other: its last part names type and namespace.
function(tumble_catalogue folder result)
  get_filename_component(space_of_folder ${folder} NAME)
  string(REGEX REPLACE "s$" "" noun ${space_of_folder})
  string(SUBSTRING ${noun} 0 1 first)
  string(TOUPPER ${first} first)
  string(SUBSTRING ${noun} 1 -1 rest)
  set(type ${first}${rest})
  set(module ${PROJECT_SOURCE_DIR}/tumble/${folder})
  file(GLOB candidates CONFIGURE_DEPENDS RELATIVE ${module} ${module}/*.cpp ${module}/*/*.cpp)
  set(entries "")
  foreach(candidate ${candidates})
    get_filename_component(stem ${candidate} NAME_WE)
    if(NOT candidate MATCHES "^(${stem}/)?${stem}\\.cpp$")
      continue()
    endif()
    file(STRINGS ${module}/${candidate} definition LIMIT_COUNT 1 REGEX "^extern const ${type} ${stem}( =|{)")
    if(definition STREQUAL "")
      continue()
    endif()
    set(space ${space_of_folder}::${stem})
    if(candidate MATCHES "/")
      set(space ${stem})
    endif()
    list(APPEND entries "${stem}/${space}")
  endforeach()
  set(output ${PROJECT_BINARY_DIR}/generated/tumble/${folder}/catalogue.cpp)
  if(ARGN)
    set(output ${PROJECT_BINARY_DIR}/generated/tumble/${folder}/catalogue_with_more.cpp)
    list(TRANSFORM ARGN REPLACE "^(.+)::(.+)$" "\\2/\\1" OUTPUT_VARIABLE more)
    list(APPEND entries ${more})
  endif()
  list(SORT entries)
  set(declarations "")
  set(addresses "")
  foreach(entry ${entries})
    string(REGEX MATCH "^(.+)/(.+)$" entry ${entry})
    string(APPEND declarations "namespace ${CMAKE_MATCH_2} {\nextern const ${type} ${CMAKE_MATCH_1};\n}\n")
    string(APPEND addresses "      &${CMAKE_MATCH_2}::${CMAKE_MATCH_1},\n")
  endforeach()
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

# The trials of the methods, methods/<method>/testing/trials.cpp, for the test programs: the library does not have them. Further
# arguments are methods that stand elsewhere. Writes the list of all.
function(tumble_trials name result)
  file(GLOB found CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/tumble/methods
       ${PROJECT_SOURCE_DIR}/tumble/methods/*/testing/trials.cpp)
  list(TRANSFORM found REPLACE "/.*" "")
  list(APPEND found ${ARGN})
  list(SORT found)
  set(declarations "")
  set(entries "")
  foreach(method ${found})
    string(APPEND declarations "namespace ${method} {\nextern const Trials trials;\n}\n")
    string(APPEND entries "      {\"${method}\", &${method}::trials},\n")
  endforeach()
  set(output ${PROJECT_BINARY_DIR}/generated/tumble/methods/testing/${name}.cpp)
  file(CONFIGURE OUTPUT ${output} CONTENT [[// Generated from the files of tumble/methods/*/testing.
#include "tumble/methods/testing/trials.hpp"

namespace tumble {

@declarations@
const std::vector<std::pair<std::string_view, const Trials*>>& trials_catalogue() {
  static const std::vector<std::pair<std::string_view, const Trials*>> entries{
@entries@  };
  return entries;
}

}  // namespace tumble
]] @ONLY)
  set(${result} ${output} PARENT_SCOPE)
endfunction()
