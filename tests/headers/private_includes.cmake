# cmake -DROOT=TREE -DPUBLIC=HEADER,HEADER... -P private_includes.cmake: fails where a library includes a header of
# another that is not public. PUBLIC: what gpvc_install_library() was given. A library that is not installed has no public
# headers to choose from; the other parts of the program may include any of its.
cmake_minimum_required(VERSION 3.25)
string(REPLACE "," ";" PUBLIC "${PUBLIC}")

# The library that a file belongs to: its folder, and that below app/.
function(library_of file result)
  string(REGEX MATCH "^(app/)?[^/]+" library "${file}")
  set(${result} ${library} PARENT_SCOPE)
endfunction()

set(installed "")
foreach(header ${PUBLIC})
  library_of(${header} library)
  list(APPEND installed ${library})
endforeach()
list(REMOVE_DUPLICATES installed)

set(includes 0)
set(faults "")
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/io/*.h ${ROOT}/io/*.cpp ${ROOT}/visibility/*.h ${ROOT}/visibility/*.cpp
  ${ROOT}/labeling/*.h ${ROOT}/labeling/*.cpp ${ROOT}/atlas/*.h ${ROOT}/atlas/*.cpp ${ROOT}/app/*.h ${ROOT}/app/*.cpp)
foreach(source ${sources})
  library_of(${source} own)
  get_filename_component(folder ${source} DIRECTORY)
  file(STRINGS ${ROOT}/${source} lines REGEX "^#include [<\"]")
  foreach(line ${lines})
    # Ours by "PATH", from the top of the tree or the file's folder; <gpvc/PATH> is how others include them.
    string(REGEX REPLACE "^#include [<\"](gpvc/)?([^>\"]+)[>\"].*" "\\2" header "${line}")
    if(line MATCHES "<" AND NOT line MATCHES "<gpvc/")
      continue()
    endif()
    if(EXISTS ${ROOT}/${folder}/${header})
      cmake_path(SET header NORMALIZE ${folder}/${header})
    endif()
    math(EXPR includes "${includes} + 1")
    library_of(${header} library)
    if(library STREQUAL own OR NOT library IN_LIST installed OR header IN_LIST PUBLIC)
      continue()
    endif()
    string(APPEND faults "  ${source} includes ${header}\n")
  endforeach()
endforeach()

if(includes LESS 1000)
  message(FATAL_ERROR "only ${includes} includes were found: the check looks at the wrong files")
endif()
if(faults)
  message(FATAL_ERROR "private headers of other libraries are included:\n${faults}")
endif()
message(STATUS "${includes} includes looked at")
