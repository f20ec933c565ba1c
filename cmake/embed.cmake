# Files that travel inside the program: texts, the style of the report, the plans, and the
# declarations of frames and of controllers. Each file of text and of
# tumble/report/assets becomes `extern const std::string_view <name with _ for every other character>` through the
# assembler's .incbin, which costs no compile time.
# Plans stand in the list `plans` by their file names, declarations of frames in the list `instruments`, of
# controllers in the list `controllers`; their names must differ from those of all the others. Further arguments are files
# of the workbench's pages, packed by gzip and made by the build: they stand in the list `pages` by their names without .gz.
function(tumble_embed result)
  set(pages ${ARGN})
  set(page_list "")
  file(GLOB plans CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/plans/*.toml)
  file(GLOB instruments CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/instruments/*.toml)
  file(GLOB controllers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/controllers/*.toml)
  file(GLOB assets CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/text/*.toml
       ${PROJECT_SOURCE_DIR}/tumble/report/assets/*)
  set(content "// Generated: files embedded in the program.\n#include <string_view>\n#include <utility>\n#include <vector>\n")
  set(list "")
  set(instrument_list "")
  set(controller_list "")
  foreach(asset ${assets} ${plans} ${instruments} ${controllers} ${pages})
    get_filename_component(name ${asset} NAME)
    string(MAKE_C_IDENTIFIER ${name} id)
    string(APPEND content "
asm(\".pushsection .rodata\\n.global tumble_asset_${id}\\ntumble_asset_${id}:\\n.incbin \\\"${asset}\\\"\\n\"
    \".global tumble_asset_${id}_end\\ntumble_asset_${id}_end:\\n.byte 0\\n.popsection\\n\");
extern \"C\" const char tumble_asset_${id}[];
extern \"C\" const char tumble_asset_${id}_end[];
namespace tumble::assets {
extern const std::string_view ${id};
const std::string_view ${id}{tumble_asset_${id}, static_cast<std::size_t>(tumble_asset_${id}_end - tumble_asset_${id})};
}
")
    if(asset IN_LIST plans)
      get_filename_component(stem ${asset} NAME_WE)
      string(APPEND list "{\"${stem}\", ${id}}, ")
    elseif(asset IN_LIST instruments)
      get_filename_component(stem ${asset} NAME_WE)
      string(APPEND instrument_list "{\"${stem}\", ${id}}, ")
    elseif(asset IN_LIST controllers)
      get_filename_component(stem ${asset} NAME_WE)
      string(APPEND controller_list "{\"${stem}\", ${id}}, ")
    elseif(asset IN_LIST pages)
      cmake_path(REMOVE_EXTENSION name LAST_ONLY)
      string(APPEND page_list "{\"${name}\", ${id}}, ")
    endif()
  endforeach()
  string(APPEND content "namespace tumble::assets {
extern const std::vector<std::pair<std::string_view, std::string_view>> plans;
const std::vector<std::pair<std::string_view, std::string_view>> plans{${list}};
extern const std::vector<std::pair<std::string_view, std::string_view>> instruments;
const std::vector<std::pair<std::string_view, std::string_view>> instruments{${instrument_list}};
extern const std::vector<std::pair<std::string_view, std::string_view>> controllers;
const std::vector<std::pair<std::string_view, std::string_view>> controllers{${controller_list}};
extern const std::vector<std::pair<std::string_view, std::string_view>> pages;
const std::vector<std::pair<std::string_view, std::string_view>> pages{${page_list}};
}
")
  set(output ${PROJECT_BINARY_DIR}/generated/tumble/assets.cpp)
  file(CONFIGURE OUTPUT ${output} CONTENT "${content}" @ONLY)
  set_source_files_properties(${output} PROPERTIES OBJECT_DEPENDS "${assets};${plans};${instruments};${controllers};${pages}")
  set(${result} ${output} PARENT_SCOPE)
endfunction()
