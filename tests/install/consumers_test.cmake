# Compiles the library as packagers and other projects do, and compares what a program writes that uses it with what
# `gpvc texture` wrote, byte for byte. KIND shared: one libgpvc.so, installed, moved, found by find_package and by pkg-config.
# KIND fetched: along with a project, by FetchContent.
#   cmake -DKIND=shared -DROOT=TREE -DSCRATCH=DIR -DCITY=DIR -DEXPECTED=DIR -DGENERATOR=Ninja -DCXX_COMPILER=c++ -DLAUNCHER=
#         -P consumers_test.cmake
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${SCRATCH})
set(source ${ROOT}/tests/install)
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endfunction()
function(expect_same_model program)
  run(${program} ${CITY}/colmap ${CITY}/mesh.ply ${SCRATCH}/textured)
  foreach(file labels.npy model.obj model_0.jpg model.glb preview.png)
    run(${CMAKE_COMMAND} -E compare_files ${EXPECTED}/${file} ${SCRATCH}/textured/${file})
  endforeach()
  file(REMOVE_RECURSE ${SCRATCH}/textured)
endfunction()
set(options -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
            -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})

if(KIND STREQUAL fetched)
  run(${CMAKE_COMMAND} ${options} -S ${source} -B ${SCRATCH}/build -DGPVC_SOURCE=${ROOT})
  run(${CMAKE_COMMAND} --build ${SCRATCH}/build --target outsider)
  expect_same_model(${SCRATCH}/build/outsider)
  return()
endif()

run(${CMAKE_COMMAND} ${options} -S ${ROOT} -B ${SCRATCH}/build -DBUILD_SHARED_LIBS=ON)
run(${CMAKE_COMMAND} --build ${SCRATCH}/build)
run(${CMAKE_COMMAND} -DBUILD=${SCRATCH}/build -DSOURCE=${source} -DSCRATCH=${SCRATCH}/install -DCITY=${CITY} -DEXPECTED=${EXPECTED}
    -DBUILD_TYPE=Release -DGENERATOR=${GENERATOR} -DCXX_COMPILER=${CXX_COMPILER} -DCXX_FLAGS= -P ${source}/install_test.cmake)
file(GLOB_RECURSE library ${SCRATCH}/install/prefix/libgpvc.so)
cmake_path(GET library PARENT_PATH folder)
execute_process(COMMAND nm -DC --defined-only ${library} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" symbols "${symbols}")
list(FILTER symbols EXCLUDE REGEX "gpvc")
if(symbols)
  message(FATAL_ERROR "libgpvc.so shows symbols of others: ${symbols}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${folder}/pkgconfig pkg-config --cflags --libs gpvc
                OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags)
run(${CXX_COMPILER} -std=c++20 ${source}/outsider.cpp -o ${SCRATCH}/by_pkg_config ${flags} -Wl,-rpath,${folder})
expect_same_model(${SCRATCH}/by_pkg_config)
