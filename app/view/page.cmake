# Bundles the page of `gpvc view` (page/) and writes it as a C++ source that defines gpvc::view::page_files(). Included, it adds the
# command for that, page_source being its output; as a script, it is the command:
#   cmake -DSOURCE=FOLDER -DWORK=FOLDER -DMODULES=NODE_MODULES -DNPM=FILE -DNODE=FILE -DOUTPUT=FILE.cpp -P page.cmake
# The packages three and esbuild come from MODULES, or else from npm, in the versions of page/package-lock.json. Where they
# cannot be had, the source is one without a page, and the program says so.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  find_program(GPVC_NODE node)
  find_program(GPVC_NPM npm)
  set(page_source ${CMAKE_CURRENT_BINARY_DIR}/page_files.cpp)
  file(GLOB page_parts CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/view/page/*)
  set(modules "${GPVC_NODE_MODULES}")
  add_custom_command(
    OUTPUT ${page_source}
    COMMAND ${CMAKE_COMMAND} -DSOURCE=${CMAKE_CURRENT_SOURCE_DIR}/view/page -DWORK=${CMAKE_CURRENT_BINARY_DIR}/page
            "-DMODULES=${modules}" "-DNODE=${GPVC_NODE}" "-DNPM=${GPVC_NPM}" -DOUTPUT=${page_source}
            -P ${CMAKE_CURRENT_SOURCE_DIR}/view/page.cmake
    DEPENDS ${page_parts} ${CMAKE_CURRENT_SOURCE_DIR}/view/page.cmake
    COMMENT "Bundling the page of gpvc view"
    VERBATIM)
  return()
endif()

# write_source(NAME TYPE FILE ...): writes the source with these files.
function(write_source)
  set(parts "")
  set(listed "")
  set(given ${ARGN})
  while(given)
    list(POP_FRONT given name type file)
    file(READ ${file} content)
    # A literal may hold 64 KiB portably; GCC and Clang take any length.
    string(MAKE_C_IDENTIFIER ${name} id)
    string(APPEND parts "constexpr char k_${id}[] = R\"PAGE(${content})PAGE\";\n")
    string(APPEND listed "    {\"${name}\", \"${type}\", {k_${id}, sizeof k_${id} - 1}},\n")
  endwhile()
  set(body "  return {};")
  if(listed)
    set(body "  static constexpr PageFile kFiles[] = {\n${listed}  };\n  return kFiles;")
  endif()
  file(WRITE ${OUTPUT} "// Made by app/view/page.cmake.
#include \"app/view/page_files.h\"

namespace gpvc::view {
namespace {
${parts}
}  // namespace

std::span<const PageFile> page_files() {
${body}
}

}  // namespace gpvc::view
")
endfunction()

set(found FALSE)
if(NODE AND MODULES AND EXISTS ${MODULES}/three AND EXISTS ${MODULES}/.bin/esbuild)
  set(found TRUE)
elseif(NODE AND NPM)
  file(MAKE_DIRECTORY ${WORK})
  set(MODULES ${WORK}/node_modules)
  file(SHA256 ${SOURCE}/package-lock.json wanted)
  set(had "")
  if(EXISTS ${WORK}/installed)
    file(READ ${WORK}/installed had)
  endif()
  if(NOT had STREQUAL wanted)
    file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json DESTINATION ${WORK})
    execute_process(COMMAND ${NPM} ci --ignore-scripts --silent --no-audit --no-fund WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed
                    OUTPUT_QUIET ERROR_QUIET TIMEOUT 180)
    if(failed EQUAL 0)
      file(WRITE ${WORK}/installed ${wanted})
      set(found TRUE)
    endif()
  else()
    set(found TRUE)
  endif()
endif()
if(found)
  file(MAKE_DIRECTORY ${WORK})
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${MODULES} ${MODULES}/.bin/esbuild ${SOURCE}/main.js --bundle --minify
            --format=esm --target=es2022 --legal-comments=eof --charset=utf8 --outfile=${WORK}/view.js --log-level=warning
    RESULT_VARIABLE failed)
  if(NOT failed EQUAL 0)
    message(FATAL_ERROR "the page of gpvc view cannot be bundled")
  endif()
  write_source(index.html text/html ${SOURCE}/index.html view.css text/css ${SOURCE}/view.css view.js text/javascript ${WORK}/view.js)
else()
  message("The page of gpvc view is left out: node and the npm packages three and esbuild were not there and could not "
          "be installed. Without ${OUTPUT} the next build tries again")
  write_source()
endif()
