# A catalogue folder holds one header with the descriptor struct (method.hpp in methods/) and one .cpp an entry;
# the .cpp defines `extern const <Descriptor> <file stem>`. This writes the function that lists them all, so that
# adding one thing is adding one file, and so that a static library cannot drop an entry nobody names.
function(tumble_catalogue folder result)
  string(REGEX REPLACE "s$" "" noun ${folder})
  string(SUBSTRING ${noun} 0 1 first)
  string(TOUPPER ${first} first)
  string(SUBSTRING ${noun} 1 -1 rest)
  set(type ${first}${rest})
  file(GLOB entries CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tumble/${folder}/*.cpp)
  list(FILTER entries EXCLUDE REGEX "_test\\.cpp$")
  set(declarations "")
  set(addresses "")
  foreach(entry ${entries})
    get_filename_component(stem ${entry} NAME_WE)
    string(APPEND declarations "extern const ${type} ${stem};\n")
    string(APPEND addresses "      &${stem},\n")
  endforeach()
  set(output ${PROJECT_BINARY_DIR}/generated/tumble/${folder}/catalogue.cpp)
  file(CONFIGURE OUTPUT ${output} CONTENT [[// Generated from the files of tumble/@folder@.
#include "tumble/@folder@/@noun@.hpp"

namespace tumble::@folder@ {

@declarations@
const std::vector<const @type@*>& catalogue() {
  static const std::vector<const @type@*> entries{
@addresses@  };
  return entries;
}

}  // namespace tumble::@folder@
]] @ONLY)
  set(${result} ${output} PARENT_SCOPE)
endfunction()
