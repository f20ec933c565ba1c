# The pages of the workbench (web/): TypeScript bundled by esbuild, packed by gzip. The list of files that the program
# carries is returned; it is empty where esbuild is missing, and CMake says so. Nothing of npm is needed:
# tsconfig.bundle.json leads to third_party/web, also where npm has put other copies beside the pages for their tests.
function(tumble_web result)
  set(${result} "" PARENT_SCOPE)
  if(NOT TUMBLE_WEB)
    return()
  endif()
  find_program(TUMBLE_ESBUILD esbuild)
  find_program(TUMBLE_GZIP gzip)
  mark_as_advanced(TUMBLE_ESBUILD TUMBLE_GZIP)
  if(NOT TUMBLE_ESBUILD OR NOT TUMBLE_GZIP)
    message(WARNING "esbuild or gzip was not found (Debian: esbuild, gzip): the program will have no pages for `tumble serve`. "
                    "-DTUMBLE_WEB=OFF says that this is intended.")
    return()
  endif()
  set(web ${PROJECT_SOURCE_DIR}/web)
  set(output ${PROJECT_BINARY_DIR}/web)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${web}/src/*.ts ${web}/src/*.tsx ${web}/src/*.css)
  file(GLOB_RECURSE vendored CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/third_party/web/*)
  add_custom_command(
    OUTPUT ${output}/app.js ${output}/app.css VERBATIM DEPENDS ${sources} ${vendored} ${web}/tsconfig.bundle.json
    COMMAND ${TUMBLE_ESBUILD} ${web}/src/app.tsx --bundle --minify
            --outfile=${output}/app.js --format=esm --target=es2020 --charset=utf8 --log-level=warning
            --legal-comments=none --jsx=automatic --jsx-import-source=preact --tsconfig=${web}/tsconfig.bundle.json
            --log-override:import-is-undefined=error
    COMMENT "Bundling the pages of the workbench")
  set(packed "")
  foreach(file ${output}/app.js ${output}/app.css ${web}/index.html ${web}/openapi.json)
    get_filename_component(name ${file} NAME)
    add_custom_command(OUTPUT ${output}/${name}.gz VERBATIM DEPENDS ${file}
                       COMMAND sh -c "\"$1\" -9 -n -c \"$2\" > \"$3\"" sh ${TUMBLE_GZIP} ${file} ${output}/${name}.gz)
    list(APPEND packed ${output}/${name}.gz)
  endforeach()
  set(${result} ${packed} PARENT_SCOPE)
endfunction()
